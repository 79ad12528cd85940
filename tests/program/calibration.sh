#!/usr/bin/env bash
# plumbline calibration: what was understood is said in words, and what is written is read as the same.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

cat > euroc.yaml << 'END'
sensor_type: camera
T_BS:
  data: [0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,
         0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,
         -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.654, 457.296, 367.215, 248.375]
distortion_model: radial-tangential
distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
END
mkdir -p elsewhere
cat > elsewhere/imu.yaml << 'END'
rate_hz: 200
gyroscope_noise_density: 1.6968e-04
gyroscope_random_walk: 1.9393e-05
accelerometer_noise_density: 0.8
accelerometer_random_walk: 3.0000e-3
END
# expect_line PATTERN: of out.txt.
expect_line() { grep -qE -- "$1" out.txt || fail "no \"$1\" in: $(cat out.txt)"; }

"$plumbline" calibration euroc.yaml > out.txt 2> err.txt || fail "calibration: $(cat err.txt)"
expect_line '^camera: pinhole with radial-tangential distortion$'
expect_line 'focal lengths +458.654, 457.296 px'
expect_line 'field of view +9[0-9]\.[0-9] degrees across'
expect_line 'position of the camera in the IMU frame \[m\] +-0.02164 -0.06468 +0.00981$'
expect_line 'the camera looks along, in the IMU frame +.*\(about \+z\)$'
expect_line 'the images. right, in the IMU frame +.*\(about \+y\)$'
expect_line '^noise of the IMU: not stated'
"$plumbline" calibration euroc.yaml --imu-calibration elsewhere/imu.yaml > out.txt || fail "with an IMU"
expect_line 'gyroscope noise density +0.0001697 +rad/s/sqrt\(Hz\) +plausible; one sample has a sigma of 0.0024 rad/s'
expect_line 'accelerometer noise density +0.8 +m/s\^2/sqrt\(Hz\) +large: .*the noise of one sample'

# From one format to the other and back; the description as comments says the same each time.
sed -i 's/accelerometer_noise_density: .*/accelerometer_noise_density: 2.0e-3/' elsewhere/imu.yaml
"$plumbline" calibration euroc.yaml --imu-calibration elsewhere/imu.yaml --to kalibr > camchain.yaml 2> err.txt || fail "to kalibr"
grep -q 'note: not in the format kalibr: the rate of the images$' err.txt || fail "what is lost is not said: $(cat err.txt)"
"$plumbline" calibration camchain.yaml --to plain > plain.yaml || fail "to plain"
"$plumbline" calibration plain.yaml --to kalibr > again.yaml || fail "to kalibr again"
rounded() { grep -v '^#' "$1" | sed -E 's/([0-9]\.[0-9]{9})[0-9]*/\1/g'; }
diff <(rounded camchain.yaml) <(rounded again.yaml) || fail "kalibr and back is another calibration"
diff <(grep '^#' camchain.yaml | sed -n '/^# camera and IMU/,$p') <(grep '^#' plain.yaml | sed -n '/^# camera and IMU/,$p') ||
  fail "another description"
sed 's/^camera_model/T_imu_camera: 1\n&/' euroc.yaml > wrong.yaml
expect_error 'wrong.yaml:9: unknown key "T_imu_camera"' calibration wrong.yaml
expect_error 'missing.yaml: no such file' calibration missing.yaml
echo 'fx: 1' > other.yaml
expect_error 'other.yaml: not a camera calibration: read are plumbline \(camera\), Kalibr .* OKVIS .*; known and not read are DepthAI' \
  calibration other.yaml
expect_misuse 'format "kaliber" is unknown, did you mean "kalibr"\?' calibration euroc.yaml --to kaliber
expect_misuse 'file is required' calibration
finish
