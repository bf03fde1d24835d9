#!/usr/bin/env bash
# Runs guest_TEST.job in the guest machine and shows what it wrote.
#   in_guest.sh SHARE TEST FILE...   SHARE: scratch folder; FILE: what the job finds beside it, relative to the source tree
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../../.."
share=$1 test=$2
shift 2

rm -rf "$share"
mkdir -p "$share"
cp -r "$@" "$share/"
cp "tests/hil/vm/guest_$test.job" "$share/job"
status=0
hil/vm/boot --timeout 240 "$share" || status=$?
cat "$share/console.log"
exit "$status"
