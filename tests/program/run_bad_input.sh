#!/usr/bin/env bash
# What can be known to fail is found before the run, and no output is left behind.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

run=(run --config "$config" --trajectory out.tum)
expect_error 'no such directory' "${run[@]}" --dataset missing
mkdir -p empty
expect_error 'empty' "${run[@]}" --dataset empty

expect_error 'missing/out.tum: cannot be written' run --config "$config" --dataset "$recording" \
  --trajectory missing/out.tum
expect_error 'empty: is a directory' run --config "$config" --dataset "$recording" --trajectory empty
expect_error 'missing/t.csv: cannot be written' "${run[@]}" --dataset "$recording" --timing missing/t.csv
expect_error 'missing/l.ply: cannot be written' "${run[@]}" --dataset "$recording" --landmarks missing/l.ply

expect_error 'missing.yaml: no such file' "${run[@]}" --dataset "$recording" --calibration missing.yaml
sed -E 's/(resolution: *)\[.*\]/\1[960, 720]/' "$recording/calibration.yaml" > large.yaml
expect_failure 'calibration has 960 x 720' "${run[@]}" --dataset "$recording" --calibration large.yaml
echo 'camera: [' > broken.yaml
expect_error 'broken.yaml' "${run[@]}" --dataset "$recording" --calibration broken.yaml
expect_error 'no frame' "${run[@]}" --dataset "$recording" --start 1000

copy_recording mono
rm -r mono/depth.txt mono/depth
expect_error 'needs depth images .*: it has no depth images$' "${run[@]}" --dataset mono

left_behind=$(find . -name 'out.tum*' -o -name '*.part')
[[ -z $left_behind ]] || fail "left behind: $left_behind"
finish
