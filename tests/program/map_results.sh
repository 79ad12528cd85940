#!/usr/bin/env bash
# docs/results/measure_map.py: what it measures, and the tables of it.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"
results=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../docs/results" && pwd)
python=/usr/bin/python3  # Debian's: it has numpy
"$python" -c 'import numpy' 2> /dev/null || { echo "skipped: no python3-numpy"; exit 77; }
export PYTHONDONTWRITEBYTECODE=1

# Known trajectories: scale, heading and place are removed by the alignment of their kind, and nothing else is.
PYTHONPATH=$results "$python" - << 'END' || fail "the figures of known trajectories are wrong"
import numpy as np
import measure_map as m
random = np.random.default_rng(1)
t = np.arange(0, 9, 0.05)
n = len(t)
p = np.stack([3 * np.sin(0.7 * t), 2 * np.cos(0.9 * t), np.sin(1.3 * t)], axis=1)
turn = np.stack([0 * t, 0 * t, np.sin(0.2 * t), np.cos(0.2 * t)], axis=1)  # about z by 0.4 t
truth = m.Poses(t, p, turn)
yaw = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
tilt = np.array([[1, 0, 0], [0, 0.6, -0.8], [0, 0.8, 0.6]])
offset = np.array([5.0, -7.0, 2.0])
for kind, scale, R in (("sim3", 0.2, tilt @ yaw), ("se3", 1, tilt @ yaw), ("posyaw", 1, yaw)):
    moved = m.Poses(t, scale * p @ R.T + offset, turn)
    ate, laps, found = m.errors_in_laps(moved, truth, kind, t[0], t[-1])
    assert ate < 1e-9 and max(laps) < 1e-9 and abs(found - 1 / scale) < 1e-9, (kind, ate, laps, found)
for kind, scale, R in (("se3", 0.2, yaw), ("posyaw", 1, tilt)):
    ate, _, _ = m.errors_in_laps(m.Poses(t, scale * p @ R.T, turn), truth, kind, t[0], t[-1])
    assert ate > 0.1, (kind, ate)
# An error of a tenth in the last lap is there, and not in the laps before it.
shifted = p.copy()
shifted[t > 6.01] += [0, 0, 0.1]
ate, laps, _ = m.errors_in_laps(m.Poses(t, shifted, turn), truth, "posyaw", t[0], t[-1])
assert 0.06 < laps[2] < 0.07 and laps[0] < 0.04 and abs(ate - 0.1 * np.sqrt(2) / 3) < 1e-3, (ate, laps)
assert abs(m.end_error(m.Poses(t, shifted, turn), truth, 1) - 0.1) < 1e-9
assert abs(m.end_error(m.Poses(t, p / 2, turn), truth, 2)) < 1e-9
# Interpolation, also where a quaternion changes its sign.
flipped = turn.copy()
flipped[n // 2:] *= -1
between = m.Poses(t, p, flipped).at(np.array([t[n // 2] - 0.025]))
angle = 0.4 * (t[n // 2] - 0.025)
assert np.allclose(between.rotation(0)[:2, 0], [np.cos(angle), np.sin(angle)], atol=1e-6)
run = {"causal": m.Poses(t, 2.5 * p @ yaw.T, turn), "world": m.Poses(t, p, turn)}
assert abs(m.unit_of_world(run, 3) - 2.5) < 1e-6
END

rm -rf work result.json ./*.md
"$results/measure_map.py" "$plumbline" . work result.json --config "$config" no/such/configuration --scene room \
  --seed 5 --size 320 240 --runs 1 --black 2 --recording 2> err.txt || fail "measure_map.py: $(cat err.txt)"
room=work/room_5_320_240
"$plumbline" run "$room" --config "$config" --trajectory alone.tum > /dev/null 2>&1
"$plumbline" evaluate --reference "$room/groundtruth.txt" --estimate alone.tum --align se3 --json > alone.json
python3 - << 'END' || fail "the figures are not plausible: $(cat result.json)"
import json
result = json.load(open("result.json"))
assert result["kind"] == "map" and result["format"] == "plumbline-results" and result["version"] == 1
alone, with_map = result["map"]["laps"]
assert not alone["with_map"] and with_map["with_map"] and alone["laps"] == 3
(before,), (after,) = alone["runs"], with_map["runs"]
assert abs(before["ate_m"] - json.load(open("alone.json"))["ape"]["translation_m"]["rmse"]) < 1e-5, before
assert before["loops"] is None and before["final_m"] is None and after["loops"] >= 3, after
for run in before, after:
    assert run["poses"] > 0.95 * run["frames"] and 15 < run["path_m"] < 25 and len(run["lap_m"]) == 3, run
    assert 0.0005 < run["ate_m"] < 0.05 and max(run["lap_m"]) < 0.08 and run["end_m"] < 0.1, run
    assert min(run["lap_m"]) <= run["ate_m"] <= max(run["lap_m"]), run
assert after["final_m"] < 0.05, after
alone, with_map = result["map"]["lost"]
(before,), (after,) = alone["runs"], with_map["runs"]
assert before["found_s"] is None, before  # without a map the world after the outage is another one
assert after["pose_s"] <= after["within_s"] <= after["found_s"] <= 1 and after["found_error_m"] < 0.05, after
assert after["begin_s"] >= 26 and after["before_m"] < 0.05 and after["frames"] >= after["poses"] > 10, after
assert result["map"]["recordings"] == []
END
"$plumbline" table result.json --markdown all.md || fail "table of kind map"
for part in '^`room`, seed 5: 3 laps, 1 run\.$' '^`room`, seed 5: black for 2 s, 1 run\.$' \
  "^. .$config. \| 0\.0[0-9]+ \(0\.0[0-9]+\) \|.* \| - \| 0\.[0-9]+ % \(0\.[0-9]+ %\) \| - \| (9[5-9]|100) %" \
  "^. .$config --map. \| 0\.0[0-9]+ \(0\.0[0-9]+\) \|.* \| [0-9]+ \| (9[5-9]|100) %" \
  "^. .$config. \| .* \| never \(never\) \| - \| 0 % \(0\) \| " \
  "^. .$config --map. \| .* s\) \| 0\.0[0-9]+, [0-9.]+ \| 100 % \(1\) \| "; do
  grep -qE -- "$part" all.md || fail "no line $part: $(cat all.md)"
done

# Runs that fail, and what was never found.
cat > failed.json << 'END'
{"format": "plumbline-results", "version": 1, "kind": "map", "date": "2026-11-28", "commit": null, "command": null,
 "machine": {"cpu": "x", "cores": 2, "memory_gib": 4, "os": "x", "compiler": "x", "build": "x", "plumbline": "x"},
 "map": {"laps": [], "lost": [{"dataset": "room", "seed": 1, "black_s": 6, "configuration": "a", "with_map": true,
  "runs": [
   {"poses": 9, "false_frames": 2, "within_s": 1.5, "within_error_m": 0.02, "within_sigma_m": 0.4, "found_s": 0.5,
    "found_error_m": 0.03, "found_sigma_m": 0.01},
   {"poses": 0, "false_frames": 0, "within_s": null, "within_error_m": null, "within_sigma_m": null, "found_s": null,
    "found_error_m": null, "found_sigma_m": null},
   {"poses": 5, "false_frames": 1, "within_s": 2.5, "within_error_m": 0.04, "within_sigma_m": 0.6, "found_s": 1.5,
    "found_error_m": 0.01, "found_sigma_m": 0.03}]}],
  "recordings": [{"dataset": "flight", "configuration": "a", "with_map": false, "runs": [
   {"ate_m": 0.01, "final_m": null, "coverage": 0.9, "loops": null},
   {"ate_m": 0.03, "final_m": null, "coverage": 0.8, "loops": null},
   {"ate_m": null, "final_m": null, "coverage": 0, "loops": null}]}]}}
END
printf '<!-- table map_lost -->\n<!-- table map_recordings -->\n' > template.md
"$plumbline" table failed.json --template template.md --markdown failed.md || fail "table map_lost"
for row in '| `a --map` | 2.50 s (never) | 0.0300, 0.500 | 1.50 s (never) | 0.0200, 0.0200 | 33 % (1) | 3 of 14 |' \
  '| `a` | 0.0300 (failed) | - | - | 0 % | 1 of 3 |'; do
  grep -qxF -- "$row" failed.md || fail "no row $row: $(cat failed.md)"
done
"$plumbline" table result.json --template "$results/templates/map.md" --markdown page.md || fail "no page"
grep -qx 'No runs.' page.md || fail "recordings that were not run: $(cat page.md)"
grep -q '^Date .*, commit ' page.md || fail "no origin: $(cat page.md)"
finish
