#!/usr/bin/env bash
# A hand-held walk through a corridor: a rolling shutter and a late camera, neither of them in the calibration, and a
# sixth of the images missing. Readout time and time offset are estimated. Without depth the scale is right to two
# percent; with depth the recording begins stationary, where the time offset is not observable. Then a slow and even
# motion, in which a map could absorb the distortion by the shutter.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

# run_on SCENE CONFIGURATION TRUTH ARGUMENT...: simulates and runs; health, readout time, time offset and scale at the
# end, error.
run_on() {
  local scene=$1 config=$2 truth=$3
  rm -rf recording
  "$plumbline" simulate --scene "$scene" --out recording "${@:4}" 2> log.txt || fail "simulate: $(tail -1 log.txt)"
  "$plumbline" run --config "$config" --dataset recording --trajectory out.tum --states states.csv > log.txt 2>&1 ||
    fail "run: $(tail -1 log.txt)"
  "$plumbline" evaluate --reference "recording/$truth" --estimate out.tum --align posyaw > error.txt || fail "evaluate"
  read -r health readout_ms offset_ms < <(awk -F, '
    NR == 1 {for (i = 1; i <= NF; ++i) at[$i] = i}
    END {print $at["health"], 1000 * $at["readout_s"], 1000 * $at["time_offset_s"]}' states.csv)
  scale=$(grep -oE 'scale \(sim3\) [0-9.]+' error.txt | grep -oE '[0-9.]+$')
  ate=$(awk '/APE translation/ {print $4}' error.txt)
  echo "$scene, $config: $health, readout $readout_ms ms, time offset $offset_ms ms, scale $scale, error $ate m"
  [[ $health == tracking ]] || fail "$config ends $health"
}
# between NAME VALUE LEAST MOST
between() { awk -v x="$2" -v a="$3" -v b="$4" 'BEGIN {exit !(x > a && x < b)}' || fail "$1 $2, not $3 to $4"; }

euroc=mav0/state_groundtruth_estimate0/data.csv
run_on walk mono-imu/points/window "$euroc" --duration 14 --layout euroc --readout 0.03 --drop 0.15 --late 0.055
between readout "$readout_ms" 27 33
between offset "$offset_ms" -57 -53
between scale "$scale" 0.98 1.02

run_on walk rgbd-imu/points/window groundtruth_body.csv --duration 10 --readout 0.025 --drop 0.15 --late 0.055
between readout "$readout_ms" 22 28
between offset "$offset_ms" -57 -53
between error "$ate" 0 0.02

run_on room mono-imu/points/window "$euroc" --duration 12 --layout euroc --readout 0.025 --seed 13
between readout "$readout_ms" 22 28
between scale "$scale" 0.95 1.05
finish
