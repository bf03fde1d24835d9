#!/usr/bin/env bash
# Makes the guest machine and, cross-compiled, what the tests run in it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
hil/vm/prepare
toolchains/sysroot.sh aarch64-linux
cmake --preset aarch64-linux
cmake --build --preset aarch64-linux -j "${JOBS:-2}" --target guest_tests relnav
