#!/usr/bin/env bash
# Builds the libraries that a target build links, from Debian's source packages, into build/sysroots/PRESET/{include,lib}.
#   toolchains/sysroot.sh PRESET   a preset with a toolchain file toolchains/PRESET.cmake
# A second call does nothing, until one of the inputs changes. Packages: tests/packages/target.txt.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

preset=${1:?usage: toolchains/sysroot.sh PRESET}
toolchain=toolchains/$preset.cmake
[ -f "$toolchain" ] || { echo "toolchains/sysroot.sh: there is no $toolchain" >&2; exit 2; }
root=$PWD/build/sysroots/$preset
sources=$PWD/build/sysroots/sources
packages=(cpputest zlib libpng1.6 yaml-cpp libgpiod)

stamp=$(cat "$toolchain" toolchains/sysroot.sh toolchains/sysroot/* | sha256sum)
[ "$(cat "$root/stamp" 2>/dev/null)" != "$stamp" ] || exit 0

# An apt state of its own: the machine's sources stay as they are, and no foreign architecture is added to it.
fetch() {
  local state=$PWD/build/sysroots/apt
  mkdir -p "$state/lists/partial" "$state/cache/archives/partial" "$sources.part"
  apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
    awk '$2 == "bookworm" && $3 == "main"' | sort -u |
    sed 's|^|deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] |' >"$state/sources.list"
  local apt=(apt-get -q -o "Dir::Etc::sourcelist=$state/sources.list" -o Dir::Etc::sourceparts=/dev/null
    -o "Dir::State::lists=$state/lists" -o "Dir::Cache=$state/cache" -o APT::Sandbox::User=root)
  "${apt[@]}" update
  (cd "$sources.part" && "${apt[@]}" source "${packages[@]}")
  echo "${packages[*]}" >"$sources.part/packages"
  rm -rf "$sources"
  mv "$sources.part" "$sources"
}
if [ "$(cat "$sources/packages" 2>/dev/null)" != "${packages[*]}" ]; then
  rm -rf "$sources.part"
  fetch
fi

rm -rf "$root" "$root.build"
cmake -S toolchains/sysroot -B "$root.build" -G Ninja --toolchain "$PWD/$toolchain" \
  -DSOURCES="$sources" -DCMAKE_INSTALL_PREFIX="$root"
cmake --build "$root.build" -j "${JOBS:-2}"
cmake --install "$root.build"
rm -rf "$root.build"

# Libraries of headers only are the host's.
mkdir -p "$root/share/cmake"
ln -s /usr/include/eigen3 /usr/include/CLI /usr/include/nlohmann "$root/include/"
ln -s /usr/share/cmake/CLI11 /usr/share/cmake/nlohmann_json "$root/share/cmake/"
ln -s /usr/share/eigen3 "$root/share/"
echo "$stamp" >"$root/stamp"
