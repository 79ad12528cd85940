#!/usr/bin/env bash
# A map corrects the map frame alone: poses in the world are those of a run without a map, byte for byte.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

for name in rgbd/points/window rgbd-imu/points/window mono/points/window mono-imu/points/window; do
  "$plumbline" list | grep -q "$name" || continue
  rm -f ./*.tum
  "$plumbline" run --config $name --dataset "$recording" --trajectory alone.tum --timing alone.csv > out.txt \
    2> err.txt || continue
  grep -q 'keyframe map' out.txt && fail "$name: times of a map that there is not"
  awk -F, 'NR > 1 && $13 + $14 + $15 + $16 != 0 { bad = 1 } END { exit bad || NR < 2 }' alone.csv ||
    fail "$name: the map takes time without a map"
  "$plumbline" run --config $name --dataset "$recording" --map --trajectory map.tum --trajectory-world world.tum \
    --trajectory-final final.tum --loops loops.csv --timing map.csv > out.txt 2> err.txt || fail "$name: $(cat err.txt)"
  cmp alone.tum world.tum || fail "$name: the map moves the world"
  awk -F, 'NR > 1 { learn += $13; if ($13 + $14 + $15 + $16 > $5 + 0.01) bad = 1 } END { exit bad || !(learn > 0) }' map.csv ||
    fail "$name: times of the map are none, or more than those of the frames"
  grep -qE '^  keyframe map: learn +[0-9.]+ +[0-9.]+ +[0-9.]+ +[0-9.]+$' out.txt || fail "$name: no times of the map"
  grep -qE '^map: [1-9][0-9]* keyframes' out.txt || fail "$name: no summary of the map: $(cat out.txt)"
  head -n 1 loops.csv | grep -q '^timestamp_i_ns,timestamp_j_ns,p_x' || fail "$name: no table of loops"
  [[ $(wc -l < map.tum) == $(wc -l < world.tum) && $(wc -l < final.tum) == $(wc -l < world.tum) ]] ||
    fail "$name: trajectories of different lengths"
done
finish
