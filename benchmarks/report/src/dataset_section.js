/// One data set: trajectories, errors, times, features and health of the chosen configurations, and their spread.
import { card, checkbox, choice, element, name_of, select } from './dom.js';
import { TimeAxis, time_chart } from './chart.js';
import { health_chart, health_legend } from './health_chart.js';
import { bar_chart } from './bar_chart.js';
import { top_view } from './top_view.js';
import { Viewer } from './viewer.js';
import { view_of } from './space.js';
import { Lazy } from './lazy.js';
import { css_color } from './theme.js';
import { time_of } from './comparison.js';
import { is_number, largest, median, text_of } from './figures.js';

const stage_names = ['total', 'track', 'estimate', 'map'];
const stage_key = stage => `${stage}_ms`;

export class DatasetSection {
  constructor(comparison, store) {
    Object.assign(this, { comparison, store });
    this.axis = new TimeAxis('recording');
    this.options = { repeats: true, truth: true, points: true, lines: true, map_of: '', log: null, time: 'total', kind: 'points', all: false, search: '' };
    this.title = element('h2', { id: 'dataset' });
    this.tabs = element('div', { class: 'tabs', role: 'group', 'aria-label': 'Data set' });
    this.facts = element('p', { class: 'note' });
    this.failures = element('div', { class: 'failures' });
    this.list = element('div', { class: 'list' });
    this.chooser = this.make_chooser();
    this.charts = this.make_charts();
    this.node = element('section', { 'aria-labelledby': 'dataset' }, this.title, this.tabs, this.facts, this.failures,
      element('div', { class: 'with-chooser' }, this.chooser, element('div', { class: 'cards' }, this.charts.map(chart => chart.node))));
    store.subscribe(() => this.update());
    this.update();
  }

  // ---- what is shown

  /// Of the chosen configurations, those that have runs here: {name, group, style}.
  shown() {
    return [...this.store.chosen.keys()].map(name => ({ name, group: this.comparison.group(name, this.store.dataset), style: this.store.style_of(name) }))
      .filter(each => each.group?.typical);
  }
  /// Runs to draw of one configuration: faint ones first, the typical one last.
  runs_of(group) {
    return this.options.repeats ? [...group.ok.filter(run => run !== group.typical), group.typical] : [group.typical];
  }
  curves(get) {
    return this.shown().flatMap(({ name, group, style }) => this.runs_of(group).map(run => {
      const faint = run !== group.typical, { t, y } = get(run);
      return { name, t: t ?? [], y: y ?? [], color: style.color, dash: style.dash, width: faint ? 1 : 2, faint };
    }));
  }

  update() {
    const { dataset } = this.store, about = this.comparison.about_dataset.get(dataset) ?? {};
    this.title.textContent = `On ${dataset}`;
    this.tabs.replaceChildren(...this.comparison.datasets.map(name => element('button', { type: 'button', 'aria-pressed': String(name === dataset), onclick: () => this.store.open(name) }, name)));
    if (dataset !== this.dataset) {
      this.dataset = dataset;
      this.axis.now = null;
      this.options.map_of = '';
    }
    this.axis.span = [0, about.duration_s || largest(this.comparison.runs.filter(run => run.dataset === dataset).map(run => run.frame_series?.t?.at(-1))) || 1];
    const facts = [is_number(about.frames) && `${about.frames} frames`, is_number(about.duration_s) && `${text_of(about.duration_s)} s`, is_number(about.rate_hz) && `${text_of(about.rate_hz, 2)} Hz`,
      about.width && `${about.width} x ${about.height}`, about.has_depth && 'depth', about.has_imu && 'IMU', this.comparison.truth(dataset) ? 'with truth' : 'no truth: no errors'];
    this.facts.textContent = facts.filter(Boolean).join(', ');
    this.update_failures();
    this.update_chooser();
    for (const chart of this.charts) chart.lazy.invalidate();
  }

  update_failures() {
    const failed = this.comparison.groups.filter(group => group.dataset === this.store.dataset && group.failed.length);
    const count = failed.reduce((sum, group) => sum + group.failed.length, 0);
    this.failures.replaceChildren(...(count === 0 ? [] : [element('details', { open: failed.length <= 6 },
      element('summary', {}, `${count} run${count > 1 ? 's' : ''} failed on this data set`),
      element('ul', {}, failed.flatMap(group => group.reasons.map(([reason, times]) =>
        element('li', {}, element('b', {}, group.configuration), ` ${times} of ${group.runs.length}: ${reason}`)))))]));
  }

  // ---- the list of configurations

  make_chooser() {
    const search = element('input', { type: 'search', placeholder: 'words of a name', 'aria-label': 'Filter configurations', oninput: event => { this.options.search = event.target.value; this.update_chooser(); } });
    this.chosen_count = element('span');
    return element('details', { class: 'chooser', open: window.innerWidth > 900 }, element('summary', {}, 'Configurations ', this.chosen_count),
      this.comparison.configurations.length > 8 && search, this.list,
      element('button', { type: 'button', onclick: () => { for (const name of [...this.store.chosen.keys()]) this.store.choose(name, false); } }, 'Choose none'));
  }

  update_chooser() {
    this.chosen_count.textContent = `(${this.store.chosen.size} of ${this.comparison.configurations.length} drawn)`;
    const words = this.options.search.toLowerCase().split(/\s+/).filter(Boolean), focused = document.activeElement?.dataset?.configuration;
    this.list.replaceChildren(...this.comparison.configurations.filter(name => words.every(word => name.includes(word))).map(name => {
      const group = this.comparison.group(name, this.store.dataset), style = this.store.style_of(name);
      const state = !group ? 'no run' : !group.ok.length ? 'failed' : group.failed.length ? `${group.failed.length} of ${group.runs.length} failed` : '';
      return element('label', { class: 'check' }, element('input', { type: 'checkbox', checked: style !== null, 'data-configuration': name, onchange: event => this.store.choose(name, event.target.checked) }),
        element('i', { class: 'swatch', style: `--color:${style?.color ?? 'transparent'}`, 'data-dashed': String((style?.dash.length ?? 0) > 0) }), element('span', {}, name_of(name), state && element('small', { class: 'failure' }, ` ${state}`)));
    }));
    if (focused) this.list.querySelector(`[data-configuration="${CSS.escape(focused)}"]`)?.focus();
  }

  // ---- charts

  make_charts() {
    const redraw = (chart, name) => value => { this.options[name] = value; chart.lazy.invalidate(); };
    const make = (title, className, draw) => {
      const chart = card(title, [], className);
      chart.lazy = new Lazy(chart.node, () => draw(chart));
      return chart;
    };
    const space = make('In space', 'half', chart => this.draw_space(chart));
    const above = make('From above', 'half', chart => this.draw_above(chart));
    this.map_choice = element('span');
    const both = name => value => { this.options[name] = value; space.lazy.invalidate(); above.lazy.invalidate(); };
    space.bar.append(checkbox('truth', true, both('truth')), checkbox('points', true, both('points')), checkbox('lines', true, both('lines')), this.map_choice);
    this.redraw_space = both('map_of');

    const error = make('Position error', '', chart => this.draw_error(chart));
    error.bar.append(checkbox('logarithmic', false, redraw(error, 'log')), checkbox('all repeats', true, value => {
      this.options.repeats = value;
      for (const chart of this.charts) chart.lazy.invalidate();
    }));
    const time = make('Time of a frame', '', chart => this.draw_time(chart));
    const features = make('Features tracked', '', chart => this.draw_features(chart));
    const health = make('Health', '', chart => this.draw_health(chart));
    health.bar.append(health_legend());
    const ate = make('Error over the repeats', 'half', chart => this.draw_bars(chart, { label: 'ATE', unit: 'm', get: run => run.ate?.rmse, key: 'ate', with_terms: true }));
    const ms = make('Time over the repeats', 'half', chart => this.draw_bars(chart, { label: 'Time of a frame', unit: 'ms', get: time_of, key: 'time' }));
    ate.bar.append(checkbox('all configurations', false, value => { this.options.all = value; ate.lazy.invalidate(); ms.lazy.invalidate(); }));
    return [space, above, error, time, features, health, ate, ms];
  }

  scene() {
    const truth = this.comparison.truth(this.store.dataset), shown = this.shown(), { options } = this;
    const paths = shown.filter(({ group }) => group.typical.trajectory?.t?.length)
      .map(({ name, group, style }) => ({ name, ...group.typical.trajectory, ...style, width: 2.5 }));
    if (truth && options.truth) paths.push({ name: 'truth', ...truth, color: css_color('--ink'), dash: [], width: 1.2, on_top: true });
    const maps = shown.map(({ name, group, style }) => ({ name, style, map: group.ok.find(run => run.map)?.map })).filter(each => each.map);
    const from = options.map_of === 'all' ? maps : options.map_of ? maps.filter(each => each.name === options.map_of) : maps.slice(0, 1);
    return {
      maps, paths, frame: truth ? [truth] : paths,
      points: options.points ? from.filter(each => each.map.points?.length).map(each => ({ positions: each.map.points, color: each.style.color })) : [],
      segments: options.lines ? from.filter(each => each.map.segments?.length).map(each => ({ ends: each.map.segments, color: each.style.color })) : [],
    };
  }
  view(scene) {
    return view_of(scene.frame, this.comparison.about_dataset.get(this.store.dataset)?.has_imu);
  }

  draw_space(chart) {
    const scene = this.scene();
    this.map_choice.replaceChildren(scene.maps.length > 1 ? select('map of', [['', scene.maps[0].name], ...scene.maps.slice(1).map(({ name }) => [name, name]), ['all', 'all']], this.options.map_of, value => this.redraw_space(value)) : '');
    this.viewer ??= new Viewer(chart.place, this.axis, window.innerWidth < 700 ? 300 : 420);
    const view = this.view(scene);
    this.viewer.show(scene, view, JSON.stringify([this.store.dataset, view]));
  }
  draw_above(chart) {
    const scene = this.scene();
    chart.note.textContent = scene.paths.length ? 'Typical runs: those of median error. A ball is the start, or the time chosen in a chart.' : '';
    return top_view(chart.place, this.axis, scene, this.view(scene), window.innerWidth < 700 ? 300 : 468);
  }
  draw_error(chart) {
    const truth = this.comparison.truth(this.store.dataset);
    chart.note.textContent = truth ? 'After alignment. Thin lines are the other repeats. Drag to zoom, double click for all, click to choose a time.' : 'This recording has no truth, so there are no errors.';
    if (!truth) return null;
    return time_chart(chart.place, this.axis, { label: 'Position error', unit: 'm', log: this.options.log ?? false, curves: this.curves(run => ({ t: run.trajectory?.t, y: run.trajectory?.error })) });
  }
  draw_time(chart) {
    const shown = this.shown(), { options } = this, one = shown.find(each => `of ${each.name}` === options.time);
    if (!stage_names.includes(options.time) && !one) options.time = 'total';
    const redraw = value => { options.time = value; chart.lazy.invalidate(); };
    chart.bar.replaceChildren(choice('Stage', stage_names.map(stage => [stage, stage]), options.time, redraw),
      select('stages of', [['', '…'], ...shown.map(({ name }) => [`of ${name}`, name])], one ? options.time : '', value => redraw(value || 'total')));
    const curves = one ? stage_curves(one.group.typical.frame_series) : this.curves(run => ({ t: run.frame_series?.t, y: run.frame_series?.[stage_key(options.time)] }));
    const averages = shown.map(({ name, group }) => `${name} ${text_of(median(group.typical.frame_series?.[stage_key(one ? 'total' : options.time)] ?? []))} ms`);
    chart.note.textContent = one ? `Stages of ${one.name}, its typical run.` : averages.length ? `Median: ${averages.join(', ')}` : '';
    return time_chart(chart.place, this.axis, { label: 'Time of a frame', unit: 'ms', clip: true, curves });
  }
  draw_features(chart) {
    const { options } = this, redraw = value => { options.kind = value; chart.lazy.invalidate(); };
    const has_lines = this.shown().some(({ group }) => group.typical.frame_series?.lines?.length);
    const kind = has_lines ? options.kind : 'points';
    chart.bar.replaceChildren(has_lines ? choice('Kind', [['points', 'points'], ['lines', 'lines']], kind, redraw) : '');
    return time_chart(chart.place, this.axis, { label: `Features tracked: ${kind}`, unit: '', curves: this.curves(run => ({ t: run.frame_series?.[kind]?.length ? run.frame_series.t : [], y: run.frame_series?.[kind] })) });
  }
  draw_health(chart) {
    const lanes = this.shown().map(({ name, group }) => ({ name, t: group.typical.frame_series?.t ?? [], health: group.typical.frame_series?.health ?? [] }));
    return health_chart(chart.place, this.axis, lanes.filter(lane => lane.t.length));
  }
  draw_bars(chart, { label, unit, get, key, with_terms }) {
    const names = this.options.all ? this.comparison.configurations : [...this.store.chosen.keys()];
    const rows = names.map(name => ({ name, group: this.comparison.group(name, this.store.dataset) })).filter(({ group }) => group).map(({ name, group }) => ({
      name, terms: with_terms ? group.terms : '', color: this.store.style_of(name)?.color ?? css_color('--muted'), values: group.ok.map(get).filter(is_number), median: group.figures[key],
      failure: group.failed.length ? `${group.failed.length} of ${group.runs.length} failed${group.ok.length ? '' : `: ${group.reasons[0][0]}`}` : '',
    }));
    const rank = row => (is_number(row.median) ? row.median : Number.MAX_VALUE);
    rows.sort((a, b) => rank(a) - rank(b) || a.name.localeCompare(b.name));
    chart.note.textContent = rows.length ? 'Bar: median. Dots: repeats, each begun one frame later.' : '';
    return bar_chart(chart.place, { label, unit, rows });
  }
}

/// Time of each stage and of the whole, of one run.
export function stage_curves(series) {
  const colors = { total: css_color('--muted'), track: css_color('--stage-1'), estimate: css_color('--stage-2'), map: css_color('--stage-3') };
  return stage_names.map(stage => ({ name: stage, t: series.t, y: series[stage_key(stage)] ?? [], color: colors[stage], width: stage === 'total' ? 1 : 1.5 }));
}
