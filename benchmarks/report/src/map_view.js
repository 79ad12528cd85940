/// A map of keyframes: what is drawn of it, and what it has done.
import { card, checkbox, element } from './dom.js';
import { is_number, text_of } from './figures.js';
import { css_color } from './theme.js';

const counts = {
  keyframes: 'Keyframes', evicted: 'Keyframes evicted', worlds: 'Worlds', features: 'Features', points: 'Features with a position', queries: 'Queries', verified: 'Places verified',
  rejected_by_gate: 'Refused by the odometry', rejected_by_tilt: 'Refused by gravity', rejected_as_ambiguous: 'Refused as ambiguous',
  loops: 'Loops', corrections: 'Corrections', relocalizations: 'Relocalizations',
  frames_asked: 'Single frames sought', frames_found: 'Single frames found',
};
const trajectories = ['truth', 'odometry', 'causal', 'corrected', 'final'];

/// What can be drawn: name, color, and whether it is drawn at first.
const all_layers = [
  ['truth', '--ink', true], ['odometry', '--muted', true], ['causal', '--stage-1', true], ['corrected', '--stage-2', true], ['final', '--stage-2', true],
  ['keyframes', '--accent', true], ['loops', '--lost', true], ['relocalizations', '--stage-3', true], ['points', '--initializing', true], ['lines', '--degraded', true], ['covisibility', '--tracking', false],
];

export class MapView {
  /// `map` as in the data of the page; `redraw` when a reader has chosen other layers; `hidden`: layers not drawn at first.
  constructor(map, redraw, hidden = []) {
    this.redraw = redraw;
    this.shown = Object.fromEntries(all_layers.map(([name, , shown]) => [name, shown && !hidden.includes(name)]));
    this.layers = [];
    this.set(map);
  }

  /// Another map, with the layers that a reader has chosen; `controls` are new ones where there are other layers.
  set(map) {
    this.map = map;
    const there = { keyframes: map.keyframes.x.length, loops: map.loops.length, points: map.points.length, lines: map.lines?.length, covisibility: map.covisible.length };
    for (const name of [...trajectories, 'relocalizations']) there[name] = map[name]?.t.length ?? 0;
    const layers = all_layers.filter(([name]) => there[name]);
    if (this.controls && layers.join() === this.layers.join()) return;
    this.layers = layers;
    this.controls = layers.map(([name, color]) =>
      checkbox([element('i', { class: 'dot', style: `--color:var(${color})` }), name], this.shown[name], value => { this.shown[name] = value; this.redraw(); }));
  }
  draws(layer) {
    return this.shown[layer] && this.layers.some(([name]) => name === layer);
  }

  color(layer) {
    return css_color(this.layers.find(([name]) => name === layer)[1]);
  }
  keyframe(i) {
    const { x, y, z } = this.map.keyframes;
    return [x[i], y[i], z[i]];
  }
  edges(pairs) {
    return pairs.map(([i, j]) => [...this.keyframe(i), ...this.keyframe(j)]);
  }

  /// Keyframes in the order they were learned in, a path for each world.
  keyframe_paths() {
    const { x, y, z, world } = this.map.keyframes;
    return [...new Set(world)].map(each => {
      const t = world.map((_, i) => i).filter(i => world[i] === each);
      return { name: 'keyframes', t, x: t.map(i => x[i]), y: t.map(i => y[i]), z: t.map(i => z[i]), color: this.color('keyframes'), width: 1.5 };
    });
  }

  /// As of viewer.js.
  scene() {
    const { map } = this, paths = [], points = [], segments = [];
    const widths = { truth: 1.2, odometry: 1.5, causal: 1.5, corrected: 2.5, final: 2.5 };
    for (const name of ['odometry', 'causal', 'corrected', 'final', 'truth'])
      if (this.draws(name)) paths.push({ name, ...map[name], color: this.color(name), width: widths[name], dash: name === 'odometry' ? [6, 4] : [], on_top: name === 'truth' });
    if (!trajectories.some(name => map[name]) && this.draws('keyframes')) paths.push(...this.keyframe_paths());
    if (this.draws('points')) points.push({ positions: map.points, color: this.color('points'), opacity: 0.55 });
    if (this.draws('keyframes')) points.push({ positions: map.keyframes.x.map((_, i) => this.keyframe(i)), color: this.color('keyframes'), size: 5, opacity: 1 });
    if (this.draws('relocalizations')) points.push({ positions: map.relocalizations.x.map((x, i) => [x, map.relocalizations.y[i], map.relocalizations.z[i]]), color: this.color('relocalizations'), size: 11, opacity: 1 });
    if (this.draws('lines')) segments.push({ ends: map.lines, color: this.color('lines'), opacity: 0.8 });
    if (this.draws('covisibility')) segments.push({ ends: this.edges(map.covisible), color: this.color('covisibility'), opacity: 0.5 });
    if (this.draws('loops')) segments.push({ ends: this.edges(map.loops), color: this.color('loops'), opacity: 1, width: 1.5 });
    return { paths, points, segments, frame: [...trajectories.filter(name => map[name]?.t.length).map(name => map[name]), map.keyframes] };
  }

  /// Counts, and errors of the trajectories where there is a truth.
  figures(className = '') {
    const { map } = this, chart = card('Map', [], className);
    const rows = Object.entries(counts).filter(([name]) => is_number(map.counts[name])).map(([name, text]) => [text, `${map.counts[name]}`]);
    if (map.ate_m) for (const name of ['odometry', 'causal', 'final']) if (is_number(map.ate_m[name])) rows.push([`ATE, ${name}`, `${text_of(map.ate_m[name])} m`]);
    if (map.extent) rows.push(['Path of the keyframes', text_of(map.path)], ['Extent of the points', map.extent.map(value => text_of(value)).join(' x ')]);
    chart.place.append(element('table', { class: 'pair counts' }, element('tbody', {}, rows.map(([name, value]) =>
      element('tr', {}, element('th', { scope: 'row' }, name), element('td', { class: 'number' }, value))))));
    return chart.node;
  }
}
