#!/usr/bin/env bash
# Misspelled and missing names are answered with one line, and with the name that was meant where there is one.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

"$plumbline" list > list.txt
grep -q "^$config  *needs camera, depth " list.txt || fail "list does not name $config and what it needs"
grep -q '^rgbd-inertial-vio  *needs camera, depth, IMU' list.txt || fail "list does not name the published system"
grep -q '^lap-slam  *needs camera *$' list.txt || fail "list does not name lap-slam: $(grep lap list.txt)"
[[ $(grep -c 'recommended for these$' list.txt) == 4 ]] || fail "list recommends: $(grep recommended list.txt)"
[[ $("$plumbline" --version) =~ ^plumbline\ [0-9]+\.[0-9]+\.[0-9]+$ ]] || fail "--version: $("$plumbline" --version)"
"$plumbline" --help > /dev/null || fail "--help"
"$plumbline" run --help | grep -q -- --trajectory || fail "run --help"

expect_misuse 'command' ""
expect_misuse 'command "rum" is unknown.*"run"' rum
expect_misuse 'command "frobnicate" is unknown, known are .*list.*simulate' frobnicate
expect_misuse 'option "--zzz" is unknown, known are .*--config' run --zzz
expect_misuse 'option "--trajektory" is unknown.*"--trajectory"' run --config "$config" --trajektory out.tum
expect_misuse 'option "--cofnig" is unknown.*"--config"' run --cofnig="$config"
expect_misuse '^plumbline: dataset is required$|^plumbline: --dataset is required$' run --config "$config"
expect_misuse '--trajectory: its value is missing$' run "$recording" --trajectory
expect_misuse 'again: not expected here$' run "$recording" again
expect_misuse 'a command is required'
"$plumbline" help > help.txt || fail help
grep -q simulate help.txt || fail "help: $(cat help.txt)"
for command in run evaluate simulate starts faults compare; do
  "$plumbline" help "$command" | grep -q "^  plumbline $command " || fail "help $command has no example"
done
expect_misuse 'configuration "rgbd/point/window" is unknown.*"rgbd/points/window"' \
  run --config rgbd/point/window --dataset "$recording" --trajectory out.tum
run=(run --config "$config" --dataset "$recording" --trajectory out.tum)
for wrong in 0 -1 abc nan inf 1e300 ''; do
  expect_misuse "--duration: \"$wrong\" is not a number from 0.001 to 10000000 s" "${run[@]}" --duration "$wrong"
done
for wrong in -1 soon nan inf; do
  expect_misuse "--start: \"$wrong\" is not a number from 0 to 10000000 s" "${run[@]}" --start "$wrong"
done
for wrong in -1 1.5 x; do
  expect_misuse "--seed: \"$wrong\" is not a whole number from 0 to 1" simulate --out nowhere --seed "$wrong"
done
expect_misuse '--debug-every: "0" is not a whole number from 1' "${run[@]}" --debug folder --debug-every 0
expect_misuse '--max-difference: "-1" is not a number from 0' evaluate --reference a --estimate b --max-difference -1
for option in --config --calibration --debug; do
  expect_misuse "$option: must not be empty" "${run[@]}" "$option" ''
done
expect_misuse '--drop: "0.9" is not a number from 0 to 0.7' simulate --out nowhere --drop 0.9
expect_misuse '--readout: "1" is not a number from 0 to 0.05 s' simulate --out nowhere --readout 1
expect_misuse '--stop 5 3: ends before it begins' simulate --out nowhere --stop 5 3
expect_error 'no such directory' run --config "$config" --dataset $'a\e[31mb\nc' --trajectory out.tum
! grep -q $'\e' err.txt || fail "a control character reached the terminal"
expect_misuse 'option "--referense" is unknown.*"--reference"' evaluate --referense a --estimate b
expect_error 'missing.txt' evaluate --reference missing.txt --estimate missing.txt
expect_misuse 'scene "lobby" is unknown, known are .*room' simulate --scene lobby --out nowhere
[[ ! -e out.tum && ! -e nowhere ]] || fail "files were left behind"
finish
