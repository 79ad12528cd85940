#!/usr/bin/env bash
# run --debug: pictures of the frames, tables that agree with the run, one page with its data; and no other trajectory.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

# The camera of the shared recording is stationary; this one moves.
rm -rf recording* debug thin
"$plumbline" simulate --scene room --out 'recording <b>' --duration 3.2 2> /dev/null
recording='recording <b>'
part=(--config "$config" --dataset "$recording" --start 2.2)
frames=20
"$plumbline" run "${part[@]}" --trajectory plain.tum > /dev/null 2>&1
"$plumbline" run "${part[@]}" --trajectory out.tum --debug debug > out.txt 2> err.txt ||
  fail "run --debug: $(cat err.txt)"
cmp plain.tum out.tum || fail "looking at it changed the trajectory"

pictures=$(find debug/frames -name '??????.jpg' -size +5k | wc -l)
[[ $pictures == "$frames" ]] || fail "$pictures pictures of $frames frames"
[[ -s debug/trajectory.png ]] || fail "no picture of the trajectory"

# column FILE NAME: the values of a column, one a line; an error where there is none, or a row of another length.
column() {
  awk -F, -v name="$2" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i; n = NF; if (!c) exit 1; next }
    NF != n { exit 1 } { print $c }' "$1" || { echo "FAILED: $1: column $2" >&2; return 1; }
}
# all_within FILE NAME LOW HIGH: every value of a column is a number within the bounds.
all_within() {
  column "$1" "$2" | awk -v low="$3" -v high="$4" '$1 == "" || $1 < low || $1 > high { bad = 1 } END { exit bad || !NR }' ||
    fail "$1: $2 is not always between $3 and $4"
}

[[ $(column debug/frames.csv frame | wc -l) == "$frames" ]] || fail "frames.csv does not have a row for each frame"
[[ $(column debug/frames.csv health | sort -u) == tracking ]] || fail "health: $(column debug/frames.csv health | sort -u)"
all_within debug/frames.csv points_located 50 400
all_within debug/frames.csv sigma_position_m 0 0.1
all_within debug/frames.csv total_ms 0 1e6
[[ $(column debug/frames.csv points_lost | sort -u | wc -l) -gt 1 ]] || fail "no point was ever lost"
# Where a frame is no keyframe its points are compared with a map that others made.
median=$(paste -d, <(column debug/frames.csv keyframe) <(column debug/frames.csv points_innovation_median_sigma) |
  awk -F, '$1 == 0 { sum += $2; ++n } END { print n ? sum / n : 0 }')
awk -v median="$median" 'BEGIN { exit !(median > 0.02 && median < 1.5) }' || fail "innovation of $median sigma"

[[ $(column debug/error.csv timestamp_ns | wc -l) == "$frames" ]] || fail "error.csv does not have a row for each pose"
all_within debug/error.csv position_error_m 0 0.05
all_within debug/error.csv nees_pose 0 1e6
"$plumbline" evaluate --reference "$recording/groundtruth.txt" --estimate out.tum > evaluated.txt
# as_evaluated COLUMN ROW: the root mean square of a column is what evaluate finds.
as_evaluated() {
  local rmse
  rmse=$(awk -v row="$2" '$0 ~ "^" row { print $4 }' evaluated.txt)
  column debug/error.csv "$1" |
    awk -v rmse="$rmse" '{ sum += $1 * $1 } END { d = sqrt(sum / NR) - rmse; exit !(d < 1e-5 && d > -1e-5) }' ||
    fail "$1: not the $rmse that evaluate finds"
}
as_evaluated position_error_m 'APE translation'
as_evaluated rotation_error_deg 'APE rotation'

# The page is that of benchmarks/report, byte by byte but for the one line of its data.
page=$(dirname "${BASH_SOURCE[0]}")/../../benchmarks/report/dist/debug.html
place='<script type="application/json" id="plumbline-data">'
cmp <(grep -vF "$place" debug/report.html) <(grep -vF "$place" "$page") || fail "report.html is not the page"
[[ $(grep -cF "$place" debug/report.html) == 1 ]] || fail "report.html has not one line of data"
grep -F "$place" debug/report.html | sed -e "s|^$place||" -e 's|</script>$||' > data.json
grep -q '<' data.json && fail "the data may end its script"
# count MEMBER PATTERN: how often it is in a list of the data.
count() { grep -oE "\"$1\":\[[^]]*\]" data.json | head -n 1 | grep -oE -- "$2" | wc -l; }
for member in t health points_located total_ms position_m; do
  [[ $(count $member '[[,][0-9]') == "$frames" ]] || fail "$(count $member '[[,][0-9]') numbers of $member in the page"
done
[[ $(count pictures 'frames/[0-9]{6}\.jpg') == "$frames" ]] || fail "the page does not show every picture"

rm "$recording"/groundtruth*
"$plumbline" run "${part[@]}" --trajectory out.tum --debug thin --debug-every 7 > /dev/null 2>&1 ||
  fail "run --debug-every"
[[ $(find thin/frames -type f | wc -l) == $(((frames + 6) / 7)) ]] || fail "not every seventh frame"
grep -q '"errors":null' thin/report.html || fail "errors without a truth"
[[ $(wc -l < thin/frames.csv) == $((frames + 1)) && ! -e thin/error.csv ]] || fail "tables without a truth"

run=(run --config "$config" --dataset "$recording" --trajectory other.tum)
expect_error 'debug: exists and is not an empty folder' "${run[@]}" --debug debug
expect_error 'out.tum: exists and is not an empty folder' "${run[@]}" --debug out.tum
expect_error '/dev/null/debug: cannot be made' "${run[@]}" --debug /dev/null/debug
expect_error 'missing.txt: no such file' "${run[@]}" --debug new --reference missing.txt
expect_misuse '--debug-every' "${run[@]}" --debug new --debug-every 0
expect_misuse 'requires --debug' "${run[@]}" --reference plain.tum
[[ ! -e other.tum && ! -e new ]] || fail "files were left behind"
finish
