# Shared by the tests of the program: sourced, not run.
set -euo pipefail
plumbline=$1
recording=$2
# shellcheck disable=SC2034  # used where this is sourced
config=rgbd/points/window
failures=0

fail() {
  echo "FAILED: $*"
  failures=$((failures + 1))
}

# expect_error PATTERN ARGUMENT...: the program fails with status 1, one line on stderr that matches, nothing on stdout.
# Notes about the recording may come before it.
expect_error() { expect_status 1 "$@"; }

# expect_misuse PATTERN ARGUMENT...: the same of a command line that cannot be meant, with status 2.
expect_misuse() { expect_status 2 "$@"; }

expect_status() {
  local expected=$1 pattern=$2 status=0
  shift 2
  "$plumbline" "$@" > out.txt 2> err.txt || status=$?
  [[ $status == "$expected" ]] || fail "$*: status $status instead of $expected"
  [[ ! -s out.txt ]] || fail "$*: output on stdout: $(cat out.txt)"
  [[ $(grep -vc "^plumbline: note: " err.txt) == 1 ]] || fail "$*: not one line but: $(cat err.txt)"
  grep -qE -- "$pattern" err.txt || fail "$*: \"$(cat err.txt)\" does not match \"$pattern\""
}

# expect_failure PATTERN ARGUMENT...: the same of work that had begun: the last line matches.
expect_failure() {
  local pattern=$1 status=0
  shift
  "$plumbline" "$@" > out.txt 2> err.txt || status=$?
  [[ $status == 1 ]] || fail "$*: status $status instead of 1"
  tail -n 1 err.txt | grep -qE -- "$pattern" || fail "$*: \"$(tail -n 1 err.txt)\" does not match \"$pattern\""
}

# A copy of the recording that a test may damage.
copy_recording() {
  rm -rf "$1"
  cp -r "$recording" "$1"
}

finish() {
  ((failures == 0)) || exit 1
  echo passed
}

# skip_without FOLDER: ends the test where that folder of recordings is missing; ctest reports it as skipped.
skip_without() {
  [[ -d $1 ]] || { echo "skipped: no recordings at $1"; exit 77; }
}
