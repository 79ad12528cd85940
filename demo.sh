#!/usr/bin/env bash
# Builds the program, runs visual odometry on a recording and compares the trajectory with the ground truth.
#   ./demo.sh                a simulated recording of a room
#   ./demo.sh DATASET_DIR    a recording of yours: EuRoC, TUM RGB-D (with or without imu.csv) or KITTI odometry
# Outputs are in ./demo: trajectory.tum, timing.csv, trajectory.png and report.html.
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
elif [[ -d $dataset/mav0 ]]; then
  sensors=$([[ -d $dataset/mav0/imu0 ]] && echo mono-imu || echo mono)
elif [[ -d $dataset/image_0 ]]; then
  sensors=mono
else
  echo "$dataset is not a recording: no depth.txt (TUM RGB-D), mav0 (EuRoC) or image_0 (KITTI)" >&2
  exit 1
fi
config=$sensors/points+lines/window

step "Packages"
cmake/setup_debian.sh program
step "Building the program, of its configurations only $config"
quiet cmake --preset release -B build/demo -DPLUMBLINE_TESTS=OFF -DPLUMBLINE_EXAMPLES=OFF \
  -DPLUMBLINE_CONFIGURATIONS="$config"
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

# With an IMU the trajectory is that of the body, else that of the camera. A single camera has no metric scale.
references=(groundtruth.txt poses.txt mav0/state_groundtruth_estimate0/data.csv)
case $sensors in
  *imu)
    references=(groundtruth_body.csv mav0/state_groundtruth_estimate0/data.csv)
    alignment=posyaw
    ;;
  mono) alignment=sim3 ;;
  *) alignment=se3 ;;
esac
for reference in "${references[@]}"; do
  if [[ -f $dataset/$reference ]]; then
    step "Comparing with $reference"
    to_camera=()  # EuRoC's ground truth is that of the body
    if [[ $sensors == mono && $reference == mav0/* ]]; then
      to_camera=(--to-camera "$dataset/mav0/cam0/sensor.yaml")
    fi
    "$plumbline" evaluate --reference "$dataset/$reference" --estimate demo/trajectory.tum --align $alignment \
      --plot demo/trajectory.png "${to_camera[@]}"
    echo "drew demo/trajectory.png"
    step "Comparing four runs that begin one frame apart"
    "$plumbline" compare --config "$config" --dataset "$dataset" --repeat 4 --json demo/report.json \
      --report demo/report.html
    echo "wrote demo/report.html: open it in a browser"
    break
  fi
done
