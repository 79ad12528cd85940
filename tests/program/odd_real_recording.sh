#!/usr/bin/env bash
# Wrong IMU data with a real motion: what statistics of the samples show, and what only the run can detect.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
skip_without "$2"
data=$2/rendered_office_mono

run=(run --config mono-imu/points/window --dataset odd --trajectory out.tum)
# odd_imu AWK: the recording with changed IMU samples; $2 to $4 are the gyroscope's, $5 to $7 the accelerometer's.
odd_imu() {
  rm -rf odd
  mkdir -p odd/mav0/imu0
  ln -s "$data/mav0/cam0" odd/mav0/cam0
  cp "$data/mav0/imu0/sensor.yaml" odd/mav0/imu0/
  awk -F , -v OFS=, "/^#/ { print; next } { $1; print }" "$data/mav0/imu0/data.csv" > odd/mav0/imu0/data.csv
}

rm -f out.tum
odd_imu '$2 *= 57.3; $3 *= 57.3; $4 *= 57.3'
expect_error 'gyroscope samples are up to .*: is it in degrees instead of radians per second\?' "${run[@]}"
odd_imu '$5 /= 9.81; $6 /= 9.81; $7 /= 9.81'
expect_error 'accelerometer is [01].*: is it in g instead of m/s\^2\?' "${run[@]}"
odd_imu '$1 = substr($1, 1, 13)'
"$plumbline" "${run[@]}" > out.txt 2> err.txt || fail "milliseconds: $(cat err.txt)"
grep -q 'the time stamps are in milliseconds (expected nanoseconds)' err.txt || fail "milliseconds are not said: $(cat err.txt)"
rm -f out.tum
odd_imu '$1 = sprintf("%d%s", substr($1, 1, 10) + 3600, substr($1, 11))'
expect_error 'the IMU samples begin .* s after the last image: do IMU and images have the same clock and time zone\?' "${run[@]}"

# Swapped axes are detected only by comparing the IMU with the images.
odd_imu 't = $2; $2 = $3; $3 = t; t = $5; $5 = $6; $6 = t'
"$plumbline" "${run[@]}" --duration 12 > /dev/null 2> err.txt || true
grep -qE 'pose in .* frames: camera and gyroscope turn differently in .* \(by .* degrees: are axes, ' err.txt ||
  fail "swapped axes: $(tail -n 1 err.txt)"

# An accelerometer that saturates at 9.5 m/s^2, which the calibration does not state: no frame has a sound pose.
odd_imu 'for (i = 5; i <= 7; ++i) $i = $i > 9.5 ? 9.5 : $i < -9.5 ? -9.5 : $i'
"$plumbline" "${run[@]}" > out.txt 2> err.txt || true
grep -q '^calibration: accelerometer_full_scale is 9.5 m/s^2, not 156.9' out.txt || fail "clipped: $(cat out.txt err.txt)"
if grep -Eq '[1-9][0-9]* tracking' out.txt; then fail "tracking with a saturated accelerometer: $(cat out.txt)"; fi
finish
