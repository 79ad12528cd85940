#!/usr/bin/env bash
# What each configuration of the program weighs, compiled by itself as firmware would: CPU time of the compiler, code,
# memory of the estimator, and that no symbol names a part which it does not have. A table in Markdown.
#
#   benchmarks/weigh_configurations.sh [PATTERN]        all, or those that match, e.g. 'rgbd/*/window'
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

pattern=${1:-*}
compiler=${CXX:-g++}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# entries LIST: its lines "name = type", without the blanks.
entries() {
  cat > "$work/list.cmake" << END
include("$PWD/benchmarks/plumbline/configurations.cmake")
foreach(entry IN LISTS plumbline_$1)
  string(REGEX REPLACE " *= *" "=" entry "\${entry}")
  message(NOTICE "\${entry}")
endforeach()
END
  cmake -P "$work/list.cmake" 2>&1
}

# What may not be in the code of a configuration: an extended regular expression. A camera with depth rolls; collinear
# points are on lines, but none is followed from frame to frame.
absent_from() {
  local absent=(testing)  # in none of them
  [[ $1 == *-imu/* ]] || absent+=(Imu Preintegration ImuFactors AlignmentWindow)
  [[ $1 == rgbd* ]] || absent+=(InverseDepthMeasurement DepthSensor RollingShutter ReadoutEstimate ReadoutDerivatives)
  [[ $1 == *points* || $1 == mono*/lines/* ]] || absent+=(PointKind PointFlow)
  [[ $1 == *lines* ]] || absent+=(EdgeFollowing)
  [[ $1 == *lines* || $1 == *collinear* ]] || absent+=(LineKind)
  [[ $1 == *collinear* ]] || absent+=(CollinearKind CollinearSegments CollinearTerms)
  [[ $1 == */direct ]] || absent+=(DirectBackend FrameSolve ImageAligner)
  local IFS='|'
  echo "[^A-Za-z](${absent[*]})"
}

echo '| configuration | compiled in | code | memory |'
echo '| --- | --- | --- | --- |'
while IFS='=' read -r sensors rig; do
  while IFS='=' read -r features set; do
    while IFS='=' read -r backend policy; do
      name=$sensors/$features/$backend
      # shellcheck disable=SC2053  # a pattern
      [[ $name == $pattern ]] || continue
      cat > "$work/use.cpp" << END
#include <type_traits>

#include "plumbline/plumbline.hpp"

namespace pl = plumbline;
using MonoCamera = pl::Mono<pl::Pinhole<float, pl::RadTan>, 752 * 480>;
using RgbdCamera = pl::Rgbd<pl::Pinhole<float, pl::RadTan>, 752 * 480>;
template <class Sensors>
using LinesAlone = std::conditional_t<Sensors::has_depth, pl::Features<pl::Lines<160>>,
                                      pl::Features<pl::InitializationPoints<200>, pl::Lines<100>>>;
using Sensors = $rig;
using Vio = pl::Estimator<Sensors, $set, $policy>;

alignas(Vio) unsigned char memory[sizeof(Vio)];
Vio* make(const Sensors& sensors) { return new (memory) Vio{sensors}; }
bool use(Vio& vio, const Vio::Frame& frame) { return bool(vio.add_frame(frame)); }
END
      TIMEFORMAT='%U %S'
      read -r user system < <({ time "$compiler" -std=c++20 -O2 -DNDEBUG -Iinclude -isystem "${EIGEN:-/usr/include/eigen3}" \
        -c "$work/use.cpp" -o "$work/use.o" 2> "$work/errors"; } 2>&1) || true
      [[ -f $work/use.o ]] || { cat "$work/errors" >&2; exit 1; }
      named=$(nm --demangle --defined-only "$work/use.o" | sed 's/NoImu//g' | grep -oE "$(absent_from "$name").{0,80}" || true)
      [[ -z $named ]] || { printf '%s: what is absent left its name:\n%s\n' "$name" "$named" >&2; exit 1; }
      read -r code _ memory _ < <(size "$work/use.o" | tail -1)
      awk -v name="$name" -v s="$user" -v t="$system" -v code="$code" -v memory="$memory" \
        'BEGIN { printf "| `%s` | %.0f s | %.0f KiB | %.1f MiB |\n", name, s + t, code / 1024, memory / 1048576 }'
      rm "$work/use.o"
    done < <(entries backends)
  done < <(entries features)
done < <(entries sensors)
