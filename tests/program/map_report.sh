#!/usr/bin/env bash
# What a map does is seen: on the page of a run, in its times, in a comparison and on the page of a saved map.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
schema=$(dirname "${BASH_SOURCE[0]}")/../../docs/compare.schema.json

rm -rf loop look plain ./*.json* ./*.html ./*.map
"$plumbline" simulate --scene room --laps 2 --size 320 240 --out loop > /dev/null 2>&1
run=(run --config "$config" --dataset loop)

# data_of FILE: the data of a page.
data_of() {
  local place='<script type="application/json" id="plumbline-data">'
  grep -F "$place" "$1" | sed -e "s|^$place||" -e 's|</script>$||'
}

# ------------------------------------------------------------------------------------------------------ a run and a map
"$plumbline" "${run[@]}" --map --debug look --timing out.csv --save-map loop.map --loops loops.csv \
  --trajectory map.tum --trajectory-world world.tum --trajectory-final final.tum > out.txt 2> err.txt ||
  fail "run --map --debug: $(cat err.txt)"
data_of look/report.html > look.json
"$plumbline" map loop.map --report map.html > map.txt 2> err.txt || fail "map --report: $(cat err.txt)"
data_of map.html > map.json
python3 - << 'EOF' || fail "the pages are not what the run was"
import csv, json, math, re
page, saved = json.load(open("look.json")), json.load(open("map.json"))
run, text = page["map"], open("out.txt").read()

# Counts are those of the summary.
words = {"keyframes": r"map: (\d+) keyframes", "evicted": r"\((\d+) evicted", "verified": r", (\d+) places recognized",
         "queries": r"of (\d+) queries", "loops": r", (\d+) loops", "relocalizations": r", (\d+) relocalizations",
         "corrections": r", (\d+) corrections", "rejected_by_gate": r"refused: (\d+) by the odometry",
         "rejected_by_tilt": r", (\d+) by gravity", "rejected_as_ambiguous": r", (\d+) as ambiguous"}
for name, pattern in words.items():
    assert int(re.search(pattern, text)[1]) == run["counts"][name], name
assert run["counts"]["loops"] > 0 and run["counts"]["corrections"] > 0, run["counts"]

# Loops connect the keyframes of the table of loops, and are in the saved map.
loops = list(csv.DictReader(open("loops.csv")))
assert len(loops) == len(run["loops"]) == len(saved["map"]["loops"]), len(loops)
assert all(0 <= i < j < len(run["keyframes"]["x"]) for i, j in run["loops"])
assert run["keyframes"] == saved["map"]["keyframes"] and run["points"] == saved["map"]["points"]
assert re.search(r"(\d+) of them points", open("map.txt").read())[1] == str(saved["map"]["counts"]["points"])
assert len(run["points"]) > 500 and len(saved["map"]["keyframes"]["x"]) == saved["map"]["counts"]["keyframes"]

# Keyframes that follow one another see the same; those of one side of the room and of the other one do not.
pairs, n = {tuple(pair) for pair in run["covisible"]}, len(run["keyframes"]["x"])
assert sum((i, i + 1) in pairs for i in range(n - 1)) > 0.6 * (n - 1), pairs
assert len(pairs) <= 4 * n

# Trajectories are those of the files.
def positions(file):
    return [[float(x) for x in line.split()[1:4]] for line in open(file)]
for name, file in (("causal", "map.tum"), ("final", "final.tum"), ("odometry", "world.tum")):
    drawn = list(zip(*(run[name][axis] for axis in "xyz")))
    written = positions(file)
    assert len(drawn) == len(written) and max(math.dist(a, b) for a, b in zip(drawn, written)) < 1e-4, name
assert len(run["truth"]["t"]) > 0.9 * len(run["causal"]["t"])
assert all(0 < run["ate_m"][name] < 0.2 for name in ("odometry", "causal", "final")), run["ate_m"]
assert run["ate_m"]["final"] < 1.5 * run["ate_m"]["odometry"], run["ate_m"]

# The time of the map is part of that of the frame, and most frames query, verify and solve nothing.
rows = list(csv.DictReader(open("out.csv")))
for stage in ("learn", "query", "verify", "solve"):
    ms = [float(row[f"map_{stage}_ms"]) for row in rows]
    assert max(ms) > 0.001, stage
    assert max(abs(a - b) for a, b in zip(ms, page["columns"][f"map_{stage}_ms"])) < 1e-3 * max(ms) + 1e-4, stage
for row in rows:
    assert sum(float(row[f"map_{stage}_ms"]) for stage in ("learn", "query", "verify", "solve")) <= float(row["total_ms"]) + 0.01, row
EOF
for stage in learn query verify solve; do
  grep -qE "^  keyframe map: $stage +[0-9.]+ +[0-9.]+ +[0-9.]+ +[0-9.]+$" out.txt || fail "no times of $stage: $(cat out.txt)"
done

# ------------------------------------------------------------------------------------------------------------ without one
"$plumbline" "${run[@]}" --duration 2 --debug plain --timing plain.csv > out.txt 2> err.txt || fail "$(cat err.txt)"
data_of plain/report.html | grep -q '"map":null' || fail "a map on the page of a run without one"
awk -F, 'NR > 1 && $13 + $14 + $15 + $16 != 0 { bad = 1 } END { exit bad || NR < 2 }' plain.csv || fail "times of no map"
grep -q 'keyframe map' out.txt && fail "times of no map are printed"

# ----------------------------------------------------------------------------------------------------------- a comparison
compare=("$plumbline" compare --config "$config" --dataset loop)
"${compare[@]}" --map --json with.json > table.txt 2> log.txt || fail "compare --map: $(cat log.txt)"
grep -qE "^  $config --map .* [1-9][0-9]* loops, ATE of final poses 0\.[0-9]+ m$" table.txt || fail "$(cat table.txt)"
"${compare[@]}" --json without.json > table.txt 2> log.txt || fail "compare: $(cat log.txt)"
"$plumbline" compare --merge with.json without.json --json both.json --report both.html --markdown both.md > table.txt \
  2> log.txt || fail "compare --merge: $(cat log.txt)"
grep -qE "^. .$config. . se3 " both.md || fail "no row without a map: $(cat both.md)"
grep -qE "^. .$config --map. . se3 .* loops, ATE of final poses " both.md || fail "no row with a map: $(cat both.md)"
printf '<!-- table timing -->\n' > template.md
"$plumbline" table both.json --template template.md --markdown timing.md || fail "table timing"
grep -qE "^. .$config --map. .*( . [0-9.]+ \([0-9.]+\)){4} .$" timing.md || fail "no times of the map: $(cat timing.md)"
grep -qE "^. .$config. .*( . -){4} .$" timing.md || fail "times of a map that there is not: $(cat timing.md)"
data_of both.html > page.json
python3 - "$schema" << 'EOF' || fail "the comparison is not what its schema or its runs say"
import json, math, sys
both, run = json.load(open("both.json")), json.load(open("look.json"))["map"]
assert json.load(open("page.json"))["runs"] == both["runs"]
plain, mapped = both["runs"]
assert (plain["with_map"], mapped["with_map"]) == (False, True)
assert mapped["map_counts"]["loops"] == run["counts"]["loops"] > 0 and "map_counts" not in plain
assert abs(mapped["ate_final"]["rmse"] - run["ate_m"]["final"]) < 1e-5, mapped["ate_final"]
assert abs(mapped["ate"]["rmse"] - run["ate_m"]["causal"]) < 1e-5, mapped["ate"]
assert abs(plain["ate"]["rmse"] - run["ate_m"]["odometry"]) < 1e-5, plain["ate"]
assert len(mapped["map"]["points"]) > 500
try:
    import jsonschema
    jsonschema.Draft202012Validator(json.load(open(sys.argv[1]))).validate(both)
except ImportError:
    print("no python3-jsonschema here: both.json is not held against its schema")
EOF

expect_misuse 'loop.map: --report would overwrite' map loop.map --report loop.map
expect_failure 'missing/map.html: cannot be written' map loop.map --report missing/map.html
finish
