#!/usr/bin/env bash
# Measures the firmware in QEMU and writes docs/results/firmware.md.
#
#   examples/firmware/measure.sh BUILD      the folder of a release build, made with the tests
#
# The recording is that of the tests. PLUMBLINE_COMMIT replaces the commit of this checkout.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
(($# == 1)) || { sed -n '2,/^set -/{/^# \{0,1\}/s///p}' "${BASH_SOURCE[0]}" >&2; exit 2; }
build=$(realpath "$1")
page=$here/../../docs/results/firmware.md
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --build "$build" --target plumbline_program firmware_pack firmware_compare > "$work/build.log" \
  || { cat "$work/build.log"; exit 1; }
binaries=$build/examples/firmware
"$build/benchmarks/plumbline/plumbline" simulate --scene walk --size 320 240 --seed 1 --duration 7.2 --out "$work/simulated" \
  > "$work/build.log" 2>&1 || { cat "$work/build.log"; exit 1; }
"$binaries/firmware_pack" "$work/simulated" "$work/recording.bin" 1.5 5.6

if [[ -z ${PLUMBLINE_COMMIT:-} ]]; then
  PLUMBLINE_COMMIT=$(git -C "$here" rev-parse --short=10 HEAD)
  git -C "$here/../.." diff --quiet HEAD -- include examples cmake CMakeLists.txt || PLUMBLINE_COMMIT+=-changed
fi

# section ELF NAME: its size [byte]
section() { arm-none-eabi-size -A "$1" | awk -v name="$2" '$1 == name {print $2}'; }
kib() { awk -v bytes="$1" 'BEGIN {printf "%.0f", bytes / 1024}'; }

time_rows='' memory_rows='' equal_rows=''
measure() {  # NAME DISTANCE TITLE
  local name=$1 elf=$binaries/firmware_$1.elf
  cmake --build "$build" --target "firmware_$name" "firmware_host_$name" > "$work/build.log" \
    || { cat "$work/build.log"; exit 1; }
  local -A is
  while IFS='=' read -r key value; do is[$key]=$value; done < <(cd "$work" && "$here/run.sh" "$elf" \
    "$binaries/firmware_host_$name" "$binaries/firmware_compare" "$work/recording.bin" "$2")
  [[ -n ${is[stack_bytes]:-} ]] || { echo "$name: the run failed" >&2; exit 1; }
  time_rows+="| $3 | ${is[frame_median]} | ${is[frame_mean]} | ${is[frame_longest]} | ${is[idle_median]} | ${is[idle_longest]} |"$'\n'
  memory_rows+="| $3 | $(kib "$(section "$elf" .text)") | $(kib "${is[estimator_bytes]}") "
  memory_rows+="| $(kib $(($(section "$elf" .data) + $(section "$elf" .bss)))) | $(kib "${is[stack_bytes]}") |"$'\n'
  equal_rows+="| $3 | ${is[frames]} | ${is[tracking]} | ${is[same_keyframes]} | ${is[equal_frames]} | ${is[largest_distance_m]} |"$'\n'
}
measure window 1e-3 "window"
measure direct 2e-2 "direct"
measure window_reproducible 0 "window, reproducible"
measure direct_reproducible 0 "direct, reproducible"

cat > "$page" << PAGE
# Firmware

What the [firmware example](https://github.com/plumbline/plumbline/tree/main/examples/firmware) needs on a Cortex-M7,
and how its estimates compare with those of the host. *window*: \`Points<100>\` in \`SlidingWindow<6>\`; *direct*:
\`SemiDirectVio\` (\`Points<400>\`, \`Lines<100>\`). Camera of 320 x 240 px at 20 Hz, IMU at 200 Hz, \`float\`.

## Million instructions a frame

\`add_frame\`, and the keyframe work that is done after it in the idle loop, of the frames that have such work.

| estimator | add_frame: median | mean | longest | keyframe work: median | longest |
| --- | --- | --- | --- | --- | --- |
$time_rows
The longest frame is the one that ends the initialization. Where the next frame comes before the idle loop, keyframe work
is part of its \`add_frame\`.

## Memory [KiB]

*estimator* is \`sizeof(Vio)\`; *other* are the queue of IMU samples and constants of the C library; *stack* is what the run
used at most.

| estimator | code and constants | estimator | other | stack |
| --- | --- | --- | --- | --- |
$memory_rows
## Compared with the host

Health is equal in every frame. *same keyframe*: frames that are a keyframe in both or in neither. *equal frames*:
position and rotation have the same bits in this frame and in all before it. After the first difference of a bit, random
samples and thresholds decide otherwise; the reproducible build excludes that.

| estimator | frames | state \`tracking\` | same keyframe | equal frames | largest distance of positions [m] |
| --- | --- | --- | --- | --- | --- |
$equal_rows
*reproducible*: [flags](../guide/firmware.md#the-same-bits-everywhere).

Date: $(date -u +%F). Commit: $PLUMBLINE_COMMIT. Compilers: $(arm-none-eabi-g++ -dumpfullversion) for ARM,
$("$(awk -F= '/^CMAKE_CXX_COMPILER:/ {print $2}' "$build/CMakeCache.txt")" -dumpfullversion) for the host; \`-O2\` for ARM.
Emulator: $(qemu-system-arm --version | head -n 1 | sed 's/.*version \([0-9.]*\).*/QEMU \1/'), \`mps2-an500\`.
Command: \`examples/firmware/measure.sh build/release\`.
PAGE
echo "$page"
