# shellcheck shell=bash
# Debian packages for tests/run and hil/demo. Sourced, not run.

# need_packages LIST...: makes sure that every package named in the lists is installed. Installs what is missing when
# it may (root, or sudo without a password); otherwise names exactly what is missing and exits with status 2.
need_packages() {
  local list missing=() package
  if ! command -v dpkg-query >/dev/null 2>&1; then
    echo "not a Debian system: please provide what $* name by other means" >&2
    return 0
  fi
  for package in $(cat "$@" | sed -e 's/#.*//'); do
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || missing+=("$package")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  list="${missing[*]}"

  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    if command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; then
      as_root=(sudo -n)
    else
      echo "missing Debian packages: $list" >&2
      echo "install them with: apt-get install --no-install-recommends $list" >&2
      exit 2
    fi
  fi
  echo "installing Debian packages: $list"
  local apt=(env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=600)
  # A stale mirror of something unrelated must not stop us: what counts is whether the install works.
  "${as_root[@]}" "${apt[@]}" update </dev/null || echo "apt-get update failed; trying with the lists at hand" >&2
  if ! "${as_root[@]}" "${apt[@]}" install --no-install-recommends "${missing[@]}" </dev/null; then
    echo "could not install: $list" >&2
    exit 2
  fi
}
