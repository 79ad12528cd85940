#!/usr/bin/env bash
# Runs the firmware in QEMU and the same estimator on the host, and compares them.
#
#   examples/firmware/run.sh ELF HOST COMPARE RECORDING DISTANCE     a packed recording; DISTANCE as of firmware_compare
#
# The lines of the frames are left in host.txt and firmware.txt of this folder.
set -euo pipefail
(($# == 5)) || { sed -n '2,/^set -/{/^# \{0,1\}/s///p}' "${BASH_SOURCE[0]}" >&2; exit 2; }
elf=$1 host=$2 compare=$3 recording=$4 distance=$5

"$host" "$recording" > host.txt
rm -f firmware.txt
# One instruction takes one nanosecond of the board's time, whatever this machine does meanwhile.
qemu-system-arm -machine mps2-an500 -display none -monitor none -serial file:firmware.txt -icount shift=0 \
  -semihosting-config enable=on,target=native -kernel "$elf" \
  -device loader,file="$recording",addr=0x60000000,force-raw=on \
  || { echo "$elf: ended with status $? after $(wc -l < firmware.txt) frames" >&2; exit 1; }
"$compare" host.txt firmware.txt "$distance"
