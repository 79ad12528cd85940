#!/usr/bin/env bash
# Mistakes with a real motion: what the figures of the readings show at once, and what only the run can find out.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
data=$2/rendered_office_mono

run=(run --config mono-imu/points/window --dataset odd --trajectory out.tum)
# odd_readings AWK: the recording with other readings; $2 to $4 are the gyroscope's, $5 to $7 the accelerometer's.
odd_readings() {
  rm -rf odd
  mkdir -p odd/mav0/imu0
  ln -s "$data/mav0/cam0" odd/mav0/cam0
  cp "$data/mav0/imu0/sensor.yaml" odd/mav0/imu0/
  awk -F , -v OFS=, "/^#/ { print; next } { $1; print }" "$data/mav0/imu0/data.csv" > odd/mav0/imu0/data.csv
}

rm -f out.tum
odd_readings '$2 *= 57.3; $3 *= 57.3; $4 *= 57.3'
expect_error 'the gyroscope reads up to .*: is it in degrees instead of radians a second\?' "${run[@]}"
odd_readings '$5 /= 9.81; $6 /= 9.81; $7 /= 9.81'
expect_error 'the accelerometer reads [01].*: is it in g instead of m/s\^2\?' "${run[@]}"
odd_readings '$1 = substr($1, 1, 13)'
expect_error 'are the time stamps in milliseconds instead of nanoseconds\?' "${run[@]}"
odd_readings '$1 = sprintf("%d%s", substr($1, 1, 10) + 3600, substr($1, 11))'
expect_error 'the readings begin .* s after the last image: are they of another clock or time zone\?' "${run[@]}"

# Swapped axes look like any others, until images and readings are put together.
odd_readings 't = $2; $2 = $3; $3 = t; t = $5; $5 = $6; $6 = t'
"$plumbline" "${run[@]}" --duration 12 > /dev/null 2> err.txt || true
grep -qE 'pose in .* frames: camera and gyroscope turn differently in .* \(by .* degrees: are axes, ' err.txt ||
  fail "swapped axes: $(tail -n 1 err.txt)"

# An accelerometer that stops at 9.5 m/s^2, which nobody stated: no frame is sure of its place.
odd_readings 'for (i = 5; i <= 7; ++i) $i = $i > 9.5 ? 9.5 : $i < -9.5 ? -9.5 : $i'
"$plumbline" "${run[@]}" > out.txt 2> err.txt || true
grep -q '^calibration: accelerometer_full_scale is 9.5 m/s^2, not 156.9' out.txt || fail "clipped: $(cat out.txt err.txt)"
if grep -Eq '[1-9][0-9]* tracking' out.txt; then fail "sure of its place: $(cat out.txt)"; fi
finish
