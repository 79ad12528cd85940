#!/usr/bin/env bash
# Wrong units, time stamps and images are reported before the run: found value, expected value, probable cause.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -f out.tum
run=(run --config rgbd-imu/points/window --trajectory out.tum --dataset odd)
# odd_rows FILE AWK: a copy of the recording with the rows of one of its files changed.
odd_rows() {
  copy_recording odd
  awk "/^#/ { print; next } $2" "$recording/$1" > "odd/$1"
}
scale_columns() { echo "{ for (i = $1; i <= $2; ++i) \$i = \$i * $3; print }"; }

odd_rows imu.csv "$(scale_columns 5 7 1/9.81)"
expect_error 'odd/imu.csv: the median norm of the accelerometer is 1, expected 9.8 m/s\^2: is it in g instead of m/s\^2\?' "${run[@]}"
odd_rows imu.csv "$(scale_columns 5 7 0.05)"
expect_error 'accelerometer is 0.49.*has gravity been subtracted' "${run[@]}"
odd_rows imu.csv '{ $3 = 20 * sin(NR / 10); print }'
expect_error 'gyroscope samples are up to [12][0-9].* rad/s: is it in degrees instead of radians per second\?' "${run[@]}"
odd_rows imu.csv '{ sub(/^[0-9]+/, sprintf("%d", $1 + 3600)); print }'
expect_error 'the IMU samples begin 3599.05 s after the last image: do IMU and images have the same clock and time zone\?' "${run[@]}"
odd_rows imu.csv '{ $1 = sprintf("%.6f", ($1 - 1600000000) * 1000 + 1600000000); print }'
expect_error 'IMU sample rate is 0.2 Hz, .*are the time stamps in milliseconds instead of seconds\?' "${run[@]}"
odd_rows imu.csv '{ $1 = sprintf("%.9f", $1 / 1000); print }'
expect_error 'IMU samples end 1.*e\+09 s before the first image: ' "${run[@]}"
odd_rows imu.csv '{ $1 = 1000 * $1; print }'
expect_error 'odd/imu.csv:2: .*time stamp' "${run[@]}"
odd_rows imu.csv 'NR % 10 == 2'
expect_error 'the IMU sample rate is 20 Hz, expected 100 to 1000 Hz$' "${run[@]}"
odd_rows rgb.txt '{ $1 = sprintf("%.6f", 1600000000 + ($1 - 1600000000) * 1000); print }'
cp odd/rgb.txt odd/depth.txt
sed -i 's/rgb/depth/' odd/depth.txt
expect_error 'odd/rgb.txt: the image rate is 0.02 Hz.*in milliseconds instead of seconds\?' "${run[@]}"

copy_recording odd
sed -i 's/scale: 1000 /scale: 100000 /' odd/calibration.yaml
expect_error 'odd/depth.txt: the median depth is 0.0[0-9]* m .* scale of 100000, .*: is it 1000\?' "${run[@]}"
odd_rows depth.txt '{ $1 = sprintf("%.6f", $1 + 100); print }'
expect_error 'odd/depth.txt: no depth image is within 20 ms' "${run[@]}"
copy_recording odd
for image in odd/rgb/*; do
  { printf 'P5 640 480 255\n' && head -c 307200 /dev/zero; } > "$image"
done
expect_error 'odd/rgb.txt: all 6 images looked at are black \(mean 0, contrast 0.0 of 255\)' "${run[@]}"
[[ ! -e out.tum && ! -e out.tum.part ]] || fail "a trajectory was left behind"

# Two faults are two lines; --unchecked runs all the same.
sed -i 's/scale: 1000 /scale: 100000 /' odd/calibration.yaml
status=0
"$plumbline" "${run[@]}" 2> err.txt || status=$?
[[ $status == 1 && $(wc -l < err.txt) == 2 ]] || fail "two faults: $(cat err.txt)"
"$plumbline" "${run[@]}" --unchecked 2> err.txt && fail "a pose without images"
[[ $(grep -c '^plumbline: warning: odd/' err.txt) == 2 ]] || fail "no warnings: $(cat err.txt)"
grep -q 'no pose in 20 frames: few features in 20 of them (0 in sight)' err.txt || fail "why no pose: $(tail -1 err.txt)"

# Odd, but it may work: a warning.
odd_rows imu.csv 'NR < 40 || NR > 120'
"$plumbline" "${run[@]}" --unchecked > /dev/null 2> err.txt || true
grep -q 'warning: odd/imu.csv: no IMU sample for 0.4[01]* s, .* after the first one' err.txt || fail "a gap: $(cat err.txt)"
sed -i 's/rate_hz: 20$/rate_hz: 60/' odd/calibration.yaml
"$plumbline" "${run[@]}" --unchecked > /dev/null 2> err.txt || true
grep -q 'warning: odd/rgb.txt: the image rate is 20 Hz, the calibration has 60 Hz' err.txt ||
  fail "a rate: $(cat err.txt)"

copy_recording odd
sed -i -E 's/(gyroscope_noise_density: ).*/\1 0.1/; s/(accelerometer_noise_density: ).*/\1 2/' odd/calibration.yaml
"$plumbline" "${run[@]}" > /dev/null 2> err.txt || true
[[ $(grep -c 'times quieter than the stated noise density' err.txt) == 2 ]] || fail "stated noise: $(cat err.txt)"

# A good recording is run without a warning.
"$plumbline" run --config "$config" --dataset "$recording" --trajectory out.tum > /dev/null 2> err.txt
if grep -vE ' % \(|imu.csv is not used: the configuration .* is one without an IMU$' err.txt; then fail "something is wrong with a good recording"; fi
finish
