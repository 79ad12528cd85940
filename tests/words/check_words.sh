#!/usr/bin/env bash
# No file says a retired name, a retired phrase or a British spelling: tests/words/check_words.sh [SOURCE_FOLDER]
#   retired_identifiers.txt  whole words
#   retired_phrases.txt      Perl regular expressions, without regard to case
#   allowed.txt              lines that may, with the reason
# Records of decisions and the changelog keep the words of their time; generated files are not looked at.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "${1:-$here/../..}"

mapfile -d '' files < <(find include docs benchmarks tests examples python README.md -type f \
  -not -path 'docs/decisions/*' -not -path 'tests/words/*' -not -path '*/dist/*' -not -path '*/node_modules/*' \
  -not -name package-lock.json -print0 | sort -z)
found=$(mktemp)
trap 'rm -f "$found"' EXIT

entries() { grep -vE '^(#|$)' "$1" || true; }

status=0
grep -nHwoIFf <(entries "$here/retired_identifiers.txt") "${files[@]}" > "$found.names" || true
pattern=$(entries "$here/retired_phrases.txt" | paste -sd '|')
grep -nHPiI -- "$pattern" "${files[@]}" > "$found.phrases" || true
trap 'rm -f "$found" "$found".*' EXIT

# "file:line:text" without those that are allowed
mapfile -t allowed < <(entries "$here/allowed.txt")
cat "$found.names" "$found.phrases" > "$found"
if ((${#allowed[@]} > 0)); then
  sed -E 's/^([^:]*):[0-9]+:/\1:/' "$found" | grep -nE -f <(printf '%s\n' "${allowed[@]}") | cut -d: -f1 > "$found.lines" || true
  awk 'NR == FNR {allowed[$1]; next} !(FNR in allowed)' "$found.lines" "$found" > "$found.rest"
  # awk takes an empty first file for the second one
  [[ -s $found.lines ]] && mv "$found.rest" "$found"
fi

if [[ -s $found ]]; then
  grep -Pi --color=never -- "$pattern|" "$found" || true
  echo
  cut -d: -f1 "$found" | awk -F/ '{print (NF > 2 ? $1 "/" $2 : $1)}' | sort | uniq -c
  echo "$(wc -l < "$found") lines have retired words (tests/words/)"
  status=1
fi
exit $status
