#!/usr/bin/env bash
# What composing costs: instructions of the classes that only bring the parts together (include/plumbline/estimator),
# out of all that the library takes for a recording. Each instruction counts for the file of the line that it was
# compiled from, whatever function it was inlined into. A table in Markdown.
#
#   benchmarks/composition_share.sh PLUMBLINE DATASET [PATTERN] [-- OPTION ...]
#
# PLUMBLINE is the program, built with line numbers: cmake --preset release -DCMAKE_CXX_FLAGS=-g1. OPTION are those of
# `plumbline run`. Takes valgrind, and some ten seconds for each second of a recording.
set -euo pipefail

(($# >= 2)) || { sed -n '6,9s/^# *//p' "$0" >&2; exit 2; }
program=$1 dataset=$2
shift 2
pattern='*'
[[ ${1:---} == -- ]] || { pattern=$1; shift; }
[[ ${1:-} != -- ]] || shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# share FILE: instructions of the library, and those of estimator/, of what callgrind wrote to FILE.
share() {
  awk '
    /^c?f[lie]=/ {  # a number is explained once, maybe for the file of what is called
      split($0, id, /[()]/)
      if (id[3] != "") path[id[2]] = id[3]
      if (!/^c/) file = path[id[2]]
      next
    }
    /^calls=/ { called = 1; next }  # the next line is the cost of what is called
    /^[-+*0-9]/ {
      if (!called && file ~ /include\/plumbline\/|eigen|intrin\.h/) all += $2
      if (!called && file ~ /include\/plumbline\/estimator\//) ours += $2
      called = 0
    }
    END { printf "%.0f %.0f\n", all, ours }' "$1"  # %d of mawk ends at 2^31
}

echo '| configuration | instructions a frame | of them composing |'
echo '| --- | --- | --- |'
for name in $("$program" list | awk '$2 == "needs" && /\// { print $1 }'); do
  # shellcheck disable=SC2053  # a pattern
  [[ $name == $pattern ]] || continue
  valgrind --tool=callgrind --callgrind-out-file="$work/out" "$program" run --config "$name" --dataset "$dataset" \
    --trajectory "$work/trajectory.tum" "$@" > "$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
  frames=$(sed -n 's/^\([0-9]*\) frames: .*/\1/p' "$work/log")
  share "$work/out" | awk -v name="$name" -v frames="$frames" \
    '{ printf "| `%s` | %.1f M | %.0f |\n", name, $1 / frames / 1e6, $2 / frames }'
done
