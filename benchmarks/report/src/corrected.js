/// A trajectory as a map has it now.

/// x -> s R x + t of [s, quaternion x y z w, t].
export function moved([s, qx, qy, qz, qw, ...t], [x, y, z]) {
  const a = 2 * (qy * z - qz * y), b = 2 * (qz * x - qx * z), c = 2 * (qx * y - qy * x);
  return [s * (x + qw * a + qy * c - qz * b) + t[0], s * (y + qw * b + qz * a - qx * c) + t[1], s * (z + qw * c + qx * b - qy * a) + t[2]];
}

/// Each position of the world with the correction of the latest keyframe before it; both in order of time.
export function corrected({ t, world }, { t: times, S_map_world }) {
  const out = { t, x: [], y: [], z: [] };
  let k = 0;
  t.forEach((time, i) => {
    while (k + 1 < times.length && times[k + 1] <= time) ++k;
    const [x, y, z] = times.length ? moved(S_map_world[k], world[i]) : world[i];
    out.x.push(x);
    out.y.push(y);
    out.z.push(z);
  });
  return out;
}
