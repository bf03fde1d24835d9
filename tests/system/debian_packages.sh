#!/usr/bin/env bash
# The Debian packages of a build: what is in them, that dpkg installs them, what is installed works, and all of it goes again.
#   debian_packages.sh BUILD WORK
set -euo pipefail
build=$1 work=$2
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$work"
mkdir -p "$work"
fail() { echo "debian_packages.sh: $*" >&2; exit 1; }

(cd "$build" && cpack -G DEB -B "$work/made" >"$work/cpack.log" 2>&1) || { cat "$work/cpack.log"; exit 1; }
mapfile -t packages < <(find "$work/made" -name '*.deb' | sort)
[ "${#packages[@]}" -eq 3 ] || fail "${#packages[@]} packages instead of dev, runtime and tools: ${packages[*]}"
package() { printf '%s\n' "${packages[@]}" | grep "/relnav-$1_"; }
field() { dpkg-deb -f "$(package "$1")" "$2"; }
[[ $(field runtime Depends) == *libc6* ]] || fail "runtime depends on '$(field runtime Depends)', without libc6"
[[ $(field tools Depends) == *libpng16* ]] || fail "tools depend on '$(field tools Depends)', without libpng16"
[[ $(field dev Depends) == *libeigen3-dev* ]] || fail "dev depends on '$(field dev Depends)', without libeigen3-dev"

# A root of its own, without the packages that these depend on: they are on this machine.
root=$work/root
mkdir -p "$root/var/lib/dpkg"/{info,updates}
touch "$root/var/lib/dpkg/status"
dpkg_here() { dpkg --root="$root" --force-not-root --force-depends --log=/dev/null "$@" >"$work/dpkg.log" 2>&1 || { cat "$work/dpkg.log"; exit 1; }; }
dpkg_here --install "${packages[@]}"

"$root/usr/bin/relnav-flight" --version
"$root/usr/bin/relnav" --version
for file in lib/systemd/system/relnav-flight.service lib/sysusers.d/relnav.conf lib/udev/rules.d/60-relnav.rules; do
  [ -s "$root/usr/$file" ] || fail "usr/$file is not installed"
done
# Scenarios come with all that they name.
"$root/usr/bin/relnav" sim --scenario "$root/usr/share/relnav/scenarios/stereo.yaml" --for 5 --out "$work/flown"
for file in bin/relnav-plots share/relnav/montecarlo/relnav.sbatch; do
  [ -x "$root/usr/$file" ] || fail "usr/$file is not installed, or cannot be run"
done
# The shipped example is one that can be flown, once what it names is there.
mkdir "$work/flight"
cp "$root/usr/share/doc/relnav-runtime/examples/flight.yaml" "$work/flight/"
capture=$here/../../hil/captures/lights_mono
cp "$capture/target.yaml" "$work/flight/"
cp "$capture/mav0/cam0/sensor.yaml" "$work/flight/cam0.yaml"
"$root/usr/bin/relnav-flight" --check "$work/flight/flight.yaml"

# A project outside finds the libraries where they are now, not where they were built.
cmake -S "$here/../consumer" -B "$work/consumer" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  -Drelnav_DIR="$root/usr/lib/cmake/relnav" >"$work/consumer.log" 2>&1 || { cat "$work/consumer.log"; exit 1; }
cmake --build "$work/consumer" >>"$work/consumer.log" 2>&1 || { cat "$work/consumer.log"; exit 1; }
"$work/consumer/consumer"
grep -rlF "$build" "$root/usr/lib/cmake" "$root/usr/lib/pkgconfig" && fail "these name the build folder"

dpkg_here --purge relnav-dev relnav-runtime relnav-tools
left=$(find "$root" -path "$root/var" -prune -o \( -type f -o -type l \) -print)
[ -z "$left" ] || fail "left behind: $left"
