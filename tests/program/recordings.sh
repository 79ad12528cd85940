#!/usr/bin/env bash
# Real and rendered recordings with ground truth, where they are: whole, causal, one parameter set, within bounds of the
# absolute trajectory error [m]. The bounds are about 1.4 times what was measured: they catch what breaks, they are no aim.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
data=$2

# within NAME BOUND: every frame has a pose and the error is below the bound.
within() {
  local name=$1 bound=$2
  "$plumbline" run --config "$config" --dataset "$data/$name" --trajectory "$name.tum" 2> log.txt || fail "$name: $(tail -1 log.txt)"
  "$plumbline" evaluate --reference "$data/$name/groundtruth.txt" --estimate "$name.tum" --align se3 > error.txt
  local ate frames poses
  ate=$(awk '/^APE translation/ {print $4}' error.txt)
  frames=$(grep -vc '^#' "$data/$name/rgb.txt")
  poses=$(grep -vc '^#' "$name.tum")
  echo "$name: ATE $ate m, $poses of $frames frames"
  awk -v ate="$ate" -v bound="$bound" 'BEGIN {exit !(ate < bound)}' || fail "$name: ATE $ate m is not below $bound m"
  [[ $poses == "$frames" ]] || fail "$name: $poses poses for $frames frames"
}

within icl_office_kt0_3s 0.009
within rendered_lowtex_rgbd 0.016
within tum_fr1_rpy_first12s 0.125
finish
