#!/usr/bin/env bash
# Builds the program, runs visual odometry on a recording and shows how far it is from the truth.
#   ./demo.sh                a simulated recording of a room, made on the spot
#   ./demo.sh DATASET_DIR    a recording of yours: EuRoC with IMU, or TUM RGB-D with or without imu.csv
# Everything it makes is in ./demo: trajectory.tum, timing.csv, trajectory.png.
set -euo pipefail
started_in=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")"

step() { printf '\n== %s (%d s)\n' "$*" "$SECONDS"; }
quiet() { "$@" > demo/build.log || { cat demo/build.log; return 1; }; }
mkdir -p demo

if (($# > 1)) || [[ ${1:-} == -* ]]; then
  echo "usage: ./demo.sh [DATASET_DIR]" >&2
  exit 1
fi
dataset=demo/room
if (($# == 1)); then
  dataset=$(cd "$started_in" && realpath -e -- "$1")
fi

if (($# == 0)); then
  sensors=rgbd
elif [[ -f $dataset/depth.txt ]]; then
  sensors=$([[ -f $dataset/imu.csv ]] && echo rgbd-imu || echo rgbd)
elif [[ -d $dataset/mav0/imu0 ]]; then
  sensors=mono-imu
else
  echo "$dataset has neither depth images (depth.txt) nor an IMU (mav0/imu0)" >&2
  exit 1
fi
config=$sensors/points+lines/window

step "Packages"
cmake/setup_debian.sh program
step "Building the program, of its configurations only $config"
quiet cmake --preset release -B build/demo -DPLUMBLINE_TESTS=OFF -DPLUMBLINE_EXAMPLES=OFF \
  -DPLUMBLINE_CONFIGURATIONS="${config//[-+\/]/_}"
cmake --build build/demo --target plumbline_program
plumbline=build/demo/benchmarks/plumbline/plumbline

if (($# == 0)); then
  step "Simulating a recording: 20 s in a room, camera and depth camera"
  rm -rf "$dataset"
  "$plumbline" simulate --scene room --out "$dataset" --duration 20
fi

step "Running $config on $dataset"
"$plumbline" run --config "$config" --dataset "$dataset" --trajectory demo/trajectory.tum --timing demo/timing.csv
echo "wrote demo/trajectory.tum, demo/timing.csv"

# With an IMU the trajectory is that of the body, without that of the camera.
references=(groundtruth.txt poses.txt)
alignment=se3
if [[ $sensors == *imu ]]; then
  references=(groundtruth_body.csv mav0/state_groundtruth_estimate0/data.csv)
  alignment=posyaw
fi
for reference in "${references[@]}"; do
  if [[ -f $dataset/$reference ]]; then
    step "Comparing with $reference"
    "$plumbline" evaluate --reference "$dataset/$reference" --estimate demo/trajectory.tum --align $alignment \
      --plot demo/trajectory.png
    echo "drew demo/trajectory.png"
    break
  fi
done
