#!/usr/bin/env bash
# Files that cannot be decoded are named, counted and skipped; the run continues.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

copy_recording damaged
frames=$(grep -vc '^#' damaged/rgb.txt)
mapfile -t images < <(awk '!/^#/ { print $2 }' damaged/rgb.txt)
mapfile -t depths < <(awk '!/^#/ { print $2 }' damaged/depth.txt)
truncate --size 500 "damaged/${images[3]}"
truncate --size 0 "damaged/${images[5]}"
truncate --size=-20 "damaged/${depths[8]}"
rm "damaged/${images[9]}"
mkfifo "damaged/${images[9]}"

"$plumbline" run --config "$config" --dataset damaged --trajectory out.tum --timing out.csv > out.txt 2> err.txt ||
  fail "run: $(cat err.txt)"
for file in "${images[3]}" "${images[5]}" "${depths[8]}" "${images[9]}"; do
  grep -q "skipped: .*$file" err.txt || fail "$file was skipped without a message"
done
grep -q "^$frames frames: .* 4 skipped, 0 refused" out.txt || fail "the count is wrong: $(cat out.txt)"
[[ $(wc -l < out.tum) == $((frames - 4)) ]] || fail "$(wc -l < out.tum) poses of $((frames - 4))"
[[ $(head -n 1 out.csv) == timestamp_ns,track_ms,estimate_ms,map_ms,total_ms,health,* ]] || fail "header of the timing"
[[ $(wc -l < out.csv) == $((frames - 3)) ]] || fail "$(wc -l < out.csv) rows of timing"
finish
