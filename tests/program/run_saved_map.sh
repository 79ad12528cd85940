#!/usr/bin/env bash
# A map is saved, found again by another run, extended or not, printed and exported; other files are refused.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf walk
"$plumbline" simulate --scene room --out walk --duration 6 --size 320 240 > /dev/null 2>&1
for name in rgbd/points/window mono/points/window rgbd-imu/points/window mono-imu/points/window; do
  "$plumbline" list | grep -q "$name" || continue
  run=(run --config "$name" --dataset walk)
  "$plumbline" "${run[@]}" --trajectory first.tum --save-map room.map > out.txt 2> err.txt || continue
  "$plumbline" map room.map --ply room.ply --colmap colmap > out.txt 2> err.txt || fail "$name: $(cat err.txt)"
  grep -qE '^room.map: [1-9][0-9]* keyframes of 1 worlds, [0-9]+ features, [1-9][0-9]* of them points' out.txt ||
    fail "$name: $(cat out.txt)"
  points=$(grep -oE '[0-9]+ of them points' out.txt | grep -oE '^[0-9]+')
  [[ $(grep -cE '^[-0-9]' room.ply) == "$points" ]] || fail "$name: points of the PLY"
  [[ $(grep -c 'png$' colmap/images.txt) -gt 0 && -s colmap/points3D.txt && -s colmap/cameras.txt ]] ||
    fail "$name: COLMAP"
  cp room.map before.map
  "$plumbline" "${run[@]}" --trajectory found.tum --load-map room.map --localize > out.txt 2> err.txt ||
    fail "$name: $(cat err.txt)"
  cmp room.map before.map || fail "$name: the map has changed"
  grep -q ', 1 relocalizations' out.txt || fail "$name: the map is not found: $(cat out.txt)"
  [[ -s found.tum ]] || fail "$name: no poses in the map"
  "$plumbline" "${run[@]}" --trajectory more.tum --load-map room.map --save-map room.map > out.txt 2> err.txt ||
    fail "$name: $(cat err.txt)"
  grep -q ', 1 relocalizations' out.txt || fail "$name: the map is not found: $(cat out.txt)"
  "$plumbline" map room.map | grep -q 'keyframes of 2 worlds' || fail "$name: $("$plumbline" map room.map)"
done
[[ -s before.map ]] || fail 'no configuration has saved a map'

# A place that is not in the map is not taken for one by a run that sees its own place again.
if "$plumbline" list | grep -q "$config"; then
  rm -rf other loop
  "$plumbline" simulate --scene corridor --out other --duration 3 --size 320 240 > /dev/null 2>&1
  "$plumbline" simulate --scene room --out loop --laps 2 --size 320 240 > /dev/null 2>&1
  "$plumbline" run --config "$config" --dataset other --save-map other.map > out.txt 2> err.txt || fail "$(cat err.txt)"
  "$plumbline" run --config "$config" --dataset loop --load-map other.map --localize > out.txt 2> err.txt ||
    fail "$(cat err.txt)"
  grep -q ', 0 loops, 0 relocalizations' out.txt || fail "its own place is taken for the map: $(cat out.txt)"
  grep -q 'no place of the map was recognized' err.txt || fail "no note: $(cat err.txt)"
fi

head -c 5000 before.map > cut.map
expect_error 'cut.map: its size is not what its header says' map cut.map
expect_error 'out.txt: not a map' "${run[@]}" --trajectory x.tum --load-map out.txt
expect_error 'missing.map: cannot be read' "${run[@]}" --trajectory x.tum --load-map missing.map
expect_misuse '--localize.* --load-map' "${run[@]}" --trajectory x.tum --localize
[[ ! -e x.tum ]] || fail 'a refused map leaves a trajectory'
finish
