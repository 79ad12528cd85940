#!/usr/bin/env bash
# A body that stops keeps its position while stationary, with every kind of feature, and the departure is detected.
# shellcheck source=tests/program/expect.sh
source "$(dirname "${BASH_SOURCE[0]}")/expect.sh"

rm -rf room
"$plumbline" simulate --scene room --out room --duration 13 --stop 6 11 2> log.txt || fail "simulate: $(tail -1 log.txt)"

# It is stationary from 7 s on, which is detected a second later, and has moved 3 mm at 11.3 s.
for config in {rgbd-imu,mono-imu}/{points,lines,points+lines}/window; do
  "$plumbline" run --config "$config" --dataset room --trajectory out.tum --states states.csv > log.txt 2>&1 ||
    fail "$config: $(tail -1 log.txt)"
  read -r speed moved_mm left_s < <(awk -F, '
    NR == 1 {for (i = 1; i <= NF; ++i) at[$i] = i; next}
    NR == 2 {first_ns = $1}
    $at["v_x"] != "" {
      t = ($1 - first_ns) / 1e9; x = $at["p_x"]; y = $at["p_y"]; z = $at["p_z"]
      v = sqrt($at["v_x"]^2 + $at["v_y"]^2 + $at["v_z"]^2)
      if (t > 8.2 && t < 11.01) {
        if (!n++) {x0 = x; y0 = y; z0 = z}
        moved = sqrt((x - x0)^2 + (y - y0)^2 + (z - z0)^2); if (moved > far) far = moved; if (v > fast) fast = v
      }
      if (t > 11.01 && v > 0.02 && !left) left = t - 11
    }
    END {if (n < 50) fast = 1; print fast + 0, 1000 * far, left ? left : 9}' states.csv)
  echo "$config: at most $speed m/s and $moved_mm mm while stationary, departure after $left_s s"
  awk -v v="$speed" -v mm="$moved_mm" -v s="$left_s" 'BEGIN {exit !(v < 0.005 && mm < 1 && s < 0.36)}' ||
    fail "$config: $speed m/s, $moved_mm mm, left after $left_s s"
done
finish
