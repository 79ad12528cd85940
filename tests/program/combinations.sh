#!/usr/bin/env bash
# Every configuration of the program on one recording that all of them can do: 8 s in the simulated room, with depth and
# IMU. All keep a pose to the end, within a bound that catches what breaks; a camera alone is judged without its scale.
# Lines alone without depth have a wider one: the room has few, and a path in three dimensions takes many of them (a
# camera alone: 0.11 to 0.63 m over 24 starts).
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf room
"$plumbline" simulate --scene room --out room --duration 8 2> log.txt || fail "simulate: $(tail -1 log.txt)"

# try CONFIG: its ATE and how many poses it has.
try() {
  local config=$1 alignment=se3 truth=room/groundtruth.txt name=${1//\//_} bound=0.05 poses=60
  case $config in
    *-imu/* | *-inertial-* | semi-direct-vio) alignment=posyaw truth=room/groundtruth_body.csv ;;
    mono/*) alignment=sim3 ;;
  esac
  case $config in
    mono/lines/*) bound=0.7 poses=30 ;;  # they lose their way: 41 to 107 poses in six starts, up to 0.27 m
    mono-imu/lines/*) bound=0.3 ;;
  esac
  "$plumbline" run --config "$config" --dataset room --trajectory "$name.tum" 2> "$name.log" > /dev/null || {
    echo "FAILED: $config: $(tail -1 "$name.log")"
    return
  }
  "$plumbline" evaluate --reference $truth --estimate "$name.tum" --align $alignment > "$name.txt" 2>> "$name.log"
  awk -v config="$config" -v bound=$bound -v least=$poses -v poses="$(grep -vc '^#' "$name.tum")" '/^APE translation/ {
    bad = !($4 < bound) || poses < least
    printf "%s%s: ATE %s m, %d poses\n", bad ? "FAILED: " : "", config, $4, poses}' "$name.txt"
}
export plumbline
export -f try
"$plumbline" list | awk '{print $1}' | xargs -P 2 -I{} bash -c 'try {}' | tee results.txt
configurations=$("$plumbline" list | wc -l)
((configurations > 0)) || fail "no configuration"
((configurations == $(wc -l < results.txt))) || fail "not every configuration has a result"
! grep -q FAILED results.txt || fail "$(grep -c FAILED results.txt) of $configurations configurations"
finish
