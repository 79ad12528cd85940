#!/usr/bin/env bash
# Images of 1920 x 1200 pixels are run; larger ones are refused with the largest there may be.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf large
"$plumbline" simulate --scene room --out large --size 1920 1200 --duration 0.15 2> err.txt || fail "simulate: $(cat err.txt)"
"$plumbline" run --config "$config" --dataset large --trajectory out.tum > out.txt 2> err.txt || fail "run: $(cat err.txt)"
grep -q '^3 frames: 3 poses, 3 tracking' out.txt || fail "$(cat out.txt)"
sed -i 's/resolution: .*/resolution: [1920, 1201]/' large/calibration.yaml
expect_error 'images of 1920x1201 are larger than the 2304000 pixels' \
  run --config "$config" --dataset large --trajectory out.tum
finish
