#!/usr/bin/env bash
# Measures the results of this folder and writes their pages, which takes about an hour:
#
#   docs/results/make.sh PROGRAM RECORDINGS [OPTION ...]
#
# PROGRAM is the program `plumbline`, RECORDINGS the folder of the recordings that are named below.
#
#   --page NAME    this page only: accuracy, initialization, faults, relocalizations, timing, memory, or field and map
#                  (made only where they are asked for); may be given several times
#   --field DIR    folder of the inputs of the page field, RECORDINGS/../field by default
#   --quick        fewer runs, in a third of the time: accuracy of four runs instead of eight, timing of one instead of two,
#                  initialization without simulated recordings, each fault once and for 0.5 and 3 s, map of two runs
#                  instead of eight, of one seed and without the hall
#   --tables       the pages from the JSON files that are there, without a run
#   --jobs N       commands and runs side by side, as many as there are cores by default; timing takes one at a time
#   --work DIR     folder that keeps the simulated recordings, instead of a temporary one
#   --out DIR      folder of the pages and of data/, instead of this one
#
# A configuration that the program was built without is left out. PLUMBLINE_COMMIT replaces the commit of this checkout.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
usage() {
  sed -n '2,/^set -/{/^# \{0,1\}/s///p}' "${BASH_SOURCE[0]}" >&2
  exit 2
}

(($# >= 2)) || usage
program=$(realpath "$1")
recordings=$(realpath "$2")
shift 2
pages=() tables_only=false field=$recordings/../field jobs=$(nproc) work='' out=$here
quick=false repeats=8 timed=2 durations=(0.2 0.5 1 3) times=3
while (($# > 0)); do
  case $1 in
    --tables) tables_only=true && shift ;;
    --quick) quick=true repeats=4 timed=1 durations=(0.5 3) times=1 && shift ;;
    --page | --jobs | --work | --out | --field)
      (($# >= 2)) || usage
      case $1 in
        --page) [[ -f $here/templates/$2.md ]] || usage; pages+=("$2") ;;
        --jobs) jobs=$2 ;;
        --field) field=$(realpath "$2") ;;
        --work) work=$(mkdir -p "$2" && realpath "$2") ;;
        --out) out=$(mkdir -p "$2" && realpath "$2") ;;
      esac
      shift 2
      ;;
    *) usage ;;
  esac
done
((${#pages[@]} > 0)) || pages=(memory timing accuracy initialization faults relocalizations)
if [[ -z $work ]]; then
  work=$(mktemp -d)
  trap 'rm -rf "$work"' EXIT
fi
data=$out/data
mkdir -p "$data"

if [[ -z ${PLUMBLINE_COMMIT:-} ]]; then
  PLUMBLINE_COMMIT=$(git -C "$here" rev-parse --short=10 HEAD)
  git -C "$here/../.." diff --quiet HEAD -- include benchmarks cmake CMakeLists.txt || PLUMBLINE_COMMIT+=-changed
fi
export PLUMBLINE_COMMIT

# available NAME ...: those that the program has.
available() {
  local name
  for name in "$@"; do
    if "$program" list | grep -q "^$name "; then echo "$name"; fi
  done
}

# beside COMMAND ...: in the background, at most `jobs` at a time. `finished` waits for all; a failure ends the script.
beside() {
  while (($(jobs -rp | wc -l) >= jobs)); do wait -n; done
  "$@" &
}
finished() {
  local pid
  for pid in $(jobs -p); do wait "$pid"; done
}

# simulated NAME OPTION ...: a recording in the folder of the work, unless it is there.
simulated() {
  local folder=$work/$1
  shift
  [[ ! -d $folder ]] || return 0
  rm -rf "$folder.new"
  "$program" simulate --out "$folder.new" --layout euroc --duration 40 "$@" > /dev/null
  mv "$folder.new" "$folder"
}

# measured FOLDER FILE COMMAND ...: a command in the folder of its recordings, with its figures to data/FILE.
measured() {
  local folder=$1 file=$2
  shift 2
  echo "plumbline $*" >&2
  (cd "$folder" && "$program" "$@" --json "$data/$file" > /dev/null)
}

# compared FILE COMMAND ...: a comparison, without its trajectories.
compared() {
  local file=$1 word text=plumbline
  shift
  echo "plumbline $*" >&2
  for word in "$@"; do
    if [[ $word == *'*'* ]]; then text+=" '$word'"; else text+=" $word"; fi
  done
  (cd "$recordings" && "$program" "$@" --json "$work/$file" > /dev/null)
  "$program" table "$work/$file" --command "$text" --json "$data/$file" > /dev/null
}

# page NAME FILE ...: of figures in data/.
page() {
  local name=$1
  shift
  (cd "$data" && "$program" table "$@" --template "$here/templates/$name.md" --markdown "$out/$name.md")
}

measure_accuracy() {
  compared accuracy.json compare --config '*' --dataset euroc_mh01_flight rendered_office_mono tum_fr1_rpy_first12s \
    icl_office_kt0_3s rendered_lowtex_rgbd kitti00_first20s --repeat "$repeats" --jobs "$jobs"
}

measure_timing() {
  compared timing.json compare --config '*' --dataset euroc_mh01_flight tum_fr1_rpy_first12s rendered_lowtex_rgbd \
    --repeat "$timed" --jobs 1
}

measure_initialization() {
  local configs
  mapfile -t configs < <(available mono-imu/points{,+lines}/{window,direct})
  if $quick; then
    measured "$recordings" initialization.json starts --config "${configs[@]}" \
      --dataset euroc_mh01_flight rendered_office_mono rendered_lowtex_rgbd --every 2 --duration 12
    return
  fi
  beside simulated room --scene room --seed 41 --late 0.02
  beside simulated walk --scene walk --seed 42 --readout 0.015 --late -0.03 --drop 0.05
  beside simulated corridor --scene corridor --seed 45 --readout 0.02 --stop 20 24
  beside simulated hall --scene hall --seed 43 --stop 20 24
  beside simulated hall_rolling --scene hall --seed 48 --readout 0.03 --late 0.03 --drop 0.1
  beside simulated boards_low_cost_imu --scene boards --seed 46 --imu low-cost --late 0.05
  beside simulated room_lowtex_low_cost_imu --scene room_lowtex --seed 44 --imu low-cost
  finished
  beside measured "$recordings" initialization.json starts --config "${configs[@]}" \
    --dataset euroc_mh01_flight rendered_office_mono rendered_lowtex_rgbd --every 2 --duration 12
  beside measured "$work" initialization_simulated.json starts --config "${configs[@]}" \
    --dataset room walk corridor hall hall_rolling boards_low_cost_imu room_lowtex_low_cost_imu --every 2 --duration 12
  finished
}

measure_faults() {
  local sensors configs
  local -A datasets=([mono-imu]=euroc_mh01_flight [rgbd-imu]=rendered_lowtex_rgbd
    [rgbd]='tum_fr1_rpy_first12s rendered_lowtex_rgbd')
  for sensors in mono-imu rgbd-imu rgbd; do
    mapfile -t configs < <(available "$sensors"/points{,+lines}/{window,direct})
    ((${#configs[@]} > 0)) || continue
    # shellcheck disable=SC2086  # a list
    beside measured "$recordings" "faults_$sensors.json" faults --config "${configs[@]}" \
      --dataset ${datasets[$sensors]} --for "${durations[@]}" --times "$times"
  done
  finished
}

measure_relocalizations() {
  local sensors configs
  local -A datasets=([mono-imu]='rendered_office_mono euroc_mh01_flight' [rgbd]='rendered_lowtex_rgbd tum_fr1_rpy_first12s')
  for sensors in mono-imu rgbd; do
    mapfile -t configs < <(available "$sensors"/points/window)
    ((${#configs[@]} > 0)) || continue
    # shellcheck disable=SC2086  # a list
    beside measured "$recordings" "relocalizations_$sensors.json" relocalizations --config "${configs[@]}" \
      --dataset ${datasets[$sensors]} --every "$($quick && echo 1 || echo 0.25)" \
      --duration "$([[ $sensors == *imu ]] && echo 5 || echo 3)"
  done
  finished
  mapfile -t configs < <(available mono-imu/points/window)
  if ! $quick && ((${#configs[@]} > 0)); then
    simulated room --scene room --seed 41 --late 0.02
    measured "$work" relocalizations_simulated.json relocalizations --config "${configs[@]}" --dataset room --every 1 \
      --duration 5
  fi
}

measure_field() { "$here/measure_field.py" "$program" "$recordings" "$field" "$work/field" "$data/field.json"; }

measure_map() {
  local words=("$program" "$recordings" "$work/map" "$data/map.json" --jobs "$jobs")
  if $quick; then words+=(--quick); fi
  "$here/measure_map.py" "${words[@]}"
}

measure_memory() { "$program" list --memory --json "$data/memory.json" > /dev/null; }

for name in "${pages[@]}"; do
  if ! $tables_only; then
    rm -f "$data/$name"*.json
    "measure_$name"
  fi
  files=("$data/$name"*.json)
  [[ -f ${files[0]} ]] || { echo "no $data/$name*.json" >&2; exit 1; }
  page "$name" "${files[@]##*/}"
  echo "$out/$name.md" >&2
done
