#!/usr/bin/env bash
# Images whose lower quarter shows the vehicle: the mask by option and by calibration, and what is wrong with one.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
config=mono/points+lines/window

# make_mask FILE WIDTH HEIGHT ROWS: PGM, white, the rows from ROWS on black.
make_mask() {
  {
    printf 'P5\n%d %d\n255\n' "$2" "$3"
    head -c $(($2 * $4)) /dev/zero | tr '\0' '\377'
    head -c $(($2 * ($3 - $4))) /dev/zero
  } > "$1"
}

rm -rf covered calibrations out.tum
"$plumbline" simulate --scene room --size 320 240 --duration 4 --bonnet 0.25 --out covered > /dev/null 2>&1
make_mask mask.pgm 320 240 179

# ate_of NAME ARGUMENT...: of a run against the truth [m].
ate_of() {
  local name=$1
  shift
  "$plumbline" run covered --config "$config" --trajectory "$name.tum" "$@" > /dev/null 2>&1 || fail "$name: run $*"
  "$plumbline" evaluate --reference covered/groundtruth.txt --estimate "$name.tum" --align sim3 --json > "$name.json"
  grep -oE '"rmse[a-z_]*": *[0-9.e-]+' "$name.json" | head -n 1 | grep -oE '[0-9.e-]+$'
}

ate_of without > without.txt
ate_of with --mask mask.pgm > with.txt
awk -v a="$(cat without.txt)" -v b="$(cat with.txt)" 'BEGIN { exit !(b > 0 && b < 0.02 && b < a) }' ||
  fail "ATE $(cat with.txt) m with the mask, $(cat without.txt) m without"

# In a calibration: relative to its file.
mkdir -p calibrations/masks
cp mask.pgm calibrations/masks/
sed -E 's/^camera:/camera:\n  mask: masks\/mask.pgm/' covered/calibration.yaml > calibrations/masked.yaml
ate_of calibrated --calibration calibrations/masked.yaml > /dev/null
cmp -s with.tum calibrated.tum || fail "the mask of the calibration gives another trajectory than --mask"
"$plumbline" calibration calibrations/masked.yaml --to plain > calibrations/written.yaml 2> /dev/null
ate_of written --calibration calibrations/written.yaml > /dev/null
cmp -s with.tum written.tum || fail "the mask is not in the calibration that was written"

run=(run --config "$config" --dataset covered --trajectory out.tum)
make_mask large.pgm 320 241 100
expect_error 'mask large.pgm: the image is 320 x 241, the calibration has 320 x 240' "${run[@]}" --mask large.pgm
make_mask none.pgm 320 240 240
expect_error 'mask none.pgm: excludes nothing' "${run[@]}" --mask none.pgm
make_mask all.pgm 320 240 0
expect_error 'mask all.pgm: excludes all of the image' "${run[@]}" --mask all.pgm
expect_error 'mask missing.png: cannot be opened' "${run[@]}" --mask missing.png
expect_error 'mask covered/calibration.yaml: not an image' "${run[@]}" --mask covered/calibration.yaml
sed -i 's/mask.pgm/gone.pgm/' calibrations/masked.yaml
expect_error 'mask calibrations/masks/gone.pgm: cannot be opened' "${run[@]}" --calibration calibrations/masked.yaml
[[ ! -e out.tum ]] || fail "a trajectory was left behind"
finish
