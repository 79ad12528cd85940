#!/usr/bin/env bash
# The same recording gives the same files, byte by byte; the same simulation too.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

for i in 1 2; do
  "$plumbline" run --config "$config" --dataset "$recording" --trajectory "$i.tum" --landmarks "$i.ply" 2> /dev/null
done
cmp 1.tum 2.tum || fail "two runs differ"
cmp 1.ply 2.ply || fail "the landmarks of two runs differ"
grep -q 'element vertex [1-9]' 1.ply || fail "no landmarks"

rm -rf again
"$plumbline" simulate --scene room --out again --duration 1 > /dev/null 2>&1
diff -r "$recording" again || fail "two simulations differ"
finish
