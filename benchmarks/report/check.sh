#!/usr/bin/env bash
# Builds the pages, compares them with those of dist/, and runs their tests in a headless Chromium.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

npm ci --ignore-scripts --no-audit --no-fund --loglevel=error
fresh=$(mktemp -d)
trap 'rm -rf "$fresh"' EXIT
node build.mjs "$fresh"
for page in compare debug doctor live; do
  if ! cmp "$fresh/$page.html" "dist/$page.html"; then
    echo "dist/$page.html is not what its sources make; run: (cd benchmarks/report && npm ci && npm run build)" >&2
    exit 1
  fi
done
timeout 600 npm test
