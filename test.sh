#!/usr/bin/env bash
# Builds everything with warnings as errors, compiles each header alone, builds a program of each other preset, and runs
# all tests: quick ones with the address and undefined-behavior sanitizers, those of whole estimators, recordings
# and programs as a user's release, those of two threads with the thread sanitizer too. Installs what is missing; may be
# run again at any time.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

step() { printf '\n== %s (%d s)\n' "$*" "$SECONDS"; }
quiet() { "$@" > build/configure.log || { cat build/configure.log; return 1; }; }
run_tests() { ctest --preset "$1" --parallel "$(nproc)" | tee "build/ctest-$1.log"; }
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1  # one cache serves every checkout
mkdir -p build

step "Packages"
cmake/setup_debian.sh test

step "Release build"
quiet cmake --preset release -DPLUMBLINE_WERROR=ON -DPLUMBLINE_REQUIRE_FIRMWARE=ON \
  -DPLUMBLINE_QUICK_TESTS=OFF -DPLUMBLINE_GROUP_TESTS=ON
cmake --build --preset release
step "Every header alone"
cmake --build --preset release --target headers_alone
step "Tests"
run_tests release

step "The program as clang builds it, with some of its configurations; a program of the two other presets"
quiet cmake --preset clang -B build/source-clang -DPLUMBLINE_TESTS=OFF -DPLUMBLINE_EXAMPLES=OFF \
  -DPLUMBLINE_CONFIGURATIONS="mono/points+collinear/window;rgbd-imu/points+lines+collinear/direct"
cmake --build build/source-clang --target plumbline_program
build/source-clang/benchmarks/plumbline/plumbline list
for preset in native debug; do
  quiet cmake --preset "$preset" -B "build/source-$preset" -DPLUMBLINE_TESTS=OFF -DPLUMBLINE_BENCHMARKS=OFF
  cmake --build "build/source-$preset" --target example_01_rgbd_points
done

step "Build of the quick tests with sanitizers"
quiet cmake --preset asan-ubsan -DPLUMBLINE_WERROR=ON -DPLUMBLINE_GROUP_TESTS=ON
cmake --build --preset asan-ubsan
step "Quick tests with sanitizers"
run_tests asan-ubsan

step "Tests of two threads with the thread sanitizer"
quiet cmake --preset tsan -DPLUMBLINE_WERROR=ON
cmake --build --preset tsan
run_tests tsan

step "Done"
for preset in tsan asan-ubsan release; do
  printf '%s\n' "$preset"
  grep -E '^[0-9]+% tests passed|^Total Test time' "build/ctest-$preset.log"
done
