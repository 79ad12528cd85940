#!/usr/bin/env bash
# What a run reports: the counts, why there is no pose, times and states of each frame; and the configuration it
# takes by itself.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

# A stationary camera without depth.
rm -f out.tum
expect_failure 'no pose in 20 frames: little parallax in 20 of them \(.* degrees of 2, .*must move sideways\); --debug DIR' \
  run --config mono/points/window --dataset "$recording" --trajectory out.tum --timing out.csv --states states.csv
[[ ! -e out.tum ]] || fail "a trajectory without a pose"
[[ $(wc -l < out.csv) == 21 && $(wc -l < states.csv) == 21 ]] || fail "no tables of the frames without a pose"
[[ $(cut -d, -f 6,7 out.csv | sort -u | tail -1) == initializing,aligning ]] || fail "no reason: $(tail -1 out.csv)"

"$plumbline" run --config "$config" --dataset "$recording" --trajectory out.tum --timing out.csv --states states.csv \
  > out.txt 2> err.txt || fail "run: $(cat err.txt)"
grep -q '^20 frames: 20 poses, 20 tracking, 0 degraded, 0 lost, 0 initializing, 0 skipped, 0 refused; 0 resets; ' out.txt ||
  fail "summary: $(cat out.txt)"
[[ $(head -n 1 out.csv) == timestamp_ns,track_ms,estimate_ms,map_ms,total_ms,health,reason,sigma_position_m,sigma_rotation_deg,pyramid_ms,align_ms,follow_ms,map_learn_ms,map_query_ms,map_verify_ms,map_solve_ms ]] ||
  fail "header of the timing"
awk -F, 'NR > 1 && !($6 == "tracking" && $7 == "none" && $8 > 0 && $8 < 0.1 && $9 > 0 && $9 < 5) { exit 1 }' out.csv ||
  fail "times: $(head -n 3 out.csv)"
awk -F, 'NR > 1 { d = $10 + $11 + $12 - $2 } d > 1e-3 || d < -1e-3 { exit 1 }' out.csv || fail "the parts of track_ms"
grep -Eq '^20 frames with a pose \[ms\] +mean +median +99 % +longest$' out.txt || fail "times: $(cat out.txt)"
for stage in pyramid 'alignment of the image' 'alignment of features' pose 'map, keyframes' 'whole frame'; do
  grep -Eq "^  $stage +[0-9.]+ +[0-9.]+ +[0-9.]+ +[0-9.]+$" out.txt || fail "no time of $stage: $(cat out.txt)"
done

# column NAME: its values, one a line.
column() {
  awk -F, -v name="$1" 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) c = i; n = NF; next }
    NF != n || !c { exit 1 } { print $c }' states.csv || fail "column $1"
}
for i in 2 3 4 5 6 7 8; do
  names=(- - p_x p_y p_z q_x q_y q_z q_w)
  paste -d ' ' <(awk -v c=$i '{ print $c }' out.tum) <(column "${names[i]}") |
    awk '{ d = $1 - $2 } d > 1e-6 || d < -1e-6 { exit 1 }' || fail "${names[i]} is not that of the trajectory"
done
paste -d ' ' <(column sigma_position_y) <(column covariance_44) | awk '{ d = $1 * $1 / $2 - 1 } d > 1e-6 || d < -1e-6 { exit 1 }' ||
  fail "sigma and covariance differ"
column readout_s | awk '!($1 >= 0 && $1 < 0.1) { exit 1 }' || fail "readout time"
[[ -z $(column v_x | tr -d '\n') ]] || fail "a velocity without an IMU"

# The configuration that fits what the recording has.
"$plumbline" run --dataset "$recording" --trajectory out.tum > /dev/null 2> err.txt || true
grep -qE '^configuration: rgbd-imu/points(\+lines)?/window, recommended for a camera, depth and an IMU \(' err.txt ||
  fail "configuration with depth and IMU: $(head -1 err.txt)"
copy_recording plain
rm plain/imu.csv
"$plumbline" run --dataset plain --trajectory out.tum > /dev/null 2> err.txt || fail "run without --config: $(cat err.txt)"
grep -qE '^configuration: rgbd/points(\+lines)?/window, recommended for a camera and depth \(' err.txt || fail "configuration with depth: $(head -1 err.txt)"
finish
