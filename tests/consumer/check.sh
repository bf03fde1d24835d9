#!/usr/bin/env bash
# A project outside builds against the installed package and runs, by find_package and by pkg-config.
#   check.sh BUILD WORK COMPILER [EMULATOR]
set -euo pipefail
build=$1 work=$2 compiler=$3 emulator=${4:-}
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$work"

cmake --install "$build" --component dev --prefix "$work/prefix" >/dev/null
cached() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt"; }
toolchain=$(cached CMAKE_TOOLCHAIN_FILE)
sysroot=$(cached RELNAV_SYSROOT)
cmake -S "$here" -B "$work/find_package" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER="$compiler" \
  ${toolchain:+--toolchain "$toolchain"} ${sysroot:+-DRELNAV_SYSROOT="$sysroot"} -Drelnav_DIR="$work/prefix/lib/cmake/relnav"
cmake --build "$work/find_package"
$emulator "$work/find_package/consumer"

flags=$(PKG_CONFIG_PATH=$work/prefix/lib/pkgconfig pkg-config --cflags --libs relnav)
# shellcheck disable=SC2086
"$compiler" -std=c++20 -O1 ${emulator:+-static} "$here/main.cpp" $flags -o "$work/consumer"
$emulator "$work/consumer"
