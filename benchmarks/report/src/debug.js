/// The page of `plumbline run --debug`: pictures of the frames beside curves of everything over time; or of a saved map.
import { card, checkbox, element } from './dom.js';
import { spans_of, TimeAxis, time_chart } from './chart.js';
import { health_chart, health_legend } from './health_chart.js';
import { Lazy } from './lazy.js';
import { map_page } from './map_page.js';
import { MapView } from './map_view.js';
import { stage_curves } from './dataset_section.js';
import { top_view } from './top_view.js';
import { Viewer } from './viewer.js';
import { view_of } from './space.js';
import { css_color, on_theme, theme_button } from './theme.js';

const states = [['located', '--tracking'], ['unlocated', '--stage-1'], ['rejected', '--lost'], ['lost', '--degraded']];

class DebugPage {
  constructor(data) {
    this.data = data;
    this.axis = new TimeAxis('run');
    this.axis.span = [data.t[0] ?? 0, Math.max(data.t.at(-1) ?? 1, (data.t[0] ?? 0) + 1e-3)];
    this.background = spans_of(data.t, data.health);
    this.charts = [];
    this.map = data.map && new MapView(data.map, () => this.redraw_space());
    this.node = element('main', { class: 'debug' }, element('div', { class: 'look' }, this.pictures(), this.space()), element('div', { class: 'cards' }, this.curves()));
    on_theme(() => this.charts.forEach(chart => chart.lazy.invalidate()));
  }

  make(title, draw, controls = []) {
    const chart = card(title, controls);
    chart.lazy = new Lazy(chart.node, () => draw(chart));
    this.charts.push(chart);
    return chart.node;
  }

  /// The picture of a frame; a click into a chart, the slider or an arrow key goes to another.
  pictures() {
    const { pictures, t } = this.data;
    if (!pictures.length) return element('p', { class: 'note' }, 'This run has no pictures.');
    const image = element('img', { alt: '', id: 'frame' });
    const slider = element('input', { type: 'range', min: 0, max: pictures.length - 1, value: 0, id: 'slider', 'aria-label': 'Frame' });
    const label = element('output', { class: 'note' });
    const show = k => {
      const { row, file } = pictures[k];
      slider.value = k;
      image.src = file;
      image.alt = `Frame ${this.data.columns.frame?.[row] ?? row} with its features`;
      label.textContent = `frame ${this.data.columns.frame?.[row] ?? row}, ${t[row].toFixed(2)} s`;
      slider.setAttribute('aria-valuetext', label.textContent);
      this.axis.now = t[row];
      for (const listener of this.axis.listeners) if (listener !== nearest) listener(t[row]);
    };
    const nearest = time => show(pictures.reduce((best, { row }, k) => (Math.abs(t[row] - time) < Math.abs(t[pictures[best].row] - time) ? k : best), 0));
    this.axis.listeners.add(nearest);
    slider.addEventListener('input', () => show(Number(slider.value)));
    document.addEventListener('keydown', event => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step || event.target.closest?.('select, input:not(#slider), canvas')) return;
      event.preventDefault();
      show(Math.min(Math.max(Number(slider.value) + step, 0), pictures.length - 1));
    });
    show(0);
    return element('div', { class: 'card' }, image, slider, label);
  }

  scene() {
    if (this.map) return this.map.scene();
    const { trajectory, truth } = this.data, paths = [];
    if (trajectory?.t.length) paths.push({ name: 'estimate', ...trajectory, color: css_color('--stage-1'), width: 2.5 });
    if (truth?.t.length && this.with_truth) paths.push({ name: 'truth', ...truth, color: css_color('--ink'), width: 1.2, on_top: true });
    return { paths, points: [], segments: [] };
  }
  redraw_space() {
    this.charts.forEach(chart => chart.is_space && chart.lazy.invalidate());
  }
  space() {
    if (!this.data.trajectory?.t.length) return element('p', { class: 'note' }, 'This run has no trajectory.');
    this.with_truth = true;
    const view = view_of([this.map ? this.data.map.causal : this.data.trajectory], this.data.has_imu), height = Math.max(220, Math.min(320, Math.round(0.32 * window.innerHeight)));
    const has_truth = Boolean(this.data.truth?.t.length);
    const controls = this.map ? this.map.controls : has_truth ? [checkbox('truth', true, value => { this.with_truth = value; this.redraw_space(); })] : [];
    this.above = this.make('From above', chart => top_view(chart.place, this.axis, this.scene(), view, height));
    const space = this.make('In space', chart => { this.viewer ??= new Viewer(chart.place, this.axis, height); this.viewer.show(this.scene(), view, 'run'); }, controls);
    this.charts.forEach(chart => { chart.is_space = true; });
    return space;
  }

  curves() {
    const { data } = this, { columns, t } = data;
    const curve = (name, column, color, rest = {}) => ({ name, t, y: columns[column] ?? [], color: css_color(color), ...rest });
    const plot = (title, unit, get) => this.make(unit ? `${title} [${unit}]` : title, chart =>
      time_chart(chart.place, this.axis, { label: title, unit, curves: get(), clip: true, height: 170, background: this.background }));
    const axes = name => () => ['x', 'y', 'z'].map((axis, i) => curve(axis, `${name}_${axis}`, `--stage-${i + 1}`));
    const error = (name, column) => (data.errors ? [{ name, t: data.errors.t, y: data.errors[column], color: css_color('--lost'), width: 2 }] : []);

    const nodes = [this.make('Health', chart => health_chart(chart.place, this.axis, [{ name: '', t, health: data.health }]), [health_legend()])];
    if (data.errors) nodes.push(plot('Position error', 'm', () => [...error('error', 'position_m'), curve('sigma', 'sigma_position_m', '--muted')]));
    for (const kind of data.kinds) nodes.push(plot(kind[0].toUpperCase() + kind.slice(1), '', () => states.map(([state, color]) => curve(state, `${kind}_${state}`, color))));
    for (const kind of data.kinds) {
      const of = unit => () => [curve('90 %', `${kind}_innovation_p90_${unit}`, '--muted'), curve('median', `${kind}_innovation_median_${unit}`, '--stage-1')];
      nodes.push(plot(`Innovation of ${kind}, expected 1.18 and 2.15`, 'sigma', of('sigma')), plot(`Innovation of ${kind}`, 'px', of('px')));
    }
    if (!data.errors) nodes.push(plot('Position', 'm', () => [curve('sigma', 'sigma_position_m', '--muted')]));
    nodes.push(plot(data.errors ? 'Rotation error' : 'Rotation', 'deg', () => [...error('error', 'rotation_deg'), curve('sigma', 'sigma_rotation_deg', '--muted')]));
    if (data.errors) nodes.push(plot('NEES, aligned at the first pose; expected 6', '', () => {
      const { t: at, nees_pose } = data.errors, bound = (name, value, faint) => ({ name, t: at, y: at.map(() => value), color: css_color('--muted'), dash: [4, 4], width: 1, faint });
      return [bound('95 % of consistent ones', 1.24, false), bound('', 14.45, true), { name: 'pose', t: at, y: nees_pose, color: css_color('--stage-1') }];
    }));
    if (data.has_imu)
      nodes.push(plot('Velocity', 'm/s', axes('velocity')), plot('Gyroscope bias', 'rad/s', axes('bias_gyro')), plot('Its sigma', 'rad/s', axes('sigma_bias_gyro')),
        plot('Accelerometer bias', 'm/s²', axes('bias_accel')), plot('Its sigma', 'm/s²', axes('sigma_bias_accel')), plot('Fraction of the time without valid IMU samples', '', () => [curve('missing', 'imu_missing', '--lost')]));
    nodes.push(plot('Time of a frame', 'ms', () => stage_curves({ t, ...columns })));
    if (this.map) nodes.unshift(this.map.figures());
    if (this.map) nodes.push(plot('Time of the map\'s stages', 'ms', () => [['learn', '--stage-1'], ['query', '--stage-2'], ['verify', '--stage-3'], ['solve', '--lost']].map(([stage, color]) => curve(stage, `map_${stage}_ms`, color))));
    return [...nodes, this.above ?? []];
  }
}

function main() {
  const data = JSON.parse(document.getElementById('plumbline-data').textContent);
  const is_map = data?.format === 'plumbline-map' && data.map.keyframes.x.length > 0;
  if (!data || !(data.t.length || is_map)) {
    document.body.append(element('p', { class: 'empty' }, data?.format === 'plumbline-map' ? 'There are no keyframes in this map.' : 'There are no frames in this run.'));
    return;
  }
  document.title = data.title;
  document.body.append(element('header', {}, element('div', {}, element('h1', {}, element('i', { class: 'bob', 'aria-hidden': 'true' }), data.title), theme_button()),
    element('pre', { class: 'lead' }, data.summary), !is_map && element('p', { class: 'note' }, 'Click a chart, or use the arrow keys, to go to a frame; drag to zoom, double click for all.')));
  document.body.append(is_map ? map_page(data) : new DebugPage(data).node);
}

main();
