#!/usr/bin/env bash
# examples/python/plot_trajectory.py makes a picture: example.sh PYTHON RECORDING
set -euo pipefail
python=$1 recording=$2
examples=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../examples/python" && pwd)
"$python" -c 'import matplotlib' 2> /dev/null || { echo "skipped: no python3-matplotlib"; exit 77; }
rm -f trajectory.png
"$python" "$examples/plot_trajectory.py" "$recording" --config rgbd/points/window --out trajectory.png
[[ $(head -c 4 trajectory.png | tail -c 3) == PNG && $(stat -c %s trajectory.png) -gt 10000 ]]
status=0
"$python" "$examples/plot_trajectory.py" none 2> err.txt || status=$?
[[ $status == 1 && $(wc -l < err.txt) == 1 ]] || { cat err.txt; exit 1; }
