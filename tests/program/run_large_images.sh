#!/usr/bin/env bash
# Images of 1920 x 1200 pixels are run as they are; larger ones are scaled, and so are others by --scale.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf large larger room
"$plumbline" simulate --scene room --out large --size 1920 1200 --duration 0.15 2> err.txt || fail "simulate: $(cat err.txt)"
"$plumbline" run --config "$config" --dataset large --trajectory out.tum > out.txt 2> err.txt || fail "run: $(cat err.txt)"
grep -q '^3 frames: 3 poses, 3 tracking' out.txt || fail "$(cat out.txt)"
! grep -q 'scaled' err.txt || fail "images that fit were scaled: $(cat err.txt)"

"$plumbline" simulate --scene room --out larger --size 2400 1600 --duration 0.15 2> err.txt || fail "simulate: $(cat err.txt)"
"$plumbline" run --config "$config" --dataset larger --trajectory out.tum > out.txt 2> err.txt || fail "run: $(cat err.txt)"
grep -q '^3 frames: 3 poses, 3 tracking' out.txt || fail "$(cat out.txt)"
grep -q 'images of 2400 x 1600 are scaled to 1200 x 800: there is room for 2304000 pixels; --scale chooses' err.txt ||
  fail "no word of the scale: $(cat err.txt)"
sed -i 's/resolution: .*/resolution: [2400, 1610]/' larger/calibration.yaml
expect_error 'the image is 1200 x 800, the calibration has 1200 x 805' \
  run --config "$config" --dataset larger --trajectory out.tum

# With depth, half of the size: as accurate as the whole, to a factor.
"$plumbline" simulate --scene room --out room --size 640 480 --duration 3 2> err.txt || fail "simulate: $(cat err.txt)"
for scale in 1 0.5 0.41; do
  "$plumbline" run --config "$config" --dataset room --scale $scale --trajectory "$scale.tum" > out.txt 2> err.txt ||
    fail "run --scale $scale: $(cat err.txt)"
  "$plumbline" evaluate --reference room/groundtruth.txt --estimate "$scale.tum" --align se3 --json > evaluation.json
  ate=$(grep -oE '"rmse[a-z_]*": *[0-9.e-]+' evaluation.json | head -n 1 | grep -oE '[0-9.e-]+$')
  awk -v ate="$ate" 'BEGIN { exit !(ate > 0 && ate < 0.02) }' || fail "--scale $scale: ATE $ate m"
done
! cmp -s 1.tum 0.5.tum || fail "--scale 0.5 changes nothing"
expect_misuse '"2" is not a number from 0.01 to 1' run --config "$config" --dataset room --scale 2
finish
