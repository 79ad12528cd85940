#!/usr/bin/env bash
# Bags written by ROS's rosbag and by @mcap/core: the trajectory is that of the folder, byte for byte; topics are chosen,
# a bag that is cut off is read as far as it goes, and a folder made of a bag gives the same.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
tests=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
python=/usr/bin/python3  # Debian's: it has rosbag
"$python" -c 'import numpy, PIL, rosbag, sensor_msgs' 2> /dev/null || { echo "skipped: no python3-rosbag"; exit 77; }
skip_without "$recording/rendered_office_mono"
office=$recording/rendered_office_mono
room=$recording/rendered_lowtex_rgbd
rm -rf ./*

camera=752,480,458.683657,457.631257,365.687046,246.761859,-0.283409307,0.0741880233,0.00019359,1.76187114e-05
write() { "$python" "$tests/write_bag.py" "$@"; }
duration=4.5
run() { "$plumbline" run --duration "$duration" --all-poses --trajectory "$1.tum" --states "$1.csv" "${@:2}" > out.txt 2> err.txt; }
calibrated=(--calibration "$office/mav0/cam0/sensor.yaml" --imu-calibration "$office/mav0/imu0/sensor.yaml")

run folder --dataset "$office" || fail "the folder: $(tail -1 err.txt)"
(($(wc -l < folder.tum) > 20)) || fail "the folder: $(wc -l < folder.tum) poses"

expect_same() {
  if run bag --dataset "$1" "${calibrated[@]}"; then
    cmp folder.tum bag.tum || fail "$1: another trajectory than that of the folder"
    cmp folder.csv bag.csv || fail "$1: other states than those of the folder"
  else
    fail "$1: $(tail -1 err.txt)"
  fi
}

for compression in none bz2 lz4; do
  for images in "" --compressed-images; do
    # shellcheck disable=SC2086  # nothing where it is empty
    write "$office" "$compression.bag" --duration 5 --compression "$compression" --camera "$camera" $images
    expect_same "$compression.bag"
  done
done
grep -q 'topics (messages) used: /cam0/image_raw (101), /imu0 (1001), /cam0/camera_info (1)' err.txt ||
  fail "the topics used: $(cat err.txt)"

write "$office" office_0.db3 --duration 5 --camera "$camera"
expect_same office_0.db3

cp "$tests/mcap/package.json" "$tests/mcap/package-lock.json" .
if ! command -v npm > /dev/null || ! npm ci --ignore-scripts --no-audit --no-fund --loglevel=error > npm.txt 2>&1; then
  echo 'MCAP is not compared with @mcap/core: npm does not give it'
else
  write "$office" office.jsonl --duration 5
  for compression in none lz4 zstd; do
    node "$tests/mcap/write_mcap.mjs" office.jsonl "$compression.mcap" "$compression"
    expect_same "$compression.mcap"
  done
  mkdir ros2
  mv zstd.mcap ros2/office_0.mcap
  printf 'rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n    - office_0.mcap\n' > ros2/metadata.yaml
  expect_same ros2
  rm -r office.jsonl none.mcap lz4.mcap
fi

expect_error 'needs IMU samples.* camera_info states no noise of the IMU' run --dataset office_0.db3 \
  --config mono-imu/points/window --trajectory out.tum
expect_error '--image-topic /cam1: no such topic .*there are: /cam0/image_raw \(101\)' run --dataset office_0.db3 \
  --image-topic /cam1 --trajectory out.tum
expect_error 'is a folder of files: topics are chosen of bags' run --dataset "$office" --image-topic /cam1 \
  --trajectory out.tum
echo text > text.bag
expect_error 'text.bag: not a bag: neither ROS 1' run --dataset text.bag --trajectory out.tum

# Cut off in a chunk: what comes before is used, and the byte is named.
size=$(($(stat -c %s none.bag) * 95 / 100))
head -c "$size" none.bag > cut.bag
run cut --dataset cut.bag "${calibrated[@]}" || fail "cut.bag: $(tail -1 err.txt)"
grep -q "cut.bag: the bag is damaged at byte $size of $size and read up to there" err.txt || fail "cut: $(cat err.txt)"
lines=$(($(wc -l < cut.tum) - 1))
((lines > 10)) || fail "cut.bag: $lines poses"
cmp <(head -n "$lines" folder.tum) <(head -n "$lines" cut.tum) || fail "cut.bag: another trajectory"

# As a folder: EuRoC with the IMU, TUM with depth.
"$plumbline" convert lz4.bag euroc "${calibrated[@]}" > out.txt 2> err.txt || fail "convert: $(tail -1 err.txt)"
grep -q 'euroc: 101 frames, 1001 IMU samples, layout euroc' out.txt || fail "convert: $(cat out.txt)"
run converted --dataset euroc "${calibrated[@]}" || fail "converted: $(tail -1 err.txt)"
cmp folder.tum converted.tum || fail "the converted folder gives another trajectory"
run converted --dataset euroc || fail "the calibration of the converted folder: $(tail -1 err.txt)"
(($(wc -l < folder.tum) == $(wc -l < converted.tum))) || fail "the converted folder: $(wc -l < converted.tum) poses"
expect_error 'euroc: exists and is not an empty folder' convert lz4.bag euroc

if [[ -d $room ]]; then
  duration=2.5
  write "$room" room.bag --duration 3 --compression lz4 --camera 640,480,536.1,535.7,321.3,246.2
  write "$room" files.bag --duration 3 --compressed-images --camera 640,480,536.1,535.7,321.3,246.2
  "$plumbline" convert files.bag tum > out.txt 2> err.txt ||
    fail "convert: $(tail -1 err.txt)"
  run room_folder --dataset "$room" --config rgbd/points/window || fail "room: $(tail -1 err.txt)"
  run room_bag --dataset room.bag --config rgbd/points/window || fail "room.bag: $(tail -1 err.txt)"
  run room_tum --dataset tum --config rgbd/points/window || fail "tum: $(tail -1 err.txt)"
  (($(wc -l < room_folder.tum) > 20)) || fail "room: $(wc -l < room_folder.tum) poses"
  cmp room_folder.tum room_bag.tum || fail "room.bag: another trajectory"
  cmp room_folder.tum room_tum.tum || fail "tum: another trajectory"

  # compare: truth and calibration lie beside the bag.
  cp "$room/calibration.yaml" room.calibration.yaml
  for truth in groundtruth.txt groundtruth_body.csv; do
    [[ ! -e $room/$truth ]] || cp "$room/$truth" "room.$truth"
  done
  "$plumbline" compare --config rgbd/points/window --dataset room.bag --json out.json > out.txt 2> err.txt ||
    fail "compare: $(tail -1 err.txt)"
  grep -q '"status": *"ok"' out.json || fail "compare: no run of room.bag"
fi
rm -rf ./*.bag ./*.db3 ros2 node_modules
finish
