#!/usr/bin/env bash
# Checks what packaging/ has, as far as its tools are installed: packaging/check.sh [PROGRAM]
#   PROGRAM  build/release/benchmarks/plumbline/plumbline by default; without it the bill of materials is not compared
set -euo pipefail
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=${1:-$source/build/release/benchmarks/plumbline/plumbline}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
skipped=()

if [[ -x $program ]]; then
  "$source/packaging/sbom.py" "$work/plumbline.spdx.json" --program "$program"
else
  "$source/packaging/sbom.py" "$work/plumbline.spdx.json"
  skipped+=("comparison of the bill with $program")
fi

if command -v dpkg-buildpackage > /dev/null && command -v dh > /dev/null && command -v lintian > /dev/null; then
  "$source/packaging/deb.sh" "$work/deb" --check
else
  skipped+=("Debian package: debhelper and lintian are missing")
fi

((${#skipped[@]} == 0)) || printf 'skipped: %s\n' "${skipped[@]}"
echo "packages: passed"
