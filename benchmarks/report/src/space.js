/// The vertical axis, and the view from above.

const names = ['x', 'y', 'z'];

/// `up` is z unless another axis is clearly flatter: then there is no gravity in the data and the world is that of a
/// camera, whose y points down. `right` and `far` are the axes of the view from above.
export function view_of(paths, has_gravity = false) {
  const extent = names.map(name => {
    let low = Infinity, high = -Infinity;
    for (const path of paths)
      for (const value of path[name]) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    return high > low ? high - low : 0;
  });
  let flat = 2;
  for (const axis of [0, 1]) if (!has_gravity && extent[axis] < 0.8 * extent[flat]) flat = axis;
  const up = [0, 0, 0];
  up[flat] = flat === 1 ? -1 : 1;
  return { up, right: flat === 0 ? 'y' : 'x', far: flat === 2 ? 'y' : 'z' };
}

/// Box around the paths, null without any.
export function box_of(paths) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (const path of paths)
    names.forEach((name, k) => {
      for (const value of path[name]) {
        if (value < low[k]) low[k] = value;
        if (value > high[k]) high[k] = value;
      }
    });
  return low[0] <= high[0] ? { low, high } : null;
}

/// 1, 2 or 5 times a power of ten, about `parts` of them in the size.
export function round_step(size, parts) {
  const raw = size / parts, power = 10 ** Math.floor(Math.log10(raw));
  return [1, 2, 5, 10].map(factor => factor * power).find(step => step >= raw);
}

/// The position at a time, null where the path has none within 0.2 s.
export function place_at(path, t) {
  let best = -1;
  for (let i = 0; i < path.t.length; ++i)
    if (best < 0 || Math.abs(path.t[i] - t) < Math.abs(path.t[best] - t)) best = i;
  return best >= 0 && Math.abs(path.t[best] - t) < 0.2 ? names.map(name => path[name][best]) : null;
}
