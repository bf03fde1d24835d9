#!/usr/bin/env bash
# Runs one test program in the guest machine and shows what it wrote.
#   in_guest.sh SHARE TEST   SHARE: scratch folder; TEST: guest_TEST_test of the aarch64 build, and its devices in guest_TEST.job
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
share=$1 test=$2

rm -rf "$share"
mkdir -p "$share"
cp "$here/../../../build/aarch64-linux/bin/guest_${test}_test" "$share/"
cp "$here/guest_$test.job" "$share/job"
status=0
"$here/../../../hil/vm/boot" --timeout 240 "$share" || status=$?
cat "$share/console.log"
exit "$status"
