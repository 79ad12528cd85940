#!/usr/bin/env bash
# evaluate: what had no partner, several estimates, pictures, and what it refuses.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf ./*
# A circle at 10 Hz; circle FIRST LAST WOBBLE: with an error in the third dimension.
circle() {
  awk -v first="$1" -v last="$2" -v wobble="$3" 'BEGIN { for (i = first; i <= last; ++i)
    printf "%.1f %.6f %.6f %.6f 0 0 0 1\n", i / 10, cos(i / 30), sin(i / 30), wobble * sin(i / 7) }'
}
circle 0 4540 0 > truth.txt
circle 0 4999 0.01 > good.tum
circle 1000 2000 0.05 > worse.tum
circle 4538 9000 0 > late.tum

evaluate=("$plumbline" evaluate --reference truth.txt)
"${evaluate[@]}" --estimate good.tum > out.txt || fail "evaluate"
grep -q '4541 pairs, 459 of 5000 poses without partner' out.txt || fail "partners: $(cat out.txt)"
"${evaluate[@]}" --estimate good.tum --json > out.json
for figure in '"poses": 5000' '"pairs": 4541' '"unpaired": 459'; do
  grep -q "$figure" out.json || fail "JSON without $figure"
done
expect_error 'late.tum: 3 of 4463 poses have a partner among the reference.s 4541: too few to compare' \
  evaluate --reference truth.txt --estimate late.tum

"${evaluate[@]}" --estimate good.tum worse.tum --plot both.png --error-plot errors.png > out.txt || fail "two estimates"
awk '/good.tum$/ && $1 > 0.005 && $1 < 0.009 { ++n } /worse.tum$/ && $1 > 0.03 && $1 < 0.04 { ++n } END { exit n != 2 }' \
  out.txt || fail "two estimates: $(cat out.txt)"
for picture in both.png errors.png; do
  [[ $(head -c 4 $picture | tail -c 3) == PNG && $(wc -c < $picture) -gt 10000 ]] || fail "$picture is no picture"
done
cmp both.png errors.png > /dev/null && fail "both pictures are the same"
[[ $("${evaluate[@]}" --estimate good.tum worse.tum --json | grep -c '"estimate": ') == 2 ]] || fail "JSON of two estimates"

one=(evaluate --reference truth.txt --estimate good.tum)
expect_error 'missing/a.png: cannot be written$' "${one[@]}" --plot missing/a.png
expect_misuse "a.foo: a picture's name must end with .png or .jpg" "${one[@]}" --plot a.foo
expect_misuse 'both --plot and --error-plot name this file' "${one[@]}" --plot a.png --error-plot a.png
cp good.tum mine.png
expect_misuse 'mine.png: --plot would overwrite what is read' evaluate --reference truth.txt --estimate mine.png --plot mine.png

# The truth of the body, held against the camera's.
camera=(evaluate --reference "$2/groundtruth_body.csv" --estimate "$2/groundtruth.txt" --align none)
ape() { awk '/^APE translation/ { print $4 }' "$1"; }
"$plumbline" "${camera[@]}" > out.txt || fail "body and camera"
awk -v ape="$(ape out.txt)" 'BEGIN { exit !(ape > 0.05 && ape < 0.08) }' || fail "body and camera: $(cat out.txt)"
"$plumbline" "${camera[@]}" --to-camera "$2/calibration.yaml" > out.txt || fail "--to-camera"
awk -v ape="$(ape out.txt)" 'BEGIN { exit !(ape < 1e-5) }' || fail "--to-camera: $(cat out.txt)"
sed '/^T_body_camera/,$d' "$2/calibration.yaml" > camera.yaml
expect_error 'camera.yaml: has no T_body_camera$' "${camera[@]}" --to-camera camera.yaml

# Every pose with every other one would be 20 million pairs; these are the 4541 best.
(ulimit -v 400000 && "${evaluate[@]}" --estimate good.tum --max-difference 1e9 > out.txt 2> err.txt) ||
  fail "a large difference: $(cat err.txt)"
grep -q '4541 pairs' out.txt || fail "pairs with a large difference: $(cat out.txt)"

circle 0 100 0 > $'odd\e[31m\nname.tum'
"${evaluate[@]}" --estimate $'odd\e[31m\nname.tum' > out.txt
! grep -q $'\e' out.txt || fail "a control character reached the terminal"
finish
