#!/usr/bin/env bash
# Misspelled and missing names are answered with one line, and with the name that was meant where there is one.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

"$plumbline" list | grep -qx "$config" || fail "list does not name $config"
"$plumbline" list | grep -qx rgbd-inertial-vio || fail "list does not name the published system"
"$plumbline" --help > /dev/null || fail "--help"
"$plumbline" run --help | grep -q -- --trajectory || fail "run --help"

expect_error 'command' ""
expect_error 'command "rum" is unknown.*"run"' rum
expect_error 'option "--trajektory" is unknown.*"--trajectory"' run --config "$config" --trajektory out.tum
expect_error 'option "--cofnig" is unknown.*"--config"' run --cofnig="$config"
expect_error '--trajectory is required' run --config "$config" --dataset "$recording"
expect_error 'configuration "rgbd/point/window" is unknown.*"rgbd/points/window"' \
  run --config rgbd/point/window --dataset "$recording" --trajectory out.tum
expect_error '--duration' run --config "$config" --dataset "$recording" --trajectory out.tum --duration -1
expect_error '--start' run --config "$config" --dataset "$recording" --trajectory out.tum --start soon
expect_error 'option "--referense" is unknown.*"--reference"' evaluate --referense a --estimate b
expect_error 'missing.txt' evaluate --reference missing.txt --estimate missing.txt
expect_error 'lobby' simulate --scene lobby --out nowhere
[[ ! -e out.tum && ! -e nowhere ]] || fail "files were left behind"
finish
