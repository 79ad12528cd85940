/// Two configurations on one data set: their figures side by side, the difference of their errors, repeat by repeat.
import uPlot from 'uplot';
import { card, element, select } from './dom.js';
import { axis_style, plot_in, tick_texts, TimeAxis, time_chart } from './chart.js';
import { dash, is_number, median, percent, signed, text_of } from './figures.js';
import { health_names } from './comparison.js';
import { Lazy } from './lazy.js';
import { css_color } from './theme.js';

const figure = (name, unit, key, less_is_better) => ({ name, unit, value: group => group.figures[key], text: group => text_of(group.figures[key]), less_is_better });
const rows = [
  figure('ATE, median', 'm', 'ate', true),
  figure('ATE, worst', 'm', 'ate_worst', true),
  { name: 'Coverage', value: group => group.figures.coverage, text: group => percent(group.figures.coverage), less_is_better: false },
  { name: 'Aligned', text: group => group.alignment || dash },
  { name: 'Causal', text: group => (group.causal === null ? dash : group.causal ? 'yes' : 'no') },
  figure('RPE over 1 s', 'm', 'rpe', true),
  figure('RPE over 1 s', 'deg', 'rpe_rotation', true),
  figure('Time of a frame, median', 'ms', 'time', true),
  figure('Time of a frame, p99', 'ms', 'time_p99', true),
  figure('Start', 's', 'start', true),
  ...health_names.map((name, i) => ({ name: `Frames ${name}`, value: group => (group.ok.length ? group.health[i] : null), text: group => (group.ok.length ? String(group.health[i]) : dash), is_count: true })),
  { name: 'Resets', value: group => group.figures.resets, text: group => String(group.figures.resets), is_count: true, less_is_better: true },
  { name: 'Failed runs', value: group => group.failed.length, text: group => `${group.failed.length} of ${group.runs.length}`, is_count: true, less_is_better: true },
];

const better_of = (row, x, y) => (row.less_is_better === undefined || x === y ? '' : (y < x) === row.less_is_better ? 'B' : 'A');

export class DifferenceSection {
  constructor(comparison, store) {
    Object.assign(this, { comparison, store, a: null, b: null });
    this.axis = new TimeAxis('difference');
    this.choosers = element('div', { class: 'filters' });
    this.table = element('div', { class: 'difference-table' });
    const make = (title, className, draw) => {
      const chart = card(title, [], className);
      chart.lazy = new Lazy(chart.node, () => draw(chart));
      return chart;
    };
    this.error = make('Difference of the position error, B − A', '', chart => this.draw_error(chart));
    this.pairs = make('Repeat by repeat', '', chart => this.draw_pairs(chart));
    this.node = element('section', { 'aria-labelledby': 'difference' }, element('h2', { id: 'difference' }, 'Difference of two configurations'), this.choosers,
      element('div', { class: 'cards' }, element('div', { class: 'card half' }, this.table), this.pairs.node, this.error.node));
    this.pairs.node.classList.add('half');
    store.subscribe(() => this.update());
    this.update();
  }

  groups() {
    return [this.a, this.b].map(name => this.comparison.group(name, this.store.dataset));
  }
  colors() {
    return [this.store.style_of(this.a)?.color ?? css_color('--stage-1'), this.store.style_of(this.b)?.color ?? css_color('--stage-2')];
  }

  update() {
    const here = this.comparison.configurations.filter(name => this.comparison.group(name, this.store.dataset));
    const preferred = [...this.store.chosen.keys()].filter(name => here.includes(name)).concat(here);
    if (!here.includes(this.a)) this.a = preferred[0] ?? null;
    if (!here.includes(this.b) || (this.b === this.a && here.length > 1)) this.b = preferred.find(name => name !== this.a) ?? this.a;
    const entries = here.map(name => [name, name]), set = name => value => { this[name] = value; this.update(); };
    this.choosers.replaceChildren(select('A', entries, this.a, set('a')), select('B', entries, this.b, set('b')),
      element('button', { type: 'button', onclick: () => { [this.a, this.b] = [this.b, this.a]; this.update(); } }, 'Swap'),
      element('span', { class: 'note' }, `on ${this.store.dataset}`));
    this.update_table();
    this.axis.span = [0, this.comparison.about_dataset.get(this.store.dataset)?.duration_s || 1];
    this.error.lazy.invalidate();
    this.pairs.lazy.invalidate();
  }

  update_table() {
    const [a, b] = this.groups(), [color_a, color_b] = this.colors();
    if (!a || !b) {
      this.table.replaceChildren('No two configurations have runs on this data set.');
      return;
    }
    const verdict = row => {
      const x = row.value?.(a), y = row.value?.(b);
      if (!is_number(x) || !is_number(y)) return ['', ''];
      if (row.is_count) return [`${y > x ? '+' : ''}${y - x}`, better_of(row, x, y)];
      const change = row.name === 'Coverage' ? `${signed(100 * (y - x))} points` : `${signed(y - x)}${x > 0 && row.unit ? ` (${y >= x ? '+' : '−'}${Math.round(100 * Math.abs(y - x) / x)} %)` : ''}`;
      return [change, better_of(row, x, y)];
    };
    const head = (text, color) => element('th', { scope: 'col', class: 'number' }, element('i', { class: 'swatch', style: `--color:${color}` }), text);
    this.table.replaceChildren(element('table', { class: 'pair' },
      element('thead', {}, element('tr', {}, element('td'), head('A', color_a), head('B', color_b), element('th', { scope: 'col', class: 'number' }, 'B − A'), element('th', { scope: 'col' }, 'Better'))),
      element('tbody', {}, rows.map(row => {
        const [change, better] = verdict(row);
        return element('tr', {}, element('th', { scope: 'row' }, row.name, row.unit && element('small', {}, ` ${row.unit}`)), element('td', { class: 'number' }, row.text(a)), element('td', { class: 'number' }, row.text(b)),
          element('td', { class: 'number' }, change), element('td', { class: `better better-${better}` }, better));
      }))));
  }

  /// Runs of both with the same first frame.
  paired() {
    const [a, b] = this.groups();
    if (!a || !b) return [];
    return a.ok.map(run => [run, b.ok.find(other => other.repeat === run.repeat)]).filter(([, other]) => other);
  }

  draw_error(chart) {
    const curves = this.paired().map(([a, b]) => {
      const errors = new Map();
      (a.trajectory?.t ?? []).forEach((t, i) => errors.set(Math.round(1e5 * t), a.trajectory.error[i]));
      const t = [], y = [];
      (b.trajectory?.t ?? []).forEach((each, i) => {
        const before = errors.get(Math.round(1e5 * each)), now = b.trajectory.error[i];
        if (!is_number(before) || !is_number(now)) return;
        t.push(each);
        y.push(now - before);
      });
      return { repeat: a.repeat, t, y };
    }).filter(each => each.t.length);
    if (!curves.length) {
      chart.note.textContent = 'There are no errors of both at the same times.';
      return null;
    }
    const at = new Map();
    for (const curve of curves) curve.t.forEach((t, i) => { if (!at.has(t)) at.set(t, []); at.get(t).push(curve.y[i]); });
    const t = [...at.keys()].sort((x, y) => x - y);
    chart.note.textContent = 'Above zero A is nearer to the truth, below zero B. Thick: median over the repeats, each paired with the one that began at the same frame.';
    return time_chart(chart.place, this.axis, { label: 'Difference of the position error', unit: 'm', curves: [
      ...curves.map(curve => ({ name: `repeat ${curve.repeat}`, t: curve.t, y: curve.y, color: css_color('--muted'), width: 1, faint: true })),
      { name: 'B − A', t, y: t.map(each => median(at.get(each))), color: css_color('--accent'), width: 2 }] });
  }

  draw_pairs(chart) {
    const pairs = this.paired().filter(each => each.every(run => is_number(run.ate?.rmse))), [color_a, color_b] = this.colors(), [group_a, group_b] = this.groups();
    if (!pairs.length) {
      chart.note.textContent = 'There are no repeats of both with an error.';
      return null;
    }
    const better = pairs.filter(([a, b]) => b.ate.rmse < a.ate.rmse).length;
    chart.note.textContent = `B has the smaller ATE in ${better} of ${pairs.length} repeats; it is ${text_of(median(pairs.map(([a, b]) => b.ate.rmse / Math.max(a.ate.rmse, 1e-12))))} times that of A in the median. A: ${group_a.terms}. B: ${group_b.terms}.`;
    const x = pairs.map((_, i) => i), values = k => pairs.map(pair => pair[k].ate.rmse);
    const bars = (k, color) => ({ label: 'AB'[k], stroke: color, fill: color, paths: uPlot.paths.bars({ size: [0.3, 26], align: k === 0 ? -1 : 1, gap: 1 }), points: { show: false }, value: (u, value) => (is_number(value) ? `${text_of(value)} m` : '') });
    const plot = plot_in(chart.place, {
      height: 380,
      cursor: { drag: { x: false, y: false } },
      scales: { x: { time: false, range: [-0.6, pairs.length - 0.4] }, y: { range: (u, low, high) => [0, high * 1.08] } },
      axes: [axis_style({ size: 30, splits: () => x, grid: { show: false }, values: (u, ticks) => ticks.map(i => (pairs[i] ? `${pairs[i][0].repeat}` : '')) }), axis_style({ size: 60, values: tick_texts('m') })],
      series: [{ label: 'repeat', value: (u, i) => (pairs[i] ? String(pairs[i][0].repeat) : '') }, bars(0, color_a), bars(1, color_b)],
    }, [x, values(0), values(1)]);
    chart.place.setAttribute('role', 'img');
    chart.place.setAttribute('aria-label', `ATE repeat by repeat: ${pairs.map(([a, b]) => `${a.repeat}: A ${text_of(a.ate.rmse)} m, B ${text_of(b.ate.rmse)} m`).join('; ')}`);
    return () => { plot.take_down(); chart.place.replaceChildren(); };
  }
}
