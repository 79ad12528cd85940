/// The page of a saved map, of `plumbline map --report`.
import { card, element } from './dom.js';
import { TimeAxis } from './chart.js';
import { Lazy } from './lazy.js';
import { MapView } from './map_view.js';
import { view_of } from './space.js';
import { on_theme } from './theme.js';
import { top_view } from './top_view.js';
import { Viewer } from './viewer.js';

export function map_page(data) {
  const axis = new TimeAxis('map'), charts = [], redraw = () => charts.forEach(chart => chart.lazy.invalidate());
  const map = new MapView(data.map, redraw), view = view_of([data.map.keyframes], data.has_imu);
  const make = (title, controls, className, draw) => {
    const chart = card(title, controls, className);
    chart.lazy = new Lazy(chart.node, () => draw(chart));
    charts.push(chart);
    return chart.node;
  };
  const tall = Math.max(300, Math.round(0.55 * window.innerHeight));
  let viewer;
  on_theme(redraw);
  return element('main', { class: 'cards saved' },
    make('In space', map.controls, '', chart => { viewer ??= new Viewer(chart.place, axis, tall); viewer.show(map.scene(), view, 'map'); }),
    make('From above', [], 'half', chart => top_view(chart.place, axis, map.scene(), view, 380)), map.figures('half'));
}
