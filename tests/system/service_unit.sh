#!/usr/bin/env bash
# systemd takes the service unit and the user's declaration without a word, and says so of a unit with a spoilt line.
#   tests/system/service_unit.sh     Packages: systemd
set -euo pipefail
packaging=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../packaging" && pwd)
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
units=$root/usr/lib/systemd/system
mkdir -p "$units" "$root/usr/bin"
cp /lib/systemd/system/*.{target,slice,socket,mount} "$units/"  # what every unit leans on
cp "$packaging/relnav-flight.service" "$units/"
sed 's/^ProtectSystem=/ProtectSistem=/' "$packaging/relnav-flight.service" >"$units/spoilt.service"
install -m 755 /bin/true "$root/usr/bin/relnav-flight"  # the unit is checked, not the program

problems() { systemd-analyze verify --man=no --root="$root" "$units/$1" 2>&1 || echo "systemd-analyze verify failed"; }
found=$(problems relnav-flight.service)
if [ -n "$found" ]; then
  echo "packaging/relnav-flight.service: $found" >&2
  exit 1
fi
if ! problems spoilt.service | grep -q ProtectSistem; then
  echo "systemd-analyze verify does not see an unknown key: this check is worth nothing" >&2
  exit 1
fi
found=$(systemd-sysusers --dry-run "$packaging/relnav.sysusers" 2>&1)
if ! grep -q "user 'relnav'" <<<"$found" && ! getent passwd relnav >/dev/null; then
  echo "packaging/relnav.sysusers: no user relnav comes of it: $found" >&2
  exit 1
fi
