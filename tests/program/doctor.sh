#!/usr/bin/env bash
# plumbline doctor: nothing wrong with a good recording, and each of these faults named with what to do.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf good late ./*.json
"$plumbline" simulate --scene room --duration 8 --out good > /dev/null 2>&1
# expect_diagnosis STATUS PATTERN ARGUMENT...: of the doctor's lines one matches.
expect_diagnosis() {
  local expected=$1 pattern=$2 status=0
  shift 2
  "$plumbline" doctor "$@" > out.txt 2> err.txt || status=$?
  [[ $status == "$expected" ]] || fail "$*: status $status instead of $expected: $(cat out.txt err.txt)"
  grep -qE -- "$pattern" out.txt || fail "$*: no \"$pattern\" in: $(cat out.txt)"
}
expect_diagnosis 0 '^OK +extrinsics ' good --json good.json
cat out.txt
for check in recording corners 'time offset' accelerometer 'depth scale'; do
  grep -qE "^OK +$check " out.txt || fail "not OK: $check"
done
! grep -qE '^(WARN|ERROR)' out.txt || fail "a good recording is not good: $(cat out.txt)"
for part in '"format": "plumbline-doctor"' '"check": "extrinsics"' '"level": "OK"'; do
  grep -qF "$part" good.json || fail "no $part in the JSON: $(cat good.json)"
done

"$plumbline" simulate --scene room --duration 8 --out late --late 0.11 > /dev/null 2>&1
expect_diagnosis 1 '^ERROR +time offset +.* 1(09|10|11)\.[0-9] ms earlier than stamped: give --time-offset -0\.1(09|10|11) ' late
expect_diagnosis 0 '^OK +time offset ' late --time-offset -0.11

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
expect_error 'no such directory' doctor missing
expect_misuse 'dataset is required' doctor
finish
