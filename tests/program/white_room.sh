#!/usr/bin/env bash
# A white room in which only edges are left: points alone lose track or drift, points and lines do not, with both
# backends.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf room
"$plumbline" simulate --scene room_lowtex --out room --duration 14 2> log.txt || fail "simulate: $(tail -1 log.txt)"

# try CONFIG: prints how many frames were lost, and the ATE.
try() {
  local name=${1//\//_}
  "$plumbline" run --config "$1" --dataset room --trajectory "$name.tum" 2> "$name.log" > "$name.txt" ||
    fail "$1: $(tail -1 "$name.log")"
  "$plumbline" evaluate --reference room/groundtruth.txt --estimate "$name.tum" --align se3 > "$name.error"
  echo "$(cat "$name.txt" "$name.log" | grep -oE '[0-9]+ lost' | tail -1 | cut -d' ' -f1)" \
    "$(awk '/^APE translation/ {print $4}' "$name.error")"
}

for backend in window direct; do
  read -r points_lost points_ate < <(try rgbd/points/$backend)
  read -r lost ate < <(try rgbd/points+lines/$backend)
  echo "$backend: points $points_lost lost, ATE $points_ate m; points+lines $lost lost, ATE $ate m"
  ((points_lost > 0)) || awk -v points="$points_ate" -v both="$ate" 'BEGIN {exit !(points > 1.5 * both)}' ||
    fail "$backend: points alone find enough here: the room is not white"
  ((lost == 0)) || fail "$backend: points and lines lost track in $lost frames"
  awk -v ate="$ate" 'BEGIN {exit !(ate < 0.1)}' || fail "$backend: ATE $ate m"
done
finish
