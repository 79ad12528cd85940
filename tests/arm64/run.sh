#!/usr/bin/env bash
# Builds the quick unit tests that need neither OpenCV nor files for Arm 64, and runs them in qemu-aarch64.
#
#   tests/arm64/run.sh BUILD [FOLDER ...]     objects and programs go to BUILD; of these folders of tests/, else of all
#
# Needs g++-aarch64-linux-gnu and qemu-user (Debian).
set -euo pipefail
(($# >= 1)) || { sed -n '2,/^set -/{/^# \{0,1\}/s///p}' "${BASH_SOURCE[0]}" >&2; exit 2; }
build=$(mkdir -p "$1" && realpath "$1")
shift
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
folders=("$@")
((${#folders[@]} > 0)) || folders=(core lie solver camera geometry imu residual image sensor state tracking)

compiler=(aarch64-linux-gnu-g++)
! command -v ccache > /dev/null || compiler=(ccache "${compiler[@]}")
# Catch2 is of headers alone; those of this machine's C library are not to be seen.
mkdir -p "$build/include"
ln -sfn /usr/include/catch2 "$build/include/catch2"
flags=(-std=c++20 -Og -Wall -Wextra -Werror -Wno-maybe-uninitialized -Wno-array-bounds -DCATCH_CONFIG_FAST_COMPILE -I tests
  -I include -isystem /usr/include/eigen3 -isystem "$build/include")
export flags_text="${flags[*]}" compiler_text="${compiler[*]}" build

test_one() {  # tests/lie/se3.cpp: silent when it passes
  local name=${1#tests/}
  name=${name%.cpp}
  name=$build/${name//\//_}
  # shellcheck disable=SC2086  # lists
  if ! { $compiler_text $flags_text -c "$1" -o "$name.o" \
    && aarch64-linux-gnu-g++ -static "$name.o" "$build/catch_main.o" -o "$name" \
    && qemu-aarch64 "$name"; } > "$name.log" 2>&1; then
    cat "$name.log"
    echo "FAILED: $1"
    return 1
  fi
}
export -f test_one

"${compiler[@]}" "${flags[@]}" -c tests/catch_main.cpp -o "$build/catch_main.o"
sources=()
for folder in "${folders[@]}"; do
  # Left out: oracles, recordings, and the sums whose order is that of Eigen on x86-64.
  for source in tests/"$folder"/*.cpp; do
    if [[ $source != tests/image/patch_sums.cpp && $source != *_ceres.cpp && $source != *_opencv.cpp ]] \
      && ! grep -qE 'plumbline/(io|opencv|thread)/|PLUMBLINE_TEST_DATA|allocation_counter' "$source"; then
      sources+=("$source")
    fi
  done
done
((${#sources[@]} > 0)) || { echo "no tests in ${folders[*]}" >&2; exit 1; }
printf '%s\n' "${sources[@]}" | xargs -P "${JOBS:-$(nproc)}" -I {} bash -c 'test_one {}' || { echo "tests failed"; exit 1; }
echo "${#sources[@]} test programs passed on Arm 64"
