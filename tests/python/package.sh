#!/usr/bin/env bash
# `pip install .` of docs/guide/python.md, without a network, and one run: package.sh PYTHON SOURCE RECORDING
set -euo pipefail
python=$1 source=$2 recording=$3
folder=$PWD/package
rm -rf "$folder"
mkdir "$folder"
# A copy: setuptools writes beside the sources.
(cd "$source" && tar -cf - --exclude='./build*' --exclude=node_modules --exclude=.git benchmarks/plumbline benchmarks/CMakeLists.txt \
  cmake CMakeLists.txt include python pyproject.toml setup.py LICENSE README.md) | tar -xf - -C "$folder"
cd "$folder"
"$python" -m venv --system-site-packages venv
export CMAKE_ARGS="-DPLUMBLINE_PYTHON_CONFIGURATIONS=rgbd/points/window" CMAKE_BUILD_PARALLEL_LEVEL=1
export CCACHE_BASEDIR=$folder CCACHE_NOHASHDIR=1
venv/bin/pip install --no-index --no-build-isolation . > pip.log 2>&1 || { tail -40 pip.log; exit 1; }
cd venv  # not in the sources
bin/python - "$recording" << 'END'
import sys
import plumbline

assert "/venv/" in plumbline.__file__, plumbline.__file__
assert plumbline.configurations() == ["rgbd/points/window"], plumbline.configurations()
run = plumbline.run(sys.argv[1], "rgbd/points/window")
assert len(run.trajectory) > 10, run.summary
print(plumbline.__version__, run.summary)
END
