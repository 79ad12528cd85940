/// What all charts have in common: colors of the page, the size of their place, curves over time with one time axis.
import uPlot from 'uplot';
import { css_color } from './theme.js';
import { is_number, quantile, text_of, median, largest } from './figures.js';

export const font = size => `${size}px ${getComputedStyle(document.body).fontFamily}`;

/// A uPlot as wide as its place. Returns the plot; `take_down` removes it.
export function plot_in(place, options, data) {
  const size = () => ({ width: Math.max(place.clientWidth, 120), height: options.height });
  const plot = new uPlot({ ...options, ...size() }, data, place);
  const observer = new ResizeObserver(() => {
    if (place.clientWidth > 0 && place.clientWidth !== plot.width) plot.setSize(size());
  });
  observer.observe(place);
  plot.take_down = () => {
    observer.disconnect();
    plot.destroy();
  };
  return plot;
}

/// Labels of ticks `step` apart: all with the decimals that the step needs.
export const tick_texts = unit => (plot, ticks, axis, space, step) => ticks.map(value => {
  if (value === null) return '';
  const unit_text = unit ? ` ${unit}` : '';
  if (Math.abs(value) < step / 1e3) return `0${unit_text}`;
  const size = plot.scales[plot.axes[axis].scale].distr === 3 ? value : step;
  const decimals = [0, 1, 2, 3, 4, 5, 6, 7, 8].find(n => Math.abs(size * 10 ** n - Math.round(size * 10 ** n)) < 1e-6 * size * 10 ** n) ?? 9;
  return `${value.toFixed(decimals)}${unit_text}`;
});

export function axis_style(rest = {}) {
  return { stroke: css_color('--muted'), font: font(11), grid: { stroke: css_color('--grid'), width: 1 },
    ticks: { stroke: css_color('--grid'), width: 1, size: 4 }, gap: 4, ...rest };
}

/// The time that all charts of a page share: the cursor of one is the cursor of all, and `now` is the time that a
/// reader chose.
export class TimeAxis {
  constructor(name) {
    this.name = name;
    this.span = [0, 1];
    this.now = null;
    this.listeners = new Set();
  }
  choose(t) {
    this.now = t;
    for (const listener of this.listeners) listener(t);
  }
}

/// From zero, if nothing is negative, to the largest value; with `clip` to three times the 98th percentile at most.
function range_of(clip, log) {
  return (plot, low, high) => {
    if (low === null || high === null) return log ? [0.1, 1] : [0, 1];
    if (log) return uPlot.rangeLog(low, high, 10, false);
    const bottom = Math.min(low, 0), top = Math.max(clip ? Math.min(high, clip) : high, 0);
    const margin = 0.06 * (top - bottom) || 1;
    return [bottom < 0 ? Math.max(bottom, clip ? -clip : -Infinity) - margin : 0, top > 0 ? top + margin : bottom < 0 ? 0 : 1];
  };
}

/// Spans of equal values of a series over time: [from, to, value].
export function spans_of(t, values) {
  const out = [];
  for (let i = 0; i < t.length; ++i) {
    const end = i + 1 < t.length ? t[i + 1] : t[i];
    if (out.length && out[out.length - 1][2] === values[i]) out[out.length - 1][1] = end;
    else out.push([t[i], end, values[i]]);
  }
  return out;
}

export const health_colors = () => ['--initializing', '--tracking', '--degraded', '--lost'].map(css_color);

/// Curves over time. `curves`: {name, t, y, color, dash, width, faint}; faint ones are not in the legend.
/// `background`: spans of health behind all of it.
export function time_chart(place, axis, { label, unit, curves, height = 210, log = false, clip = false, background = null }) {
  const shown = curves.filter(curve => curve.t.length > 0);
  if (!shown.some(curve => curve.y.some(is_number))) {
    place.textContent = 'Nothing to draw here.';
    return () => place.replaceChildren();
  }
  const positive = y => (log ? Array.from(y, value => (value > 0 ? value : null)) : y);
  const tables = shown.map(curve => [curve.t, positive(curve.y)]);
  const data = tables.every(([t]) => t === tables[0][0]) ? [tables[0][0], ...tables.map(([, y]) => y)] : uPlot.join(tables);
  const limit = clip ? 3 * quantile(shown.flatMap(curve => Array.from(curve.y, value => (is_number(value) ? Math.abs(value) : null))), 0.98) : 0;
  const colors = health_colors();
  const line = document.createElement('div');
  line.className = 'now';
  const place_line = plot => {
    const x = axis.now === null ? -1 : plot.valToPos(axis.now, 'x');
    line.hidden = !(x >= 0 && x <= plot.over.clientWidth);
    line.style.transform = `translateX(${x}px)`;
  };

  const plot = plot_in(place, {
    height,
    cursor: { sync: { key: axis.name, scales: ['x', null] }, drag: { x: true, y: false }, points: { size: 6 } },
    scales: { x: { time: false, range: (u, low, high) => (u.zoomed ? [low, high] : axis.span) }, y: { distr: log ? 3 : 1, range: range_of(limit, log) } },
    axes: [axis_style({ size: 30, values: tick_texts('s') }), axis_style({ size: 54, values: tick_texts('') })],
    padding: [8, null, 0, 0],
    legend: { markers: { width: 0, fill: (u, i) => u.series[i].stroke(u, i) } },
    series: [{ label: 'time', value: (u, t) => (is_number(t) ? `${t.toFixed(2)} s` : '') },
      ...shown.map(curve => ({
        label: curve.name, stroke: curve.color, width: curve.width ?? 1.5, dash: curve.dash, alpha: curve.faint ? 0.3 : 1,
        points: { show: false }, class: curve.faint ? 'faint' : 'curve', spanGaps: false,
        value: (u, y) => (is_number(y) ? `${text_of(y)}${unit ? ` ${unit}` : ''}` : ''),
      }))],
    hooks: {
      drawClear: [u => {
        if (!background) return;
        for (const [from, to, value] of background) {
          const a = Math.max(u.valToPos(from, 'x', true), u.bbox.left);
          const b = Math.min(u.valToPos(to, 'x', true), u.bbox.left + u.bbox.width);
          if (b < a || value === 1) continue;
          u.ctx.save();
          u.ctx.globalAlpha = 0.22;
          u.ctx.fillStyle = colors[value];
          u.ctx.fillRect(a, u.bbox.top, Math.max(b - a, 1), u.bbox.height);
          u.ctx.restore();
        }
      }],
      setSelect: [u => { u.zoomed = true; }],
      draw: [place_line],
    },
  }, data);
  // The double click that shows everything again reaches this handler first.
  plot.over.addEventListener('dblclick', () => { plot.zoomed = false; }, true);
  plot.over.append(line);
  plot.over.addEventListener('click', () => { if (is_number(plot.cursor.left) && plot.cursor.left >= 0) axis.choose(plot.posToVal(plot.cursor.left, 'x')); });
  const on_now = () => place_line(plot);
  axis.listeners.add(on_now);

  const text = shown.filter(curve => !curve.faint).map(curve => `${curve.name}: median ${text_of(median(curve.y))}, largest ${text_of(largest(curve.y))}`);
  place.setAttribute('role', 'img');
  place.setAttribute('aria-label', `${label} over time${unit ? ` in ${unit}` : ''}. ${text.join('; ')}`);
  return () => {
    axis.listeners.delete(on_now);
    plot.take_down();
    place.replaceChildren();
  };
}
