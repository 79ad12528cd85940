/// The page of `plumbline live --page`: trajectory and map as they grow, from above and in space.
import { TimeAxis } from './chart.js';
import { corrected } from './corrected.js';
import { card, element } from './dom.js';
import { quantile } from './figures.js';
import { MapView } from './map_view.js';
import { box_of, view_of } from './space.js';
import { css_color, on_theme, theme_button } from './theme.js';
import { top_view } from './top_view.js';
import { Viewer } from './viewer.js';

const period_ms = 500;

class LivePage {
  constructor({ has_imu }) {
    this.has_imu = has_imu;
    this.path = { t: [], x: [], y: [], z: [], world: [] };
    this.part = this.version = 0;
    this.axis = new TimeAxis('live');
    this.state = element('p', { class: 'note', id: 'state', role: 'status' }, 'no pose yet');
    this.space = card('In space', []);
    this.above = card('From above', []);
    this.height = Math.max(260, Math.round(0.6 * window.innerHeight));
    this.node = element('main', { class: 'cards' }, this.space.node, this.above.node);
    on_theme(() => this.draw());
  }

  /// What has come since the last time; all of it where the program has left out every second pose.
  async update() {
    let news, map_news = {};
    try {
      news = await (await fetch(`poses?from=${this.path.t.length}&part=${this.part}`)).json();
      if (news.has_map) map_news = await (await fetch(`map?version=${this.version}`)).json();
    } catch {
      this.state.textContent += ' – the run is over';
      return;
    }
    this.part = news.part;
    for (const name of ['t', 'x', 'y', 'z', 'world']) {
      this.path[name].length = news.from;
      this.path[name].push(...news[name] ?? []);
    }
    const dropped = news.dropped ? `, ${news.dropped} dropped` : '', reason = news.reason === 'none' ? '' : ` (${news.reason})`;
    this.state.textContent = `${news.health}${reason}; ${news.frames} frames${dropped}; ${news.total_ms.toFixed(1)} ms for the latest one`;
    if (map_news.map) {
      this.version = map_news.version;
      this.newest_map = map_news.map;
    }
    if (news.t.length || map_news.map) {
      if (this.newest_map) this.show_map(this.newest_map);
      this.draw();
    }
    setTimeout(() => this.update(), news.is_all ? period_ms : 0);
  }

  /// The poses are those of the estimates, and as the map has them now.
  show_map({ corrections, relocalizations, ...map }) {
    const { t, x, y, z } = this.path;
    const all = { ...map, covisible: [], causal: { t, x, y, z }, corrected: corrected(this.path, corrections), relocalizations: corrected(relocalizations, corrections) };
    if (this.map) this.map.set(all);
    else this.map = new MapView(all, () => this.draw(), ['causal']);
    if (this.controls !== this.map.controls) {
      this.controls = this.map.controls;
      this.space.bar.replaceChildren(...this.controls);
    }
    const figures = this.map.figures();
    if (this.figures) this.figures.replaceWith(figures);
    else this.node.append(figures);
    this.figures = figures;
  }

  way() {
    return this.map ? [this.map.map.corrected, this.map.map.keyframes] : [this.path];
  }
  /// What is to be in view: the way, and where most of the points are.
  frame() {
    if (!this.map?.draws('points')) return this.way();
    const [x, y, z] = [0, 1, 2].map(k => { const values = this.map.map.points.map(p => p[k]); return [quantile(values, 0.05), quantile(values, 0.95)]; });
    return [...this.way(), { x, y, z }];
  }
  scene() {
    if (this.map) return { ...this.map.scene(), frame: this.frame() };
    const { t, x, y, z } = this.path;
    return { paths: [{ name: 'estimate', t, x, y, z, color: css_color('--stage-1'), width: 2.5 }], points: [], segments: [] };
  }
  draw() {
    const { t } = this.path;
    if (!this.way().some(path => path.t.length >= 2)) return;
    const scene = this.scene(), view = view_of(this.way(), this.has_imu);
    if (t.length) {
      this.axis.span = [t[0], t.at(-1)];
      this.axis.now = t.at(-1);
    }
    this.take_down?.();
    this.take_down = top_view(this.above.place, this.axis, scene, view, this.height);
    this.viewer ??= new Viewer(this.space.place, this.axis, this.height);
    this.viewer.show(scene, view, this.key(scene.frame ?? scene.paths, view));
  }

  /// The view begins again where what is in view has become twice as large.
  key(frame, view) {
    const { low, high } = box_of(frame), size = Math.hypot(...high.map((value, k) => value - low[k]));
    return `${view.up} ${Math.ceil(Math.log2(Math.max(size, 1e-3)))}`;
  }
}

const data = JSON.parse(document.getElementById('plumbline-data').textContent);
document.title = data.title;
const page = new LivePage(data);
document.body.append(element('header', {}, element('div', {}, element('h1', {}, element('i', { class: 'bob', 'aria-hidden': 'true' }), data.title), theme_button()), page.state), page.node);
page.update();
