#!/usr/bin/env bash
# `simulate --real-imu`: images along the true path of a recorded flight beside its IMU samples; and its bad input.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
data=$2
flight="$data/imu_only/euroc_V1_02_medium"
camera="$data/euroc_mh01_flight/mav0/cam0/sensor.yaml"
[[ -d $flight && -f $camera ]] || exit 77
cd "$(mktemp -d)"

"$plumbline" simulate --real-imu "$flight" --calibration "$camera" --start 10 --duration 1 --out filmed 2> log.txt ||
  fail "simulate: $(tail -1 log.txt)"
[[ $(find filmed/mav0/cam0/data -name '*.png' | wc -l) == 20 ]] || fail "not 20 images"

# The samples are those of the flight, number for number.
awk -F, '!/^#/ {printf "%s", $1; for (i = 2; i < 8; ++i) printf ",%.12g", $i; print ""}' \
  "$flight/mav0/imu0/data.csv" | tr -d '\r' > flight.csv
grep -v '^#' filmed/mav0/imu0/data.csv > samples.csv
[[ $(wc -l < samples.csv) -ge 199 ]] || fail "$(wc -l < samples.csv) samples in a second"
grep -qvxFf flight.csv samples.csv && fail "a sample that the flight does not have"

# Images fit the samples: the gyroscope and the camera turn alike, at the same time.
"$plumbline" simulate --real-imu "$flight" --calibration "$camera" --start 10 --duration 12 --out longer 2> log.txt ||
  fail "simulate: $(tail -1 log.txt)"
"$plumbline" run --config mono-imu/points/window --dataset longer --trajectory out.tum > log.txt 2>&1 ||
  fail "run: $(tail -1 log.txt)"
error=$("$plumbline" evaluate --reference longer/mav0/state_groundtruth_estimate0/data.csv --estimate out.tum \
  --align posyaw --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["ape"]["translation_m"]["rmse"])')
python3 -c "import sys; sys.exit(not $error < 0.15)" || fail "ATE $error m"

# The truth of another flight jumps by 13 cm, which its IMU does not feel.
"$plumbline" simulate --real-imu "$data/imu_only/euroc_MH_04_difficult" --calibration "$camera" --start 44.9 \
  --duration 0.3 --size 160 160 --out jumps 2> log.txt || fail "simulate: $(tail -1 log.txt)"
grep -q "true positions jump, by 0.130 m at 45.00 s" log.txt || fail "no note about the jump: $(cat log.txt)"

expect_error "cam0/sensor.yaml: no such file; --calibration names that of the camera" \
  simulate --real-imu "$flight" --out nowhere
expect_misuse "true states end before" simulate --real-imu "$flight" --calibration "$camera" --start 900 --out nowhere
expect_misuse "--real-imu" simulate --real-imu "$flight" --scene hall --out nowhere
[[ ! -e nowhere ]] || fail "files were left behind"
finish
