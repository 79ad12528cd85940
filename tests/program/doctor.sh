#!/usr/bin/env bash
# plumbline doctor: nothing wrong with a good recording, and each of these faults named with what to do.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

schema=$(dirname "${BASH_SOURCE[0]}")/../../docs/doctor.schema.json

rm -rf good late ./*.json ./*.html
"$plumbline" simulate --scene room --duration 8 --out good > /dev/null 2>&1
# expect_diagnosis STATUS PATTERN ARGUMENT...: of the doctor's lines one matches.
expect_diagnosis() {
  local expected=$1 pattern=$2 status=0
  shift 2
  "$plumbline" doctor "$@" > out.txt 2> err.txt || status=$?
  [[ $status == "$expected" ]] || fail "$*: status $status instead of $expected: $(cat out.txt err.txt)"
  grep -qE -- "$pattern" out.txt || fail "$*: no \"$pattern\" in: $(cat out.txt)"
}
expect_diagnosis 0 '^OK +extrinsics ' good --json good.json --report good.html
cat out.txt
for check in recording corners 'time offset' accelerometer 'depth scale'; do
  grep -qE "^OK +$check " out.txt || fail "not OK: $check"
done
! grep -qE '^(WARN|ERROR)' out.txt || fail "a good recording is not good: $(cat out.txt)"
for part in '"format": "plumbline-doctor"' '"check": "extrinsics"' '"level": "OK"'; do
  grep -qF "$part" good.json || fail "no $part in the JSON: $(cat good.json)"
done
# The JSON fits its schema; the page has the same diagnoses, and what the recording has over time.
python3 - "$schema" << 'END' || fail "the files are not what the recording is"
import json, statistics, sys
found = json.load(open("good.json"))
try:
    import jsonschema
    jsonschema.Draft202012Validator(json.load(open(sys.argv[1]))).validate(found)
except ImportError:
    print("no python3-jsonschema here: good.json is not held against its schema")
place = '<script type="application/json" id="plumbline-data">'
page = json.loads([line for line in open("good.html") if line.startswith(place)][0][len(place):].strip().removesuffix("</script>"))
printed = [[line[:5].strip(), line[6:19].strip(), line[20:].rstrip("\n")] for line in open("out.txt")]
for each in (found, page):
    assert [[d["level"], d["check"], d["text"]] for d in each["diagnoses"]] == printed, each["diagnoses"]
assert page["dataset"] == "good", page["dataset"]
series = page["series"]
assert len(series["images"]["intervals"]["ms"]) == 159 and statistics.median(series["images"]["intervals"]["ms"]) == 50
assert statistics.median(series["imu"]["intervals"]["ms"]) == 5
rows = [[float(v) for v in line.split()] for line in open("good/imu.csv") if line[0] != "#"]
for sensor, first in (("gyroscope", 1), ("accelerometer", 4)):
    for k, axis in enumerate("xyz"):
        drawn = series["imu"][sensor][axis]
        assert len(drawn) == len(rows) and max(abs(a - r[first + k]) for a, r in zip(drawn, rows)) < 1e-4, (sensor, axis)
looks = series["looks"]
assert len(looks["t"]) == 160 and looks["corners"][0] is None and min(looks["corners"][1:]) > 30
assert all(20 < b < 235 and c > 10 for b, c in zip(looks["brightness"], looks["contrast"]))
END
expect_misuse 'both --json and --report name this file' doctor good --json same --report same
expect_misuse '--report would overwrite what is read' doctor good --report good/imu.csv

"$plumbline" simulate --scene room --duration 8 --out late --late 0.11 > /dev/null 2>&1
expect_diagnosis 1 '^ERROR +time offset +.* 1(09|10|11)\.[0-9] ms earlier than stamped: give --time-offset -0\.1(09|10|11) ' late
expect_diagnosis 0 '^OK +time offset ' late --time-offset -0.11
# In small images of walls the motion is easily mistaken for a rotation.
rm -rf small
"$plumbline" simulate --scene room --size 320 256 --duration 14 --stop 4 9 --late 0.4 --out small > /dev/null 2>&1
expect_diagnosis 1 '^ERROR +time offset +.* (39[89]|40[01])\.[0-9] ms earlier than stamped: give --time-offset -0\.(399|40[01]) ' small
expect_diagnosis 0 '^OK +time offset +.* [01]\.[0-9] ms ' small --time-offset -0.4

# altered NAME AWK: a copy whose IMU samples (t, gyroscope, accelerometer) are altered.
altered() {
  rm -rf "$1"
  cp -r good "$1"
  awk -v OFS=' ' "/^#/ {print; next} {gsub(\",\", \" \"); \$0 = \$0; $2; print}" good/imu.csv > "$1/imu.csv"
}
altered sign '$5 = -$5; $6 = -$6; $7 = -$7'
expect_diagnosis 1 '^ERROR +accelerometer +the sign of the accelerometer is reversed' sign
altered mirrored '$2 = -$2'
expect_diagnosis 1 '^ERROR +gyroscope +one axis of the gyroscope' mirrored
altered bursts 'n = NR - NR % 10; if (!(n in base)) base[n] = $1; $1 = sprintf("%.6f", base[n] + (NR % 10) * 0.0001)'
expect_diagnosis 1 '^ERROR +recording +bursts/imu.csv: the IMU samples come in bursts of 10, 0.1 ms apart' bursts
expect_error 'bursts/imu.csv: the IMU samples come in bursts of 10' run bursts --config mono-imu/points/window

expect_diagnosis 1 '^ERROR +depth scale +by the accelerometer a value of .* is 1 m, the calibration states 5000: --depth-scale 1000\?$' \
  good --depth-scale 5000

# The transform turned about the optical axis, and its inverse.
"$plumbline" calibration good/calibration.yaml --to plain > plain.yaml
python3 - << 'END'
rows = [[float(v) for v in line.strip(" ]\n").rstrip(",").split(",")] for line in open("plain.yaml") if line.startswith("   ")]
def write(name, T):
    text, n = "", 0
    for line in open("plain.yaml"):
        if line.startswith("   "):
            line = "   " + ", ".join(repr(v) for v in T[n]) + ("]\n" if n == 3 else ",\n")
            n += 1
        text += line
    open(name, "w").write(text)
write("turned.yaml", [[r[1], -r[0], r[2], r[3]] for r in rows[:3]] + [rows[3]])
R = [[rows[j][i] for j in range(3)] for i in range(3)]
write("inverse.yaml", [R[i] + [-sum(R[i][k] * rows[k][3] for k in range(3))] for i in range(3)] + [rows[3]])
END
expect_diagnosis 1 '^ERROR +extrinsics +.* off by (89|90|91) degrees: the camera is turned by -?90 degrees about the optical axis against it$' \
  good --calibration turned.yaml
expect_diagnosis 1 '^ERROR +extrinsics +.*: the inverse of the stated transform fits' good --calibration inverse.yaml
# simulated NAME OPTION...: a recording with rest from 4 to 10 s and a fault; the images are too small to be followed.
simulated() {
  local name=$1
  shift
  rm -rf "$name"
  "$plumbline" simulate --duration 14 --stop 3 10 --size 160 160 --out "$name" "$@" > /dev/null 2>&1 || fail "simulate $*"
}
expect_no() { ! grep -qE -- "$1" out.txt || fail "\"$1\" in: $(cat out.txt)"; }
simulated rest
expect_diagnosis 0 '^OK +IMU noise +by [4-6]\.[0-9] s at rest: gyroscope 0\.00[0-9]+ rad/s/sqrt\(Hz\) \(' rest --json rest.json
expect_no '^(WARN|ERROR)'
python3 - << 'END' || fail "the noise is not what was simulated: $(cat rest.json)"
import json
noise = json.load(open("rest.json"))["imu_noise"]
for sensor, density, walk in (("gyroscope", 1.7e-4, 2e-5), ("accelerometer", 2e-3, 3e-3)):
    found = noise[sensor]
    assert density / 1.5 < found["density"]["value"] < 1.5 * density and found["density"]["low"] < 1.1 * density, sensor
    assert found["random_walk"]["high"] > walk and found["vibration_peak_hz"] is None, sensor
END
simulated noisy --noise-factor 4
expect_diagnosis 0 '^WARN +IMU noise +the calibration states 0\.00017 rad/s/sqrt\(Hz\) as noise density of the gyroscope, [34]\.[0-9] times less' noisy
expect_diagnosis 0 '^WARN +IMU noise +the calibration states 0\.002 m/s\^2/sqrt\(Hz\) as noise density of the accelerometer, [34]\.[0-9] times less' noisy
simulated quiet --noise-factor 0.1
expect_diagnosis 0 '^WARN +IMU noise +.* as noise density of the gyroscope, ([89]|10)\.[0-9] times more than .* at most' quiet
simulated shaken --vibration 8 63
expect_diagnosis 0 '^WARN +vibration +the accelerometer has (7\.9|8|8\.1) m/s\^2 rms above 10 Hz in motion, most at 6[23] Hz' shaken
expect_diagnosis 0 'IMU noise +.*as something vibrates with 6[23] Hz even then' shaken
expect_no 'WARN +IMU noise .*accelerometer'
simulated saturated --accel-range 9.8
expect_diagnosis 0 '^WARN +saturation +[0-9]+ of 280. samples of the accelerometer are saturated at 9\.8 m/s\^2' saturated
# With images that are followed.
rm -rf faulty covered
followed=(simulate --duration 8)
"$plumbline" "${followed[@]}" --out faulty --extrinsics-turn 0 0 90 --accel-sign > /dev/null 2>&1
expect_diagnosis 1 '^ERROR +extrinsics +.*: the camera is turned by -?90 degrees about the optical axis against it$' faulty
grep -qE '^ERROR +accelerometer +the sign of the accelerometer is reversed' out.txt || fail "no sign: $(cat out.txt)"
"$plumbline" "${followed[@]}" --out covered --bonnet 0.25 --held-accel 3 > /dev/null 2>&1
expect_diagnosis 1 '^ERROR +still part +(1[5-9]|2[0-9]) % of the image does not move.*Exclude it by --mask FILE' covered
{
  printf 'P5\n640 480\n255\n'
  head -c $((640 * 359)) /dev/zero | tr '\0' '\377'
  head -c $((640 * 121)) /dev/zero
} > mask.pgm
"$plumbline" doctor covered --mask mask.pgm > masked.txt 2>&1 || true
grep -qE '^OK +corners' masked.txt || fail "doctor --mask: $(cat masked.txt)"
! grep -q 'still part' masked.txt || fail "doctor --mask: $(grep 'still part' masked.txt)"
grep -qE '^NOTE +files +.*imu.csv: the accelerometer has new values at 67 Hz' out.txt || fail "no word about held values: $(cat out.txt)"
# The table of answers to inputs from the field; marks of Markdown in them are text.
cat > field.json << 'END'
{"format": "plumbline-results", "version": 1, "kind": "field", "date": "2026-11-28", "commit": null, "command": null,
 "machine": {"cpu": "x", "cores": 2, "memory_gib": 4, "os": "x", "compiler": "x", "build": "x", "plumbline": "x"},
 "inputs": [{"name": "late", "what": "late images", "doctor": {"status": 1, "lines": ["ERROR a|b_c", "WARN <d>"]},
             "run": {"status": 0, "lines": ["fine"]}}]}
END
"$plumbline" table field.json > out.txt || fail "table of kind field"
grep -qF '| `late` | late images | 1: ERROR a\|b\_c<br>WARN \<d> | 0: fine |' out.txt || fail "the table is: $(cat out.txt)"
expect_error 'no such directory' doctor missing
expect_misuse 'dataset is required' doctor
finish
