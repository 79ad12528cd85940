#!/usr/bin/env bash
# Installs what plumbline needs on Debian 12; does nothing when all of it is there.
#   cmake/setup_debian.sh program   to build the program
#   cmake/setup_debian.sh python    to build the Python module
#   cmake/setup_debian.sh docs      to build the documentation site
#   cmake/setup_debian.sh test      to build the program, to build and run every test, and to build the site
set -euo pipefail

packages=()
program() {
  packages+=(g++ cmake ninja-build libeigen3-dev libopencv-core-dev libopencv-imgproc-dev libopencv-imgcodecs-dev
    libjpeg-dev libyaml-cpp-dev nlohmann-json3-dev libcli11-dev zlib1g-dev libbz2-dev liblz4-dev libzstd-dev libsqlite3-dev
    libcpp-httplib-dev libssl-dev libbrotli-dev)
}
python() {
  packages+=(g++ cmake ninja-build libeigen3-dev libopencv-core-dev libopencv-imgproc-dev libopencv-imgcodecs-dev
    libjpeg-dev libyaml-cpp-dev nlohmann-json3-dev libbz2-dev liblz4-dev libzstd-dev libsqlite3-dev
    pybind11-dev python3-dev python3-numpy python3-pip python3-setuptools python3-venv python3-wheel)
}
docs() {
  packages+=(mkdocs mkdocs-material python3-pymdownx doxygen chromium)
  command -v npm > /dev/null || packages+=(nodejs npm)  # there may be one that is not Debian's
}
case "${1:-}" in
  program) program ;;
  python) python ;;
  docs) docs ;;
  test)
    program
    python
    docs
    packages+=(catch2 ccache libceres-dev libopencv-calib3d-dev libopencv-features2d-dev libopencv-video-dev libbenchmark-dev pkg-config
      gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-newlib qemu-system-arm g++-aarch64-linux-gnu qemu-user
      git shellcheck clang libclang-rt-14-dev lld clang-format-14 clang-tidy-14 python3-jsonschema
      python3-rosbag python3-sensor-msgs python3-pil python3-matplotlib lz4 zstd)
    ;;
  *)
    echo "usage: ${0##*/} program|python|docs|test" >&2
    exit 1
    ;;
esac

if ! command -v apt-get > /dev/null; then
  echo "No apt-get here; these Debian packages, by whatever name your system has them, must be there: ${packages[*]}"
  exit 0
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2> /dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  command -v sudo > /dev/null || { echo "Run as root, or install sudo, to install: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
echo "Installing ${missing[*]}"
"${as_root[@]}" apt-get -qq -o DPkg::Lock::Timeout=300 update
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300 install -y \
  --no-install-recommends "${missing[@]}" > /dev/null
