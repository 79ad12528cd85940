/// The page of `plumbline doctor`: what was found, the worst first, and what it comes from over time.
import uPlot from 'uplot';
import { card, element } from './dom.js';
import { axis_style, plot_in, TimeAxis, time_chart } from './chart.js';
import { is_number, text_of } from './figures.js';
import { Lazy } from './lazy.js';
import { css_color, on_theme, theme_button } from './theme.js';

const levels = ['ERROR', 'WARN', 'NOTE', 'OK'];
const words = { ERROR: ['error', 'errors'], WARN: ['warning', 'warnings'], NOTE: ['note', 'notes'] };

/// "1 error, 2 warnings"
function summary_of(diagnoses) {
  const counts = Object.entries(words).map(([level, names]) => [diagnoses.filter(each => each.level === level).length, names]);
  return counts.filter(([n]) => n > 0).map(([n, names]) => `${n} ${names[n > 1 ? 1 : 0]}`).join(', ') || 'nothing wrong';
}

function findings_of(diagnoses) {
  const sorted = levels.flatMap(level => diagnoses.filter(each => each.level === level));
  return element('div', { class: 'scroll' }, element('table', { class: 'findings' },
    element('thead', { class: 'hidden' }, element('tr', {}, ['Level', 'Check', 'Finding'].map(name => element('th', { scope: 'col' }, name)))),
    element('tbody', {}, sorted.map(({ level, check, text }) => element('tr', {},
      element('td', {}, element('b', { class: `level level-${level.toLowerCase()}` }, level)), element('th', { scope: 'row' }, check), element('td', {}, text))))));
}

/// A curve in logarithmic axes.
function log_chart(place, { label, x_name, x_unit, y_unit, x, y, color }) {
  const positive = y.map(value => (value > 0 ? value : null));
  const texts = (plot, ticks) => ticks.map(value => (value !== null && Math.abs(Math.log10(value) % 1) < 1e-9 ? String(Number(value.toPrecision(1))) : ''));
  const plot = plot_in(place, {
    height: 200, padding: [8, null, 0, 0], cursor: { drag: { x: false, y: false }, points: { size: 6 } },
    scales: { x: { time: false, distr: 3 }, y: { distr: 3, range: (u, low, high) => (low > 0 ? uPlot.rangeLog(low, high, 10, true) : [0.1, 1]) } },
    axes: [axis_style({ size: 30, values: texts }), axis_style({ size: 60, values: texts })],
    legend: { markers: { width: 0, fill: (u, i) => u.series[i].stroke(u, i) } },
    series: [{ label: x_name, value: (u, value) => (is_number(value) ? `${text_of(value)} ${x_unit}` : '') },
      { label, stroke: color, width: 1.5, points: { show: false }, value: (u, value) => (is_number(value) ? `${text_of(value)} ${y_unit}` : '') }],
  }, [x, positive]);
  place.setAttribute('role', 'img');
  place.setAttribute('aria-label', `${label} over ${x_name}: ${text_of(y[0])} ${y_unit} at ${text_of(x[0])} ${x_unit}, ${text_of(y.at(-1))} at ${text_of(x.at(-1))}`);
  return () => {
    plot.take_down();
    place.replaceChildren();
  };
}

/// What a calibration may state, as plumbline and Kalibr name it.
function noise_text({ rest_s, ...sensors }) {
  const lines = [`# by ${rest_s.toFixed(1)} s at rest; intervals of 95 %`];
  for (const [sensor, { density, random_walk: walk }] of Object.entries(sensors)) {
    if (!density) continue;
    const digits = value => value.toPrecision(3), interval = each => `${digits(each.low)} to ${digits(each.high)}`;
    if (density.low > 0) lines.push(`${sensor}_noise_density: ${digits(density.value)}   # ${interval(density)}`);
    else lines.push(`# ${sensor}_noise_density: at most ${digits(density.high)}; something vibrates even at rest`);
    if (walk.low > 0) lines.push(`${sensor}_random_walk: ${digits(walk.value)}   # ${interval(walk)}`);
    else lines.push(`# ${sensor}_random_walk: at most ${digits(walk.high)}; more time at rest is needed to tell it`);
  }
  return lines.length > 1 ? lines.join('\n') : null;
}

class DoctorPage {
  constructor(data) {
    this.series = data.series;
    this.noise_series = data.noise_series;
    this.noise = data.imu_noise;
    this.axis = new TimeAxis('recording');
    this.axis.span = this.span();
    this.charts = [];
    this.node = element('main', { class: 'cards saved' }, this.curves(), this.noise_charts());
    on_theme(() => this.charts.forEach(chart => chart.lazy.invalidate()));
  }

  /// Of all times that are drawn.
  span() {
    const { images, imu, looks } = this.series, all = [images?.intervals, imu?.intervals, imu?.gyroscope, looks].filter(Boolean).flatMap(({ t }) => [t[0], t.at(-1)]).filter(is_number);
    const low = Math.min(...all), high = Math.max(...all);
    return all.length ? [low, Math.max(high, low + 1e-3)] : [0, 1];
  }

  make(title, unit, series, columns) {
    const chart = card(unit ? `${title} [${unit}]` : title, [], 'half');
    const curves = () => columns.map(([column, name, color]) => ({ name, t: series.t, y: series[column], color: css_color(color) }));
    chart.lazy = new Lazy(chart.node, () => time_chart(chart.place, this.axis, { label: title, unit, curves: curves(), height: 180 }));
    this.charts.push(chart);
    return chart.node;
  }

  /// Spectra in motion, Allan deviations at rest, and what to state.
  noise_charts() {
    if (!this.noise) return [];
    const sensors = [['gyroscope', 'Gyroscope', 'rad/s', 'rad/s/√Hz'], ['accelerometer', 'Accelerometer', 'm/s²', 'm/s²/√Hz']];
    const chart_of = (title, options) => {
      const chart = card(title, [], 'half');
      chart.lazy = new Lazy(chart.node, () => log_chart(chart.place, { ...options, color: css_color('--stage-1') }));
      this.charts.push(chart);
      return chart.node;
    };
    const spectra = sensors.map(([sensor, name, , unit]) => this.noise_series[sensor].spectrum && chart_of(`${name} in motion: spectrum [${unit}]`,
      { label: 'density', x_name: 'frequency', x_unit: 'Hz', y_unit: unit, x: this.noise_series[sensor].spectrum.hz, y: this.noise_series[sensor].spectrum.density }));
    const deviations = sensors.map(([sensor, name, unit]) => this.noise_series[sensor].allan && chart_of(`${name} at rest: Allan deviation [${unit}]`,
      { label: 'deviation', x_name: 'averaging time', x_unit: 's', y_unit: unit, x: this.noise_series[sensor].allan.tau_s, y: this.noise_series[sensor].allan.deviation }));
    const text = noise_text(this.noise), paste = card('Noise of the IMU, for a calibration');
    paste.place.append(element('pre', { class: 'paste' }, text ?? ''));
    return [...spectra, ...deviations, text && paste.node];
  }

  curves() {
    const { images, imu, looks } = this.series, axes = [['x', 'x', '--stage-1'], ['y', 'y', '--stage-2'], ['z', 'z', '--stage-3']];
    return [
      images && this.make('Time from image to image', 'ms', images.intervals, [['ms', 'interval', '--stage-1']]),
      imu && this.make('Time from IMU sample to IMU sample', 'ms', imu.intervals, [['ms', 'interval', '--stage-1']]),
      imu && this.make('Gyroscope', 'rad/s', imu.gyroscope, axes),
      imu && this.make('Accelerometer', 'm/s²', imu.accelerometer, axes),
      looks && this.make('Brightness of the images, 0 to 255', '', looks, [['brightness', 'mean', '--stage-1'], ['contrast', 'standard deviation', '--stage-3']]),
      looks && this.make('Corners followed from the image before', '', looks, [['corners', 'corners', '--tracking']]),
    ];
  }
}

const data = JSON.parse(document.getElementById('plumbline-data').textContent);
document.title = `plumbline doctor: ${data.dataset}`;
document.body.append(
  element('header', {}, element('div', {}, element('h1', {}, element('i', { class: 'bob', 'aria-hidden': 'true' }), data.dataset), theme_button()),
    element('p', { class: 'lead' }, summary_of(data.diagnoses)), element('p', { class: 'note' }, 'plumbline doctor: drag in a chart to zoom, double click for all.')),
  findings_of(data.diagnoses), new DoctorPage(data).node);
