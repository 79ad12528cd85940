#!/usr/bin/env bash
# A walk by hand through a corridor: a shutter that rolls and a camera clock that is late, neither of them told, and a
# sixth of the images missing. Both are found out. Without depth the metre is right to two percent; with depth all begins
# at rest, where nothing tells of the clock.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

# walk_with CONFIGURATION TRUTH ARGUMENT...: simulates and runs; error.txt are the errors.
walk_with() {
  local config=$1 truth=$2
  rm -rf walk
  "$plumbline" simulate --scene walk --out walk --drop 0.15 --late 0.055 "${@:3}" 2> log.txt ||
    fail "simulate: $(tail -1 log.txt)"
  "$plumbline" run --config "$config" --dataset walk --trajectory out.tum --states states.csv > log.txt 2>&1 ||
    fail "run: $(tail -1 log.txt)"
  "$plumbline" evaluate --reference "walk/$truth" --estimate out.tum --align posyaw > error.txt || fail "evaluate"
  read -r health readout_ms clock_ms < <(awk -F, '
    NR == 1 {for (i = 1; i <= NF; ++i) at[$i] = i}
    END {print $at["health"], 1000 * $at["readout_s"], 1000 * $at["time_offset_s"]}' states.csv)
  [[ $health == tracking ]] || fail "$config ends $health"
  awk -v x="$clock_ms" 'BEGIN {exit !(x > -57 && x < -53)}' || fail "$config: clock $clock_ms ms, not -55"
}

walk_with mono-imu/points/window mav0/state_groundtruth_estimate0/data.csv --duration 14 --layout euroc --readout 0.03
scale=$(grep -oE 'scale \(sim3\) [0-9.]+' error.txt | grep -oE '[0-9.]+$')
echo "$health, readout $readout_ms ms, clock $clock_ms ms, scale $scale"
awk -v x="$readout_ms" 'BEGIN {exit !(x > 26 && x < 34)}' || fail "readout $readout_ms ms, not 30"
awk -v x="$scale" 'BEGIN {exit !(x > 0.98 && x < 1.02)}' || fail "scale $scale"

walk_with rgbd-imu/points/window groundtruth_body.csv --duration 10 --readout 0.025
ate=$(awk '/APE translation/ {print $4}' error.txt)
echo "$health, readout $readout_ms ms, clock $clock_ms ms, error $ate m"
awk -v x="$readout_ms" 'BEGIN {exit !(x > 21 && x < 29)}' || fail "readout $readout_ms ms, not 25"
awk -v x="$ate" 'BEGIN {exit !(x < 0.02)}' || fail "error $ate m"
finish
