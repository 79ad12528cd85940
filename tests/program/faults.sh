#!/usr/bin/env bash
# Images that fail for a while, on a recording with truth: an IMU bridges them, and the error afterward is that of the
# run without.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
skip_without "$2"
data=$2

"$plumbline" faults --config mono-imu/points/window --dataset "$data/euroc_mh01_flight" --fault black missing \
  --for 0.5 --times 3 --json faults.json --markdown faults.md --commit abcdef > table.txt ||
  fail "faults ends with an error"
cat table.txt
# Columns: fault, length, s, median, worst, ratio of the worst, ...
awk '/^(black|missing) / {++rows; if (!($6 < 1.5)) bad = 1} END {exit bad || rows != 2}' table.txt ||
  fail "a gap of half a second costs more than half of the accuracy"

# The same figures as JSON and as Markdown, and the Markdown again from the JSON.
for part in '"kind": "faults"' '"commit": "abcdef"' '"recovered_s": ' \
  '"command": "plumbline faults --config mono-imu/points/window '; do
  grep -qF -- "$part" faults.json || fail "faults.json has no $part: $(cat faults.json)"
done
grep -Eq '^\| black, 0\.5 s \| [01]\.[0-9]+; [0-9.]+ s; [0-9]+ \|$' faults.md ||
  fail "no row of black images: $(cat faults.md)"
grep -q 'commit abcdef' faults.md || fail "faults.md has no commit"
"$plumbline" table faults.json --markdown again.md || fail "no table from faults.json"
cmp faults.md again.md || fail "the table from faults.json is another"

# With depth the images continue alone where the accelerometer is inconsistent with the motion. Where they show little
# at that time the estimate diverges, and is degraded.
"$plumbline" faults --config rgbd-imu/points+lines/window --dataset "$data/rendered_lowtex_rgbd" \
  --fault "accel y inverted" --times 3 > inverted.txt || fail "faults with depth ends with an error"
cat inverted.txt
# Columns: fault, median, worst [m], ratio of the worst, seconds, frames falsely `tracking`, ...; without the fault the
# error is 0.003 to 0.004 m.
awk '/^accel y inverted / {++rows; if (!($4 < 0.02 && $8 < 10)) bad = 1} END {exit bad || rows != 1}' inverted.txt ||
  fail "an inverted axis of the accelerometer makes the estimate diverge"

# Features that are matched wrongly after a visual outage do not determine the pose. Some frames are falsely `tracking`
# without any outage.
"$plumbline" faults --config rgbd-imu/points+lines/window --dataset "$data/rendered_lowtex_rgbd" --fault black --for 2 \
  --times 8 > black.txt || fail "faults with black images ends with an error"
cat black.txt
awk '/ falsely tracking$/ {clean = $(NF - 2)}
  /^black / {++rows; if (!($5 < 0.02 && $8 < 10 + 8 * clean)) bad = 1}
  END {exit bad || rows != 1 || clean > 5}' black.txt ||
  fail "two seconds of black images make the estimate diverge while it is tracking"

"$plumbline" starts --config mono-imu/points/window --dataset "$data/euroc_mh01_flight" --every 8 \
  --json starts.json --markdown starts.md > starts.txt ||
  fail "starts ends with an error"
cat starts.txt
grep -Eq '^[0-9]+ runs: ' starts.txt || fail "no summary of the runs"
grep -Eq '^. .mono-imu/points/window. \| [0-9.]+ s \([0-9.]+ s\) \| [0-9]+ of 3 \| ' starts.md ||
  fail "no row: $(cat starts.md)"
PLUMBLINE_COMMIT=fedcba "$plumbline" table starts.json --markdown again.md || fail "no table from starts.json"
cmp starts.md again.md || fail "the table from starts.json is another"
printf 'before\n<!-- table initialization -->\n<!-- table faults -->\n<!-- origin -->\n' > template.md
"$plumbline" table starts.json faults.json --template template.md > page.md || fail "no page"
for part in '^before$' '^. .mono-imu/points/window. ' '^. black, ' '^plumbline starts --config ' \
  '^plumbline faults --config '; do
  grep -q -- "$part" page.md || fail "the page has no \"$part\": $(cat page.md)"
done
finish
