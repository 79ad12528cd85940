#!/usr/bin/env bash
# A walk by hand through a corridor: a shutter that rolls and a camera clock that is late, neither of them told, and a
# sixth of the images missing. Both are found out, and the metre is right to two percent.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf walk
"$plumbline" simulate --scene walk --layout euroc --out walk --duration 14 --readout 0.03 --drop 0.15 --late 0.055 \
  2> log.txt || fail "simulate: $(tail -1 log.txt)"
"$plumbline" run --config mono-imu/points/window --dataset walk --trajectory out.tum --states states.csv > log.txt 2>&1 ||
  fail "run: $(tail -1 log.txt)"
read -r health readout_ms clock_ms < <(awk -F, '
  NR == 1 {for (i = 1; i <= NF; ++i) at[$i] = i}
  END {print $at["health"], 1000 * $at["readout_s"], 1000 * $at["time_offset_s"]}' states.csv)
"$plumbline" evaluate --reference walk/mav0/state_groundtruth_estimate0/data.csv --estimate out.tum --align posyaw \
  > error.txt || fail "evaluate"
scale=$(grep -oE 'scale \(sim3\) [0-9.]+' error.txt | grep -oE '[0-9.]+$')
echo "$health, readout $readout_ms ms, clock $clock_ms ms, scale $scale"
[[ $health == tracking ]] || fail "it ends $health"
awk -v x="$readout_ms" 'BEGIN {exit !(x > 26 && x < 34)}' || fail "readout $readout_ms ms, not 30"
awk -v x="$clock_ms" 'BEGIN {exit !(x > -57 && x < -53)}' || fail "clock $clock_ms ms, not -55"
awk -v x="$scale" 'BEGIN {exit !(x > 0.98 && x < 1.02)}' || fail "scale $scale"
finish
