#!/usr/bin/env bash
# Images that fail for a while, on a recording with truth: an IMU bridges them, and the error afterwards is that of the
# run without.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
data=$2

"$plumbline" faults --config mono-imu/points/window --dataset "$data/euroc_mh01_flight" --fault black missing \
  --for 0.5 --times 3 > table.txt || fail "faults ends with an error"
cat table.txt
# Columns: fault, length, s, median, worst, ratio of the worst, ...
awk '/^(black|missing) / {++rows; if (!($6 < 1.5)) bad = 1} END {exit bad || rows != 2}' table.txt ||
  fail "a gap of half a second costs more than half of the accuracy"

# With depth the images go on alone where the accelerometer does not tell of the motion. Where they show little just then
# the estimate leaves them; it says so.
"$plumbline" faults --config rgbd-imu/points+lines/window --dataset "$data/rendered_lowtex_rgbd" \
  --fault "accel y turned" --times 3 > turned.txt || fail "faults with depth ends with an error"
cat turned.txt
# Columns: fault, median, worst [m], ratio of the worst, seconds, frames falsely `tracking`, ...; without it 0.003 to 0.004 m
awk '/^accel y turned / {++rows; if (!($4 < 0.02 && $8 < 10)) bad = 1} END {exit bad || rows != 1}' turned.txt ||
  fail "an axis of the accelerometer that turns leads the estimate away"

# What is followed out of the dark by mistake does not say where the body is. Some frames say `tracking` falsely without
# any darkness.
"$plumbline" faults --config rgbd-imu/points+lines/window --dataset "$data/rendered_lowtex_rgbd" --fault black --for 2 \
  --times 8 > dark.txt || fail "faults in the dark ends with an error"
cat dark.txt
awk '/ falsely tracking$/ {clean = $(NF - 2)}
  /^black / {++rows; if (!($5 < 0.02 && $8 < 10 + 8 * clean)) bad = 1}
  END {exit bad || rows != 1 || clean > 5}' dark.txt ||
  fail "two seconds of darkness lead the estimate away, and it does not say so"

"$plumbline" starts --config mono-imu/points/window --dataset "$data/euroc_mh01_flight" --every 8 > starts.txt ||
  fail "starts ends with an error"
cat starts.txt
grep -Eq '^[0-9]+ starts: ' starts.txt || fail "no summary of the starts"
finish
