#!/usr/bin/env bash
# Draws docs/images/room.png, the picture of the README: a simulated recording, one of its images with the features that
# are tracked in it, and the estimated trajectory with the points and lines of the map.
#   docs/draw_readme_picture.sh [PROGRAM]    default: build/release/benchmarks/plumbline/plumbline
# Needs Chromium (CHROMIUM=path, else /usr/bin/chromium).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

plumbline=$(realpath -e -- "${1:-build/release/benchmarks/plumbline/plumbline}")
picture=$PWD/docs/images/room.png
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
config=rgbd-imu/points+lines/window
frame=000246

"$plumbline" simulate --scene room --duration 20 --out "$work/room"
"$plumbline" run --config "$config" --dataset "$work/room" --trajectory "$work/room.tum" --debug "$work/debug"
"$plumbline" compare --config "$config" --dataset "$work/room" --json "$work/room.json"

{
  cat <<'HTML'
<!DOCTYPE html><meta charset="utf-8">
<style>
  body { margin: 0; width: 1400px; height: 560px; background: #fff; font: 17px "DejaVu Sans", sans-serif; color: #333; }
  figure { position: absolute; top: 0; margin: 0; }
  figcaption { position: absolute; top: 516px; left: 12px; width: 660px; }
  figcaption b { font-weight: 600; }
</style>
<figure style="left: 12px; top: 12px"><img id="image" width="660" height="495"></figure>
<figure style="left: 0"><figcaption>One image: tracked <b style="color: #1a9850">points</b> and <b
  style="color: #1a9850">lines</b></figcaption></figure>
<figure style="left: 690px"><canvas id="space" width="1400" height="1010" style="width: 700px; height: 505px"></canvas>
  <figcaption><b style="color: #1f5fd0">Trajectory</b>, <b style="color: #555">points</b> and <b
  style="color: #e07b00">lines</b> of the map</figcaption></figure>
<script type="module">
HTML
  printf 'const comparison = '
  cat "$work/room.json"
  printf ';\nconst image = "data:image/jpeg;base64,'
  base64 -w0 "$work/debug/frames/$frame.jpg"
  printf '";\n'
  cat <<'HTML'
document.getElementById("image").src = image;
const run = comparison.runs[0], { points, segments } = run.map, { x, y, z } = run.trajectory;
const azimuth = -0.62, elevation = 0.86;            // [rad] of the view
const project = ([px, py, pz]) => [
  px * Math.cos(azimuth) - py * Math.sin(azimuth),
  -(px * Math.sin(azimuth) + py * Math.cos(azimuth)) * Math.sin(elevation) - pz * Math.cos(elevation)];
const path = x.map((_, i) => project([x[i], y[i], z[i]]));
const dots = points.map(project), lines = segments.map((s) => [project(s.slice(0, 3)), project(s.slice(3, 6))]);
const all = [...path, ...dots, ...lines.flat()];
const [left, top] = [0, 1].map((k) => Math.min(...all.map((p) => p[k])));
const [right, bottom] = [0, 1].map((k) => Math.max(...all.map((p) => p[k])));
const canvas = document.getElementById("space"), pen = canvas.getContext("2d"), margin = 24;
const scale = Math.min((canvas.width - 2 * margin) / (right - left), (canvas.height - 2 * margin) / (bottom - top));
const at = ([u, v]) => [canvas.width / 2 + scale * (u - (left + right) / 2),
                        canvas.height / 2 + scale * (v - (top + bottom) / 2)];
const stroke = (polyline, color, width) => {
  pen.beginPath();
  for (const p of polyline) pen.lineTo(...at(p));
  Object.assign(pen, { strokeStyle: color, lineWidth: width, lineJoin: "round", lineCap: "round" });
  pen.stroke();
};
for (const line of lines) stroke(line, "rgba(224, 123, 0, 0.75)", 2.5);
pen.fillStyle = "rgba(85, 85, 85, 0.8)";
for (const dot of dots) {
  pen.beginPath();
  pen.arc(...at(dot), 2.6, 0, 7);
  pen.fill();
}
stroke(path, "#1f5fd0", 7);
</script>
HTML
} > "$work/picture.html"

"${CHROMIUM:-/usr/bin/chromium}" --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size=1400,560 \
  --user-data-dir="$work/chromium" --screenshot="$picture" "file://$work/picture.html" > "$work/chromium.log" 2>&1 ||
  { cat "$work/chromium.log" >&2; exit 1; }
echo "drew $picture"
