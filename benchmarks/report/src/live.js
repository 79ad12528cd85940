/// The page of `plumbline live --page`: the trajectory as it grows, from above and in space.
import { TimeAxis } from './chart.js';
import { card, element } from './dom.js';
import { box_of, view_of } from './space.js';
import { css_color, on_theme, theme_button } from './theme.js';
import { top_view } from './top_view.js';
import { Viewer } from './viewer.js';

const period_ms = 500;

class LivePage {
  constructor({ has_imu }) {
    this.has_imu = has_imu;
    this.path = { t: [], x: [], y: [], z: [] };
    this.part = 0;
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
    let news;
    try {
      const answer = await fetch(`poses?from=${this.path.t.length}&part=${this.part}`);
      news = await answer.json();
    } catch {
      this.state.textContent += ' – the run is over';
      return;
    }
    this.part = news.part;
    for (const name of ['t', 'x', 'y', 'z']) {
      this.path[name].length = news.from;
      this.path[name].push(...news[name]);
    }
    const dropped = news.dropped ? `, ${news.dropped} dropped` : '', reason = news.reason === 'none' ? '' : ` (${news.reason})`;
    this.state.textContent = `${news.health}${reason}; ${news.frames} frames${dropped}; ${news.total_ms.toFixed(1)} ms for the latest one`;
    if (news.t.length) this.draw();
    setTimeout(() => this.update(), period_ms);
  }

  draw() {
    if (this.path.t.length < 2) return;
    const { t, x, y, z } = this.path, view = view_of([this.path], this.has_imu);
    this.axis.span = [t[0], t.at(-1)];
    this.axis.now = t.at(-1);
    const scene = { paths: [{ name: 'estimate', t, x, y, z, color: css_color('--stage-1'), width: 2.5 }], points: [], segments: [] };
    this.take_down?.();
    this.take_down = top_view(this.above.place, this.axis, scene, view, this.height);
    this.viewer ??= new Viewer(this.space.place, this.axis, this.height);
    this.viewer.show(scene, view, this.key(view));
  }

  /// The view begins again where the trajectory has become twice as large.
  key(view) {
    const { low, high } = box_of([this.path]), size = Math.hypot(...high.map((value, k) => value - low[k]));
    return `${view.up} ${Math.ceil(Math.log2(Math.max(size, 1e-3)))}`;
  }
}

const data = JSON.parse(document.getElementById('plumbline-data').textContent);
document.title = data.title;
const page = new LivePage(data);
document.body.append(element('header', {}, element('div', {}, element('h1', {}, element('i', { class: 'bob', 'aria-hidden': 'true' }), data.title), theme_button()), page.state), page.node);
page.update();
