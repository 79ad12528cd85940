#!/usr/bin/env bash
# Builds the documentation site into build/site: pages, search, diagrams and the API reference, none of which needs a
# network to be read. Warnings, broken links and diagrams that are not drawn are errors. Installs what is missing.
#   docs/build.sh
# To read it: open build/site/index.html in a browser.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

cmake/setup_debian.sh docs
python=/usr/bin/python3  # Debian's, which has mkdocs
parts=$PWD/build/site_parts
rm -rf "$parts" build/site
mkdir -p "$parts/assets" build/npm

# The script of a package of npm that pages load from the site itself: `package version sha256 path name`.
script() {
  local archive=build/npm/$1-$2.tgz
  if ! sha256sum --check --status <<< "$3  $archive" 2> /dev/null; then
    npm pack --silent --pack-destination build/npm "$1@$2" > /dev/null
    sha256sum --check --quiet <<< "$3  $archive"
  fi
  tar -xOf "$archive" "package/$4" > "$parts/assets/$5"
}
script mermaid 11.4.1 ec7b61b391aaa24bf666fd20e48d0a626eeb4a95b95bc6b3016a122d7f0bc2af dist/mermaid.min.js mermaid.min.js
script iframe-worker 1.0.4 e8c5d12d87829c503afba01d67772ea9f4aba5b7ae57a0c98e1917711030efbb shim/index.js iframe-worker.js
cp docs/site/site.css docs/site/diagrams.js "$parts/assets"

PLUMBLINE_API=$parts doxygen docs/Doxyfile
mv "$parts/html" "$parts/api"

"$python" docs/site/list_decisions.py ${CI:+--check}
"$python" docs/site/draw_tracking_states.py ${CI:+--check}
if ! PLUMBLINE_SITE_PARTS=$parts PYTHONDONTWRITEBYTECODE=1 "$python" -m mkdocs build --strict &> build/mkdocs.log; then
  grep -vE 'INFO|^  - ' build/mkdocs.log
  exit 1
fi
"$python" docs/site/check_site.py build/site
echo "Built build/site/index.html"
