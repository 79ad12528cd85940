/// Medians as bars, each repeat as a dot, the spread as a line; the name and the terms of the figure above each bar.
import uPlot from 'uplot';
import { axis_style, font, plot_in, tick_texts } from './chart.js';
import { css_color } from './theme.js';
import { is_number, largest, smallest, text_of, with_unit } from './figures.js';

const row_height = 52;

/// `rows`: {name, terms, color, values (one for each repeat), median, failure}.
export function bar_chart(place, { label, unit, rows }) {
  if (rows.length === 0) {
    place.textContent = 'Nothing to draw here.';
    return () => place.replaceChildren();
  }
  const values = rows.flatMap(row => row.values).filter(value => is_number(value) && value > 0);
  const low = smallest(values) ?? 0.1, high = largest(values) ?? 1, log = high > 30 * low;
  const at = rows.map((_, i) => i + 0.3);
  const value_range = log ? uPlot.rangeLog(0.7 * low, 1.2 * high, 10, false) : [0, 1.06 * high];

  const draw = u => {
    const { ctx, bbox } = u, ratio = devicePixelRatio;
    ctx.save();
    ctx.textAlign = 'left';
    rows.forEach((row, i) => {
      const y = u.valToPos(at[i], 'x', true), x = value => u.valToPos(value, 'y', true);
      const known = row.values.filter(value => is_number(value) && value > 0);
      if (known.length) {
        ctx.strokeStyle = ctx.fillStyle = css_color('--ink');
        ctx.lineWidth = 1.5 * ratio;
        ctx.beginPath();
        ctx.moveTo(x(smallest(known)), y);
        ctx.lineTo(x(largest(known)), y);
        ctx.stroke();
        for (const value of known) {
          ctx.beginPath();
          ctx.arc(x(value), y, 3 * ratio, 0, 2 * Math.PI);
          ctx.fillStyle = css_color('--card');
          ctx.fill();
          ctx.stroke();
        }
      }
      ctx.textBaseline = 'alphabetic';
      ctx.font = `600 ${font(11.5 * ratio)}`;
      ctx.fillStyle = css_color('--ink');
      const top = y - 26 * ratio;
      ctx.fillText(row.name, bbox.left, top);
      ctx.font = font(11 * ratio);
      ctx.fillStyle = css_color('--muted');
      let left = bbox.left;
      for (const [text, color] of [[is_number(row.median) ? `${with_unit(row.median, unit)}${row.terms ? `, ${row.terms}` : ''}   ` : '', '--muted'], [row.failure, '--lost-text']]) {
        ctx.fillStyle = css_color(color);
        ctx.fillText(text, left, top + 13.5 * ratio);
        left += ctx.measureText(text).width;
      }
    });
    ctx.restore();
  };
  const plot = plot_in(place, {
    height: rows.length * row_height + 34,
    padding: [0, 16, 0, 10],
    cursor: { show: false },
    legend: { show: false },
    scales: { x: { time: false, ori: 1, dir: -1, range: [-0.5, rows.length - 0.5] }, y: { ori: 0, dir: 1, distr: log ? 3 : 1, range: value_range } },
    axes: [{ show: false, side: 3 }, axis_style({ side: 2, size: 32, space: 64, values: tick_texts(unit) })],
    series: [{}, {
      points: { show: false },
      paths: uPlot.paths.bars({ size: [0.3, 13], radius: 0.25, disp: { fill: { unit: 3, values: () => rows.map(row => row.color) }, stroke: { unit: 3, values: () => rows.map(row => row.color) } } }),
      fill: '#888', stroke: '#888', fillTo: () => value_range[0],
    }],
    hooks: { draw: [draw] },
  }, [at, rows.map(row => (is_number(row.median) && (row.median > 0 || !log) ? row.median : null))]);
  place.setAttribute('role', 'img');
  place.setAttribute('aria-label', `${label}, ${unit}. ${rows.map(row =>
    `${row.name}: median ${text_of(row.median)}${row.terms ? `, ${row.terms}` : ''}, from ${text_of(smallest(row.values))} to ${text_of(largest(row.values))}${row.failure ? `, ${row.failure}` : ''}`).join('; ')}`);
  return () => {
    plot.take_down();
    place.replaceChildren();
  };
}
