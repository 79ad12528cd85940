#!/usr/bin/env bash
# Real and rendered recordings with ground truth, where they are: whole, causal, one parameter set for each sensor class,
# within bounds of the absolute trajectory error [m]. The bounds are 1.3 to 2 times what was measured, or above the worst
# of many starts (points on TUM: 0.011 to 0.046 m, lines with an IMU on EuRoC: 0.17 m): they catch what breaks, they are
# no aim.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
skip_without "$2"
data=$2

# within CONFIG NAME TRUTH ALIGNMENT BOUND MISSING [OPTION ...]: all frames but MISSING have a pose and the error is below
# the bound.
within() {
  local config=$1 name=$2 truth=$3 alignment=$4 bound=$5 missing=$6
  shift 6
  "$plumbline" run --config "$config" --dataset "$data/$name" --trajectory out.tum 2> log.txt ||
    fail "$config $name: $(tail -1 log.txt)"
  "$plumbline" evaluate --reference "$data/$name/$truth" --estimate out.tum --align "$alignment" "$@" > error.txt
  local ate frames poses
  ate=$(awk '/^APE translation/ {print $4}' error.txt)
  frames=$( (cat "$data/$name"/rgb.txt || cat "$data/$name"/mav0/cam0/data.csv || cat "$data/$name"/times.txt) 2> /dev/null | grep -vc '^#')
  poses=$(grep -vc '^#' out.tum)
  echo "$config $name: ATE $ate m, $poses of $frames frames"
  awk -v ate="$ate" -v bound="$bound" 'BEGIN {exit !(ate < bound)}' || fail "$name: ATE $ate m is not below $bound m"
  ((poses >= frames - missing)) || fail "$name: $poses poses for $frames frames"
}

euroc_truth=mav0/state_groundtruth_estimate0/data.csv
within rgbd/points/window icl_office_kt0_3s groundtruth.txt se3 0.007 0
within rgbd/points/window rendered_lowtex_rgbd groundtruth.txt se3 0.025 0
within rgbd/points/window tum_fr1_rpy_first12s groundtruth.txt se3 0.05 0
within rgbd/lines/window icl_office_kt0_3s groundtruth.txt se3 0.002 0
within rgbd/lines/window rendered_lowtex_rgbd groundtruth.txt se3 0.015 0
within rgbd/points+lines/window icl_office_kt0_3s groundtruth.txt se3 0.006 0
within rgbd/points+lines/window rendered_lowtex_rgbd groundtruth.txt se3 0.015 0
within rgbd/points+lines/window tum_fr1_rpy_first12s groundtruth.txt se3 0.02 0
within rgbd-imu/points/window rendered_lowtex_rgbd groundtruth_body.csv posyaw 0.012 20
within rgbd-imu/lines/window rendered_lowtex_rgbd groundtruth_body.csv posyaw 0.009 20
within rgbd-imu/points+lines/window rendered_lowtex_rgbd groundtruth_body.csv posyaw 0.009 20
within mono-imu/points/window rendered_office_mono "$euroc_truth" posyaw 0.01 90
within mono-imu/points/window euroc_mh01_flight "$euroc_truth" posyaw 0.08 49
within mono-imu/lines/window rendered_office_mono "$euroc_truth" posyaw 0.03 90
within mono-imu/lines/window euroc_mh01_flight "$euroc_truth" posyaw 0.2 49
within mono-imu/points+lines/window rendered_office_mono "$euroc_truth" posyaw 0.012 90
within mono-imu/points+lines/window euroc_mh01_flight "$euroc_truth" posyaw 0.08 49
# camera_within CONFIG NAME BOUND MISSING: a camera alone, against the truth of the body that it is on.
camera_within() {
  within "$1" "$2" "$euroc_truth" sim3 "$3" "$4" --to-camera "$data/$2/mav0/cam0/sensor.yaml"
}
for features in points points+lines; do
  camera_within mono/$features/window rendered_office_mono 0.007 90
  camera_within mono/$features/window euroc_mh01_flight 0.04 49
  within mono/$features/window kitti00_first20s poses.txt sim3 2 20
done
camera_within lap-slam rendered_office_mono 0.01 90
camera_within lap-slam euroc_mh01_flight 0.05 49
within lap-slam kitti00_first20s poses.txt sim3 2 20
within rgbd/points/direct tum_fr1_rpy_first12s groundtruth.txt se3 0.025 0
within rgbd/points+lines/direct icl_office_kt0_3s groundtruth.txt se3 0.006 0
within rgbd/points+lines/direct rendered_lowtex_rgbd groundtruth.txt se3 0.012 0
within rgbd/points+lines/direct tum_fr1_rpy_first12s groundtruth.txt se3 0.02 0
within rgbd/lines/direct rendered_lowtex_rgbd groundtruth.txt se3 0.015 0
within rgbd-imu/points+lines/direct rendered_lowtex_rgbd groundtruth_body.csv posyaw 0.009 20
within mono-imu/points/direct euroc_mh01_flight "$euroc_truth" posyaw 0.08 49
within mono-imu/lines/direct euroc_mh01_flight "$euroc_truth" posyaw 0.25 49
within semi-direct-vio euroc_mh01_flight "$euroc_truth" posyaw 0.08 49
camera_within mono/points+lines/direct rendered_office_mono 0.008 90
camera_within mono/points+lines/direct euroc_mh01_flight 0.04 49
camera_within mono/lines/window rendered_office_mono 0.15 90

# Images whose stamps are 50 ms late or early: the time offset is estimated to 1.5 ms.
for shift_ms in 50 -50; do
  name=rendered_office_mono
  shifted=shifted_$shift_ms
  rm -rf "$shifted"
  mkdir -p "$shifted/mav0/cam0"
  for kept in "$data/$name"/mav0/{imu0,state_groundtruth_estimate0} "$data/$name"/mav0/cam0/{data,sensor.yaml}; do
    ln -s "$kept" "$shifted/${kept#"$data/$name/"}"
  done
  while IFS=, read -r stamp image; do
    [[ $stamp == '#'* ]] || stamp=$((stamp + shift_ms * 1000000))
    echo "$stamp,$image"
  done < "$data/$name/mav0/cam0/data.csv" > "$shifted/mav0/cam0/data.csv"
  "$plumbline" run --config mono-imu/points/window --dataset "$shifted" --trajectory out.tum > log.txt 2> /dev/null
  "$plumbline" evaluate --reference "$data/$name/$euroc_truth" --estimate out.tum --align posyaw > error.txt
  ate=$(awk '/^APE translation/ {print $4}' error.txt)
  found_ms=$(awk '/^calibration: time_offset_s is/ {print 1e3 * $4}' log.txt)
  echo "stamps by $shift_ms ms: found $found_ms ms, ATE $ate m"
  awk -v found="${found_ms:-0}" -v shift="$shift_ms" 'BEGIN {d = found + shift; exit !(d * d < 2.25)}' ||
    fail "stamps by $shift_ms ms: found $found_ms ms"
  awk -v ate="$ate" 'BEGIN {exit !(ate < 0.015)}' || fail "stamps by $shift_ms ms: ATE $ate m"
done

finish
