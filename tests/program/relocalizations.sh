#!/usr/bin/env bash
# plumbline relocalizations: runs find their place in a map of the first half, where they see it, and nowhere else.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf loop corridor ./*.json ./*.md
"$plumbline" simulate --scene room --laps 2 --size 320 240 --out loop > /dev/null 2>&1
"$plumbline" relocalizations --config "$config" --dataset loop --every 3 --duration 1.5 --json all.json --markdown all.md \
  > out.txt 2> err.txt || fail "relocalizations: $(cat err.txt)"
cat out.txt
python3 - << 'EOF' || fail "the figures are not plausible"
import json
result = json.load(open("all.json"))
(group,) = result["groups"]
assert result["kind"] == "relocalizations" and group["keyframes"] > 5 and group["map_bytes"] > 1000
runs = group["runs"]
assert len(runs) >= 3, runs
found = [run for run in runs if run["localized_s"] is not None]
assert len(found) >= 0.7 * len(runs), runs
for run in found:
    assert run["pose_s"] <= run["localized_s"] <= 1.5 and run["poses"] > 0 and run["queries"] > 0, run
    assert run["rmse_m"] < 0.1 and run["rmse_deg"] < 2 and run["right_poses"] == run["poses"], run
    assert run["rmse_m"] <= run["max_m"] < 0.25 and run["query_ms"] > 0, run
EOF
grep -qE "^. .$config. . [0-9]+ . [0-9]+ of [0-9]+ . [0-9]+ % .* . [0-9.]+ m, [0-9.]+ deg . [0-9.]+ m . 100 % . [0-9.]+ .$" all.md ||
  fail "the table: $(cat all.md)"
grep -qF "plumbline relocalizations --config $config --dataset loop --every 3 --duration 1.5" all.md || fail "no command"
printf '<!-- table relocalizations -->\n' > template.md
"$plumbline" table all.json --template template.md --markdown page.md || fail "table relocalizations"
grep -qE "^. .$config. " page.md || fail "no table: $(cat page.md)"

# A corridor is not seen again: its second half is out of reach of the first one.
"$plumbline" simulate --scene corridor --duration 12 --size 320 240 --out corridor > /dev/null 2>&1
"$plumbline" relocalizations --config "$config" --dataset corridor --every 2 --duration 1 --json far.json > out.txt \
  2> err.txt || fail "corridor: $(cat err.txt)"
python3 - << 'EOF' || fail "runs count that are out of reach of the map"
import json
(group,) = json.load(open("far.json"))["groups"]
assert group["out_of_reach"] > len(group["runs"]), group
EOF

expect_error 'has no true trajectory' relocalizations --config "$config" --dataset "$(rm -rf blind && cp -r loop blind &&
  rm blind/groundtruth* && echo blind)"
expect_misuse '--duration' relocalizations --config "$config" --dataset loop --duration 0
expect_misuse 'is unknown, did you mean' relocalizations --config rgbd/points/widow --dataset loop
finish
