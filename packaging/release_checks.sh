#!/usr/bin/env bash
# What takes hours, before a release: packaging/release_checks.sh [fuzz] [soak] [packages], all of them by default.
#   fuzz      every fuzz target, RUNS inputs each (1000000); builds the preset asan-ubsan
#   soak      simulated recordings of LENGTH s (600) with a map, COUNT of them (12), by PROGRAM; each frame has a pose
#   packages  packaging/check.sh
# Prints the seconds that each part took.
set -euo pipefail
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$source"
program=${PROGRAM:-$source/build/release/benchmarks/plumbline/plumbline}

fuzz() {
  local build=$source/build/asan-ubsan target name found
  [[ -f $build/build.ninja ]] || cmake --preset asan-ubsan > /dev/null
  for target in $(ninja -C "$build" -t targets all | sed -nE 's/^(fuzz_[a-z]+): phony.*/\1/p' | sort); do
    ninja -C "$build" "$target" > /dev/null
    name=${target#fuzz_}
    found=$build/tests/fuzz/found_$name
    (cd "$found" && "$build/tests/fuzz/$target" -runs="${RUNS:-1000000}" -timeout=20 -rss_limit_mb=4096 \
      -print_final_stats=1 -verbosity=0 . "$source/tests/fuzz/corpus/$name")
  done
}

soak() {
  local work length=${LENGTH:-600} seed frames poses scene
  work=$(mktemp -d)
  # shellcheck disable=SC2064
  trap "rm -rf '$work'" RETURN
  for ((seed = 1; seed <= ${COUNT:-12}; ++seed)); do
    scene=$( ((seed % 2)) && echo room || echo corridor)
    "$program" simulate --scene "$scene" --out "$work/recording" --seed "$seed" --duration "$length" > /dev/null
    "$program" run "$work/recording" --map --trajectory "$work/trajectory" > "$work/log"
    frames=$(grep -cv '^#' "$work/recording/rgb.txt")
    poses=$(grep -cvE '^#|nan|inf' "$work/trajectory")
    echo "$scene, seed $seed: $poses poses of $frames frames in $length s"
    ((100 * poses >= 95 * frames)) || { cat "$work/log" >&2; return 1; }
    rm -rf "$work/recording" "$work/trajectory"
  done
}

(($# > 0)) || set -- fuzz soak packages
for part in "$@"; do
  begin=$SECONDS
  case $part in
    fuzz | soak) "$part" ;;
    packages) packaging/check.sh "$program" ;;
    *) sed -n '2,7s/^# //p' "$0" >&2; exit 2 ;;
  esac
  echo "$part: passed in $((SECONDS - begin)) s"
done
