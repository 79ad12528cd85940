#!/usr/bin/env bash
# Outputs: none takes the place of another file, all appear together or none does, whatever ends the run.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf ./*
run=(run --config "$config" --dataset "$recording")
expect_misuse 'out.tum: both --trajectory and --timing name this file' "${run[@]}" --trajectory out.tum --timing ./out.tum
expect_misuse 'both --timing and --states' "${run[@]}" --trajectory out.tum --timing a.csv --states "$PWD/a.csv"
expect_misuse '--trajectory: must not be empty' "${run[@]}" --trajectory ''
expect_misuse '--states: must not be empty' "${run[@]}" --trajectory out.tum --states ''

copy_recording mine
truth=$(md5sum < mine/groundtruth.txt)
run_mine=(run --config "$config" --dataset mine)
expect_misuse 'groundtruth.txt: --trajectory would overwrite what is read' "${run_mine[@]}" --trajectory mine/groundtruth.txt
expect_misuse 'rgb.txt: --timing would overwrite' "${run_mine[@]}" --trajectory out.tum --timing mine/rgb.txt
ln -s mine/calibration.yaml link.yaml
expect_misuse 'link.yaml: --landmarks would overwrite' "${run_mine[@]}" --trajectory out.tum --landmarks link.yaml
[[ $(md5sum < mine/groundtruth.txt) == "$truth" ]] || fail "the truth was overwritten"

if [[ -c /dev/full ]]; then
  expect_failure '/dev/full: cannot be written' "${run[@]}" --trajectory out.tum --landmarks out.ply --timing /dev/full
  [[ ! -e out.tum && ! -e out.ply ]] || fail "a trajectory beside a timing that could not be written"
  status=0
  "$plumbline" "${run[@]}" --trajectory out.tum > /dev/full 2> err.txt || status=$?
  [[ $status == 1 ]] || fail "status $status where the summary could not be written"
  grep -q 'stdout: cannot be written' err.txt || fail "stdout: $(tail -1 err.txt)"
  status=0
  "$plumbline" list > /dev/full 2> err.txt || status=$?
  [[ $status == 1 ]] || fail "list: status $status where nothing could be written"
fi

echo mine > out.tum.part
"$plumbline" "${run[@]}" --trajectory out.tum > /dev/null 2>&1 || fail "beside a file of the same name with .part"
[[ $(cat out.tum.part) == mine ]] || fail "somebody's out.tum.part is gone"
rm out.tum out.tum.part

# Asked to stop in the middle: nothing is left. The images are named a hundred times over, or the run would be too short.
awk '/^#/ { next } { n += 1; name[n] = $2 } END { for (i = 0; i < 100 * n; ++i) printf "%.2f %s\n", 1600000000 + i / 20, name[i % n + 1] }' \
  mine/rgb.txt > long.txt
mv long.txt mine/rgb.txt
rm err.txt
sed 's/rgb/depth/' mine/rgb.txt > mine/depth.txt
"$plumbline" "${run_mine[@]}" --trajectory out.tum --timing out.csv > out.txt 2> err.txt &
for ((i = 0; i < 100; ++i)); do
  [[ ! -s err.txt ]] || break
  sleep 0.1
done
[[ -e out.tum.part && -e out.csv.part ]] || fail "the run wrote nothing"
kill -TERM $!
status=0
wait $! || status=$?
[[ $status == 130 ]] || fail "status $status after the signal"
grep -qE 'interrupted after [0-9]+ of 2000 frames; nothing was written' err.txt || fail "interrupted: $(tail -1 err.txt)"
left_behind=$(find . -name 'out.*' ! -name out.txt)
[[ -z $left_behind ]] || fail "left behind: $left_behind"
finish
