"""Builds the Python module by CMake: docs/guide/python.md. CMAKE_ARGS has further arguments for it."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

root = Path(__file__).parent.resolve()


class CMakeBuild(build_ext):
    def build_extension(self, ext):
        package = Path(self.get_ext_fullpath(ext.name)).parent.resolve()
        folder = Path(self.build_temp).resolve()
        without = [f"-DPLUMBLINE_{part}=OFF" for part in ("TESTS", "BENCHMARKS", "EXAMPLES", "C")]
        arguments = ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", f"-DPython_EXECUTABLE={sys.executable}", *without]
        arguments += ["-DPLUMBLINE_PYTHON=ON", *shlex.split(os.environ.get("CMAKE_ARGS", ""))]
        cmake = os.environ.get("CMAKE", "cmake")
        subprocess.run([cmake, "-S", root, "-B", folder, *arguments], check=True)
        subprocess.run([cmake, "--build", folder, "--target", "plumbline_python"], check=True)
        subprocess.run([cmake, "--install", folder, "--component", "python", "--prefix", package], check=True)


version = re.search(r"project\(plumbline VERSION ([0-9.]+)", (root / "CMakeLists.txt").read_text(encoding="utf-8"))
setup(version=version[1], ext_modules=[Extension("plumbline._plumbline", [])], cmdclass={"build_ext": CMakeBuild})
