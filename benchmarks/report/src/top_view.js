/// The scene from above, with equal scales: drag to look closer, double click for all of it.
import { axis_style, font, plot_in, tick_texts } from './chart.js';
import { box_of, place_at } from './space.js';
import { css_color } from './theme.js';

/// `scene`: {paths, points, segments} as of viewer.js, `view` as of space.js.
export function top_view(place, axis, scene, view, height) {
  const k = { right: 'xyz'.indexOf(view.right), far: 'xyz'.indexOf(view.far) };
  const around = box_of(scene.frame ?? scene.paths);
  if (!around) {
    place.textContent = 'Nothing to draw here.';
    return () => place.replaceChildren();
  }
  const whole = { left: around.low[k.right], right: around.high[k.right], bottom: around.low[k.far], top: around.high[k.far] };
  let box = whole;

  /// Ranges that show the box with the same scale both ways.
  const ranges = u => {
    const width = u.bbox?.width || place.clientWidth, tall = u.bbox?.height || height;
    const size = Math.max((box.right - box.left) / width, (box.top - box.bottom) / tall, 1e-9) * 1.1;
    const x = (box.left + box.right) / 2, y = (box.bottom + box.top) / 2;
    return { x: [x - size * width / 2, x + size * width / 2], y: [y - size * tall / 2, y + size * tall / 2] };
  };
  const fit = u => u.batch(() => {
    const now = ranges(u);
    u.setScale('x', { min: now.x[0], max: now.x[1] });
    u.setScale('y', { min: now.y[0], max: now.y[1] });
  });

  const draw = u => {
    const { ctx, bbox } = u, ratio = devicePixelRatio;
    const at = (x, y) => [u.valToPos(x, 'x', true), u.valToPos(y, 'y', true)];
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    for (const { positions, color, size = 2, opacity = 0.5 } of scene.points) {
      ctx.fillStyle = color;
      ctx.globalAlpha = opacity;
      for (const p of positions) ctx.fillRect(...at(p[k.right], p[k.far]).map(value => value - size / 2 * ratio), size * ratio, size * ratio);
    }
    ctx.lineCap = ctx.lineJoin = 'round';
    for (const { ends, color, opacity = 0.6, width = 1 } of scene.segments) {
      ctx.strokeStyle = color;
      ctx.globalAlpha = opacity;
      ctx.lineWidth = width * ratio;
      ctx.beginPath();
      for (const s of ends) {
        ctx.moveTo(...at(s[k.right], s[k.far]));
        ctx.lineTo(...at(s[3 + k.right], s[3 + k.far]));
      }
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
    for (const path of scene.paths) {
      ctx.strokeStyle = path.color;
      ctx.lineWidth = (path.width ?? 2) * ratio;
      ctx.setLineDash((path.dash ?? []).map(length => length * ratio));
      ctx.globalAlpha = path.faint ? 0.35 : 1;
      ctx.beginPath();
      for (let i = 0; i < path.t.length; ++i) ctx.lineTo(...at(path[view.right][i], path[view.far][i]));
      ctx.stroke();
      ctx.setLineDash([]);
      if (path.faint || !path.t.length) continue;
      ctx.fillStyle = path.color;
      ctx.beginPath();
      ctx.arc(...at(path[view.right][0], path[view.far][0]), 3.5 * ratio, 0, 2 * Math.PI);
      ctx.fill();
    }
    for (const path of scene.paths) {
      const here = axis.now === null || path.faint ? null : place_at(path, axis.now);
      if (!here) continue;
      ctx.beginPath();
      ctx.arc(...at(here[k.right], here[k.far]), 6 * ratio, 0, 2 * Math.PI);
      ctx.fillStyle = path.color;
      ctx.fill();
      ctx.lineWidth = 2 * ratio;
      ctx.strokeStyle = css_color('--card');
      ctx.stroke();
    }
    ctx.restore();
  };
  const plot = plot_in(place, {
    height,
    padding: [10, 12, 0, 0],
    cursor: { drag: { x: true, y: true, uni: 10, setScale: false }, points: { show: false } },
    legend: { show: false },
    scales: { x: { time: false, range: u => ranges(u).x }, y: { range: u => ranges(u).y } },
    axes: [axis_style({ size: 26, label: `${view.right} [m]`, labelSize: 18, labelFont: font(11), values: tick_texts('') }),
      axis_style({ size: 40, label: `${view.far} [m]`, labelSize: 18, labelFont: font(11), values: tick_texts('') })],
    series: [{}, { paths: () => null, points: { show: false } }],
    hooks: {
      draw: [draw],
      ready: [fit],
      setSize: [u => queueMicrotask(() => { if (u.root.isConnected) fit(u); })],  // not within its own commit
      setSelect: [u => {
        if (u.select.width < 4 && u.select.height < 4) return;
        const { left, top, width, height: tall } = u.select;
        box = { left: u.posToVal(left, 'x'), right: u.posToVal(left + width, 'x'), top: u.posToVal(top, 'y'), bottom: u.posToVal(top + tall, 'y') };
        u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        fit(u);
      }],
    },
  }, [[0, 1], [0, 1]]);
  plot.over.addEventListener('dblclick', () => { box = whole; fit(plot); });
  const on_now = () => plot.redraw(false);
  axis.listeners.add(on_now);
  place.setAttribute('role', 'img');
  place.setAttribute('aria-label', `From above: ${scene.paths.filter(path => !path.faint).map(path => path.name).join(', ')}`);
  return () => {
    axis.listeners.delete(on_now);
    plot.take_down();
    place.replaceChildren();
  };
}
