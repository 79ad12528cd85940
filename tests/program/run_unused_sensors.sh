#!/usr/bin/env bash
# No sensor is left out silently: each that a recording has and a run does not use is one line with the reason.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

# expect_note PATTERN ARGUMENT...: a run says it, whether it succeeds or not.
expect_note() {
  local pattern=$1
  shift
  "$plumbline" run --trajectory out.tum "$@" > /dev/null 2> err.txt || true
  grep -qE -- "$pattern" err.txt || fail "$*: no \"$pattern\" in: $(cat err.txt)"
}

rm -rf kalibr && mkdir kalibr
cat > kalibr/camchain.yaml << 'EOF'
cam0:
  T_cam_imu:
  - [0.0, -1.0, 0.0, 0.0]
  - [0.0, 0.0, -1.0, 0.0]
  - [1.0, 0.0, 0.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  intrinsics: [480, 480, 319.5, 239.5]
  distortion_model: none
  resolution: [640, 480]
EOF
camchain=(--dataset "$recording" --calibration kalibr/camchain.yaml)
expect_note 'note: .*/imu.csv is not used: camchain.yaml states no noise of the IMU \(give imu.yaml with --imu-calibration\)$' "${camchain[@]}"
expect_note 'note: .*/depth.txt is not used: camchain.yaml states no depth scale \(.* --depth-scale, often 1000\)$' "${camchain[@]}"
expect_error 'needs IMU samples.*: camchain.yaml states no noise of the IMU' \
  run --config mono-imu/points/window --trajectory out.tum "${camchain[@]}"
cat > kalibr/imu.yaml << 'EOF'
update_rate: 200
gyroscope_noise_density: 1.7e-4
gyroscope_random_walk: 2.0e-5
accelerometer_noise_density: 2.0e-3
accelerometer_random_walk: 3.0e-3
EOF
expect_note 'note: kalibr/imu.yaml: the noise of the IMU is taken from this file' "${camchain[@]}"
expect_note '^configuration: rgbd-imu/' "${camchain[@]}" --depth-scale 1000
mv kalibr/imu.yaml noise.yaml
expect_note '^configuration: rgbd-imu/' "${camchain[@]}" --depth-scale 1000 --imu-calibration noise.yaml
expect_note 'imu.csv is not used: the configuration rgbd/points/window is one without an IMU$' --config "$config" \
  --dataset "$recording"

# The folder without the name of its option; what is chosen is said with the reason.
"$plumbline" run "$recording" --config "$config" --duration 0.5 > out.txt 2> err.txt || fail "run DIR: $(tail -n 1 err.txt)"
grep -q '^no trajectory is written (--trajectory FILE)$' out.txt || fail "nothing about the trajectory: $(cat out.txt)"
"$plumbline" run "$recording" --duration 0.5 > out.txt 2> err.txt || true  # with an IMU it may be too short for a pose
grep -qE '^configuration: [a-z/+-]+, recommended for a camera, depth and an IMU|this program has none for a camera, depth and' err.txt ||
  fail "no reason for the configuration: $(cat err.txt)"

# The same options and notes for the commands of many runs.
expect_error 'lacks depth$' compare --config "$config" "${camchain[@]}" --json no.json
for command in "compare --json compared.json" "starts --every 1 --duration 0.4 --json starts.json" \
  "faults --fault black --for 0.1 --times 1 --json faults.json"; do
  read -ra words <<< "$command"
  "$plumbline" "${words[@]}" --config "$config" "${camchain[@]}" --depth-scale 1000 > out.txt 2> err.txt ||
    fail "$command: $(tail -n 1 err.txt)"
  grep -q 'note: .*/imu.csv is not used: camchain.yaml states no noise of the IMU' err.txt ||
    fail "$command: nothing about the IMU: $(cat err.txt)"
  expect_error 'nowhere.yaml: no such file' "${words[@]}" --config "$config" --dataset "$recording" --calibration nowhere.yaml
done
sed 's/resolution: .*/resolution: [960, 720]/' kalibr/camchain.yaml > large.yaml
"$plumbline" compare --config "$config" --dataset "$recording" --calibration large.yaml --depth-scale 1000 \
  --json compared.json > out.txt 2> err.txt || fail "compare: $(tail -n 1 err.txt)"
grep -q 'the image is 640 x 480, the calibration has 960 x 720' compared.json || fail "compare has another calibration"
grep -q -- '--calibration camchain.yaml --depth-scale 1000' starts.json || fail "starts: not in its command: $(cat starts.json)"
grep -q -- '--calibration camchain.yaml --depth-scale 1000' faults.json || fail "faults: not in its command"
finish
