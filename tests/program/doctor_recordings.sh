#!/usr/bin/env bash
# plumbline doctor on real and rendered recordings: nothing wrong with them, and faults built into a flight are named.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
skip_without "$2"
data=$2

for folder in "$data"/*/; do
  [[ -d $folder/mav0/cam0 || -e $folder/rgb.txt || -e $folder/times.txt ]] || continue
  "$plumbline" doctor "$folder" > out.txt || fail "$folder: $(cat out.txt)"
  ! grep -qE '^(WARN|ERROR)' out.txt || fail "$folder is a good recording: $(cat out.txt)"
done

# altered NAME AWK_OF_IMAGES AWK_OF_SAMPLES: a flight with altered index files.
altered() {
  local flight=$data/euroc_mh01_flight/mav0
  rm -rf "$1"
  mkdir -p "$1/mav0/cam0" "$1/mav0/imu0"
  ln -s "$flight"/cam0/{data,sensor.yaml} "$1/mav0/cam0"
  ln -s "$flight/imu0/sensor.yaml" "$1/mav0/imu0"
  awk -F, -v OFS=, "/^#/ {print; next} {$2; print}" "$flight/cam0/data.csv" > "$1/mav0/cam0/data.csv"
  awk -F, -v OFS=, "/^#/ {print; next} {$3; print}" "$flight/imu0/data.csv" > "$1/mav0/imu0/data.csv"
}
# expect_diagnosis PATTERN ARGUMENT...: the doctor finds an error that matches.
expect_diagnosis() {
  local pattern=$1 status=0
  shift
  "$plumbline" doctor "$@" > out.txt || status=$?
  [[ $status == 1 ]] || fail "$*: status $status"
  grep -qE "^ERROR +$pattern" out.txt || fail "$*: no \"$pattern\" in: $(cat out.txt)"
}
# Time stamps have 19 digits, awk counts with 15 of them.
altered late '$1 = substr($1, 1, 7) sprintf("%012.0f", substr($1, 8) + 110000000)' '$1 = $1'
expect_diagnosis 'time offset .* (109|110|111)\.. ms earlier than stamped: give --time-offset -0\.1(09|10|11) ' late
altered reversed '$1 = $1' '$5 = -$5; $6 = -$6; $7 = -$7'
expect_diagnosis 'accelerometer +the sign of the accelerometer is reversed: in [0-9]+ of [0-9]+ windows' reversed
finish
