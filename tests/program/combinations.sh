#!/usr/bin/env bash
# Every configuration of the program on one recording that all of them can do: 8 s in the simulated room, with depth and
# IMU. All keep a pose to the end. The bounds of a sensor class are twice the largest error that one of its
# configurations was measured to have on this recording; a camera alone is judged without its scale. Lines alone without
# depth have wider ones: the room has few, and a path in three dimensions takes many of them.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf room
"$plumbline" simulate --scene room --out room --duration 8 2> log.txt || fail "simulate: $(tail -1 log.txt)"

# try CONFIG: its ATE and how many poses it has.
try() {
  local config=$1 alignment=se3 truth=room/groundtruth.txt name=${1//\//_} bound poses
  case $config in
    *-imu/* | *-inertial-* | semi-direct-vio) alignment=posyaw truth=room/groundtruth_body.csv ;;
    mono/* | lap-slam) alignment=sim3 ;;
  esac
  case $config in  # measured                      ATE at most [m], poses of 160 images
    mono/lines/*) bound=0.24 poses=90 ;;           # 0.120, 104
    mono/* | lap-slam) bound=0.0074 poses=110 ;;   # 0.0037, 122
    mono-imu/lines/*) bound=0.26 poses=76 ;;       # 0.128, 85
    mono-imu/* | semi-direct-vio) bound=0.0117 poses=76 ;;  # 0.0058, 85
    rgbd/*) bound=0.0036 poses=158 ;;              # 0.0018, 160
    rgbd-imu/* | rgbd-inertial-vio) bound=0.005 poses=144 ;;  # 0.0025, 152
    *) bound=0 poses=0 ;;                          # a class without a bound fails
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
