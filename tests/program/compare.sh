#!/usr/bin/env bash
# plumbline compare: patterns, shards, interruption, crashes, and the content of its file.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
schema=$(dirname "${BASH_SOURCE[0]}")/../../docs/compare.schema.json

rm -rf room still flight ./*.json ./*.json.parts
"$plumbline" simulate --scene room --duration 2.5 --out room > /dev/null 2>&1
copy_recording still
rm still/depth.txt
mkdir flight

whole=("$plumbline" compare --config 'rgbd/points/w*' mono/points/window --dataset room still --repeat 2)
small=("$plumbline" compare --config "$config" --dataset room --repeat 2 --jobs 1)
# expect_text FILE PATTERN...
expect_text() {
  local file=$1 pattern text
  text=$(cat "$file")
  shift
  for pattern in "$@"; do
    grep -qE -- "$pattern" <<< "$text" || fail "$file does not match \"$pattern\": $text"
  done
}
# The file without what differs from run to run.
without_times() { sed -E 's/"[a-z]+_ms":(\[[^]]*\]|\{[^}]*\})//g' "$1"; }

# ---------------------------------------------------------------------------------------------------- a whole one
"${whole[@]}" --json all.json --report all.html --markdown table.md > table.txt 2> log.txt || fail "compare: $(cat log.txt)"
cat table.txt
expect_text log.txt '^still lacks depth: 1 configuration left out$' '100 %.*left\)$'
expect_text table.txt '^room: 50 frames' 'rgbd/points/window +se3 +0\.0[0-9]+ m +0\.0[0-9]+ m +100 % +0 of 2' \
  'mono/points/window +sim3 '
expect_text <(tr '\n' ' ' < table.txt) \
  'ATE: .*2 runs that begin one frame.*causal.*Coverage: .*cores.*plumbline 0.*side by side'
expect_text table.md '^. .rgbd/points/window. . se3 . 0\.0.* m, worst 0\.0.* m, 100 %, .* ms \| \|$'
grep -q '"format":"plumbline-compare"' all.html || fail "the page is without its data"
[[ ! -e all.json.parts ]] || fail "parts are left behind"

# ------------------------------------------------------------------------------------- tables of files that are there
"$plumbline" table all.json --command "plumbline compare --config 'rgbd/points/w*'" --commit abcdef --json small.json \
  > table.md || fail "table of a comparison"
expect_text table.md '^. .rgbd/points/window. . se3 . 0\.0.* m, worst 0\.0.* m, 100 %, .* ms \| \|$' \
  'commit abcdef' \
  "^plumbline compare --config 'rgbd/points/w\*'$"
printf '<!-- table accuracy -->\n<!-- table timing -->\n' > template.md
"$plumbline" table small.json --template template.md --markdown page.md || fail "page of a comparison"
expect_text page.md '^.room.: 50 frames' \
  '^. .rgbd/points/window. . se3 . 0\.0[0-9]+ m . 0\.0[0-9]+ m . .* deg . 100 % . 0 of 2 \|$' \
  '^. .rgbd/points/window. . [0-9.]+ . [0-9.]+ . [0-9.]+ . [0-9.]+ .$'
(($(wc -c < small.json) < $(wc -c < all.json) / 4)) || fail "small.json has the series"
"$plumbline" list --memory --json memory.json --markdown memory.md > memory.txt || fail "list --memory"
expect_text memory.txt "^$config +[0-9]+ bytes +[0-9.]+ MiB\$"
expect_text memory.md '^. .rgbd/points. .* [0-9.]+ MiB ' '^plumbline list --memory$'
if python3 -c 'import jsonschema' 2> /dev/null; then
  python3 - "$schema" all.json << 'EOF' || fail "all.json is not what the schema describes"
import json, sys, jsonschema
schema, data = (json.load(open(name)) for name in sys.argv[1:])
jsonschema.Draft202012Validator(schema).validate(data)
runs = {(run["configuration"], run["dataset"], run["repeat"]): run for run in data["runs"]}
assert len(runs) == 6 and data["plans"][0]["runs"] == 6, runs.keys()
first, second = (runs["rgbd/points/window", "room", k] for k in (0, 1))
assert first["status"] == "ok" and first["frames"] == 50 and second["frames"] == 49
assert sum(first["health"][state] for state in ("initializing", "tracking", "degraded", "lost")) == 50
typical = [run for run in (first, second) if "frame_series" in run]
assert len(typical) == 1 and len(typical[0]["frame_series"]["t"]) == typical[0]["frames"]
assert len(typical[0]["map"]["points"]) > 50 and all(len(run["trajectory"]["t"]) == run["poses"] for run in (first, second))
room = next(each for each in data["datasets"] if each["name"] == "room")
assert len(room["truth"]["t"]) > 400 and room["has_imu"] and room["has_depth"]
for run in data["runs"]:  # nothing moves enough for a camera alone
    assert run["status"] == "ok" or run["error"] and run["ate"] is None, run["error"]
EOF
else
  echo "no python3-jsonschema here: all.json is not held against its schema"
fi

"${small[@]}" --start 0.52 --duration 1 --json part.json > part.txt 2> log.txt || fail "a part: $(cat log.txt)"
expect_text part.txt '^room: 20 frames'  # from 0.55 s to 1.5 s
expect_text part.json '"frames":20,"health' '"first_frame":1,' '"frames":19,"health'

# ------------------------------------------------------------------------------------------------ shards and merge
"${whole[@]}" --shard 1/2 --json 1.json > /dev/null 2>&1 || fail "shard 1"
"${whole[@]}" --shard 2/2 --json 2.json > /dev/null 2>&1 || fail "shard 2"
"$plumbline" compare --merge 2.json 1.json --json merged.json > merged.txt 2> log.txt || fail "merge: $(cat log.txt)"
[[ ! -s log.txt ]] || fail "the merge complains: $(cat log.txt)"
cmp <(without_times all.json) <(without_times merged.json) || fail "the merged file is not that of the whole"
"$plumbline" compare --merge 2.json > /dev/null 2> log.txt || fail "merge of one"
expect_text log.txt '^3 of 6 runs: shards are missing$'
sed 's/"cpu":"/"cpu":"another /' 2.json > other.json
"$plumbline" compare --merge 1.json other.json > merged.txt 2> log.txt || fail "merge of two machines"
expect_text log.txt 'several machines'
expect_text <(tr '\n' ' ' < merged.txt) '; and another '

# --------------------------------------------------------------------------------------------------- interruption
# Waits until a command succeeds.
wait_for() {
  for ((i = 0; i < 3000; ++i)); do
    if "$@" > /dev/null 2>&1; then return; fi
    sleep 0.02
  done
  fail "waited in vain for $*"
}
env --default-signal=INT "${small[@]}" --json again.json > /dev/null 2> log.txt &  # the shell has it ignored
wait_for eval 'ls again.json.parts/*.json'
kill -INT $!
status=0
wait $! || status=$?
[[ $status == 130 && ! -e again.json ]] || fail "interrupted, but status $status: $(cat log.txt)"
expect_text log.txt 'interrupted.*again.json.parts'
part=$(echo again.json.parts/*.json | cut -d ' ' -f 1)
sed -i 's/"compared":[0-9]*/"compared":12345/' "$part"  # a mark that a second run would wipe out
"${small[@]}" --json again.json > /dev/null 2> log.txt || fail "resumed: $(cat log.txt)"
expect_text log.txt '^1 of 2 runs are there already'
[[ $(grep -o '"compared":12345' again.json | wc -l) == 1 ]] || fail "a finished run was run again"

# ---------------------------------------------------------------------------------------------- crashes and limits
"${small[@]}" --json crash.json > table.txt 2> log.txt &
wait_for pgrep -P $!
kill -SEGV "$(pgrep -P $! | head -1)"
wait $! || fail "a crash ended the comparison: $(cat log.txt)"
expect_text log.txt '^failed: rgbd/points/window on room, repeat 0: crashed: Segmentation fault'
expect_text table.txt 'rgbd/points/window .* failed +0 % +1 of 2'
"${small[@]}" --limit 0.01 --json late.json > table.txt 2> log.txt || fail "limit"
expect_text log.txt 'repeat 0: stopped after 0.01 s'
expect_text table.txt 'rgbd/points/window +se3 +failed +failed +0 % +2 of 2'

# -------------------------------------------------------------------------------------------------- bad arguments
known=(--config "$config" --dataset room --json no.json)
expect_misuse 'configuration "rgbd/point/window" is unknown.*"rgbd/points/window"' \
  compare --config rgbd/point/window --dataset room --json no.json
expect_misuse 'no configuration matches "rgbx\*"' compare --config 'rgbx*' --dataset room --json no.json
expect_error 'rgbd/points/window can run on none of the recordings: still lacks depth' \
  compare --config rgbd/points/window --dataset still --json no.json
expect_misuse 'two recordings are called room' compare "${known[@]}" --dataset room
expect_error 'flight' compare --config "$config" --dataset flight --json no.json
expect_misuse 'needs --config' compare --dataset room
expect_misuse '--shard must be I/N.*3/2' compare "${known[@]}" --shard 3/2
expect_misuse '--shard must be I/N.*half' compare "${known[@]}" --shard half
expect_misuse '--repeat' compare "${known[@]}" --repeat 0
expect_error 'too few for 50 repeats' compare "${known[@]}" --repeat 50
expect_misuse '--start' compare "${known[@]}" --start -1
expect_misuse '--duration' compare "${known[@]}" --duration nan
expect_error 'nowhere/no.json: cannot be written' compare --config "$config" --dataset room --json nowhere/no.json
expect_misuse 'more than one output' compare "${known[@]}" --report ./no.json
expect_error 'table.txt: is not JSON' compare --merge 1.json table.txt
expect_error 'table.txt: is not JSON' table table.txt
echo '{"format":"plumbline-results","version":1,"kind":"faults"}' > no_faults.json
expect_error 'incomplete results' table no_faults.json
expect_error 'none of the files has the results of table accuracy' table memory.json --template template.md
echo '<!-- table fault -->' > misspelled.md
expect_error 'table "fault" is unknown.*"faults"' table memory.json --template misspelled.md
expect_error 'nowhere/no.json: cannot be written' table small.json --json nowhere/no.json
expect_misuse '--memory' list --json no.json
expect_error 'again the run of' compare --merge 1.json 1.json
sed 's/"program":"/&f/' 2.json > built.json
expect_error 'another build' compare --merge 1.json built.json
expect_misuse 'no --dataset' compare --merge 1.json --dataset room
echo '{"format":"plumbline-compare","version":1}' > empty.json
expect_error 'empty.json: is not a whole comparison' compare --merge 1.json empty.json
[[ ! -e no.json && ! -e no.json.parts ]] || fail "files were left behind"
finish
