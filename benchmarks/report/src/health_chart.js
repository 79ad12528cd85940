/// Health over time: one lane for each run, with its name above it. What is worse is taller as well as of another color.
import { axis_style, font, health_colors, plot_in, spans_of, tick_texts } from './chart.js';
import { css_color } from './theme.js';
import { element } from './dom.js';
import { health_names } from './comparison.js';

const lane_height = 42, bar_height = [6, 9, 14, 20];

export function health_legend() {
  return element('div', { class: 'key' }, health_names.map(name =>
    element('span', {}, element('i', { class: `health-${name}` }), name)));
}

/// `lanes`: {name, t, health}.
export function health_chart(place, axis, lanes) {
  if (lanes.length === 0) {
    place.textContent = 'Nothing to draw here.';
    return () => place.replaceChildren();
  }
  const all = lanes.map(lane => spans_of(lane.t, lane.health));
  const draw = u => {
    const { ctx, bbox } = u, colors = health_colors(), ratio = devicePixelRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    all.forEach((spans, i) => {
      const base = bbox.top + ((i + 1) * lane_height - 5) * ratio;
      for (const [from, to, value] of spans) {
        const a = u.valToPos(from, 'x', true), b = u.valToPos(to, 'x', true), height = bar_height[value] * ratio;
        ctx.fillStyle = colors[value];
        ctx.fillRect(a, base - height, Math.max(b - a, ratio), height);
      }
      ctx.fillStyle = css_color('--ink');
      ctx.font = font(11 * ratio);
      ctx.textAlign = 'left';
      ctx.textBaseline = 'top';
      ctx.fillText(lanes[i].name, bbox.left + 2 * ratio, bbox.top + (i * lane_height + 3) * ratio);
    });
    ctx.restore();
  };
  const t = [axis.span[0], axis.span[1]];
  const plot = plot_in(place, {
    height: lanes.length * lane_height + 34,
    padding: [0, null, 0, 0],
    cursor: { sync: { key: axis.name, scales: ['x', null] }, y: false, points: { show: false } },
    legend: { show: false },
    scales: { x: { time: false, range: (u, low, high) => (u.zoomed ? [low, high] : axis.span) }, y: { range: [0, 1] } },
    axes: [axis_style({ size: 30, values: tick_texts('s') }), axis_style({ size: 54, grid: { show: false }, ticks: { show: false }, values: () => [] })],
    series: [{}, { show: true, paths: () => null, points: { show: false } }],
    hooks: { draw: [draw], setSelect: [u => { u.zoomed = true; }] },
  }, [t, t.map(() => 0)]);
  plot.over.addEventListener('dblclick', () => { plot.zoomed = false; }, true);
  const share = lane => health_names.map((name, value) => {
    const count = lane.health.filter(each => each === value).length;
    return count ? `${name} ${Math.round(100 * count / lane.health.length)} %` : '';
  }).filter(Boolean).join(', ');
  place.setAttribute('role', 'img');
  place.setAttribute('aria-label', `Health over time. ${lanes.map(lane => `${lane.name}: ${share(lane)}`).join('; ')}`);
  return () => {
    plot.take_down();
    place.replaceChildren();
  };
}
