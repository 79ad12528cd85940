#!/usr/bin/env bash
# clang-format and clang-tidy, version 14 as in Debian 12, over the C++ files that changed since BASE, committed or not.
#   cmake/lint.sh          since this branch left the default branch; on the default branch, since the commit before
#   cmake/lint.sh BASE     since that commit
#
# Changed sources are tidied, and for a changed header the test of its name. What contains a whole estimator is left out,
# and so is what exceeds LINT_MAX_FILES (8): both take clang-tidy minutes. It says which.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

tool() {
  local name
  for name in "$1-14" "$1"; do
    if [[ $("$name" --version 2> /dev/null) == *"version 14."* ]]; then
      echo "$name"
      return
    fi
  done
  echo "$1 14 is missing (Debian: $1-14); other versions judge differently" >&2
  return 1
}
clang_format=$(tool clang-format)
clang_tidy=$(tool clang-tidy)

# The commit to compare with: empty where there is no history, or only one commit.
find_base() {
  local branch base
  for branch in origin/HEAD origin/main origin/master main master; do
    if base=$(git merge-base HEAD "$branch" 2> /dev/null); then
      if [[ $base != $(git rev-parse HEAD) ]]; then
        echo "$base"
        return
      fi
      break
    fi
  done
  git rev-parse --verify --quiet HEAD~1 || true
}

base=${1:-$(find_base)}
if [[ -n $base ]]; then
  base=$(git rev-parse --short --verify "$base^{commit}")
  mapfile -t changed < <({ git diff --name-only --diff-filter=d "$base" && git ls-files --others --exclude-standard; } |
    grep -E '^(include|tests|benchmarks|examples|python)/.*\.[ch]pp$' | sort -u)
  echo "Lint: ${#changed[@]} C++ files changed since $base"
else
  mapfile -t changed < <(find include tests benchmarks examples python -name '*.[ch]pp' | sort)
  echo "Lint: no earlier commit here; the format of all ${#changed[@]} C++ files"
fi
if ((${#changed[@]} == 0)); then
  exit 0
fi

if ! "$clang_format" --dry-run -Werror "${changed[@]}"; then
  echo "to format what differs: $clang_format -i FILE ..." >&2
  exit 1
fi
if grep -nE '^.{121,}$' "${changed[@]}" /dev/null | grep //; then  # comments are left as they are
  echo "comments beyond column 120" >&2
  exit 1
fi
if [[ -z $base ]]; then
  exit 0
fi

is_estimator() {
  [[ $1 =~ ^tests/(backend|estimator|systems)/ ]] || grep -qE '"plumbline/((backend|estimator|systems)/|plumbline\.hpp)' "$1"
}
sources=()
left_out=()
for file in "${changed[@]}"; do
  source=$file
  if [[ $file == include/plumbline/*.hpp ]]; then
    source=tests/${file#include/plumbline/}
    source=${source%.hpp}.cpp
  fi
  if [[ $source != *.cpp || ! -f $source || $source == tests/consumer/* || " ${sources[*]} " == *" $source "* ]]; then
    continue
  fi
  if is_estimator "$source" || ((${#sources[@]} == ${LINT_MAX_FILES:-8})); then
    left_out+=("$source")
  else
    sources+=("$source")
  fi
done
if ((${#left_out[@]} > 0)); then
  printf 'Not tidied, estimator or too many: %s\n' "${left_out[@]}"
fi
if ((${#sources[@]} == 0)); then
  exit 0
fi

# Nothing is built here: the commands that would compile each file.
mkdir -p build
cmake --preset release -B build/lint -DPLUMBLINE_WERROR=OFF > build/lint.log || { cat build/lint.log; exit 1; }
echo "Tidying ${sources[*]}"
printf '%s\0' "${sources[@]}" | xargs -0 -n 1 -P "$(nproc)" "$clang_tidy" -p build/lint --quiet \
  --warnings-as-errors='*' --extra-arg=-Wno-unknown-warning-option 2> build/lint.log || { cat build/lint.log; exit 1; }
