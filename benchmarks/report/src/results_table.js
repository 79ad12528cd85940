/// All groups as rows: sorted by a click on a column's head, filtered by what is chosen above.
import { health_legend } from './health_chart.js';
import { checkbox, element, name_of, select } from './dom.js';
import { dash, is_number, percent, text_of } from './figures.js';
import { health_names } from './comparison.js';

const first_rows = window.innerWidth < 700 ? 8 : 40;

const number = (name, get, unit = '', title = '') => ({ name, unit, title, value: group => group.figures[get], text: group => text_of(group.figures[get]), numeric: true });
const share = (name, get, title) => ({ name, title, value: group => group.figures[get], text: group => percent(group.figures[get]), numeric: true });

const columns = [
  { name: 'Configuration', value: group => group.configuration },
  { name: 'Data set', value: group => group.dataset, text: group => group.dataset },
  { name: 'Runs', title: 'Runs that gave figures, of all repeats', value: group => group.ok.length / group.runs.length, numeric: true,
    text: group => (group.failed.length ? `${group.ok.length} of ${group.runs.length}` : `${group.runs.length}`) },
  number('ATE', 'ate', 'm', 'Root mean square of the position error after alignment; median over the repeats'),
  number('worst', 'ate_worst', 'm', 'The largest ATE of a repeat; failed, if one failed'),
  share('Coverage', 'coverage', 'Frames with a pose that was compared, of those that have truth: the least of the repeats, nothing of a failed one'),
  { name: 'Aligned', title: 'Alignment to the truth before errors are taken', value: group => group.alignment, text: group => group.alignment || dash },
  { name: 'Causal', title: 'Each pose is the one published with its frame', value: group => (group.causal === null ? null : Number(group.causal)),
    text: group => (group.causal === null ? dash : group.causal ? 'yes' : 'no') },
  number('RPE', 'rpe', 'm', 'Relative error over one second, root mean square'),
  number('RPE', 'rpe_rotation', 'deg', 'Relative rotation error over one second, root mean square'),
  { name: 'Scale error', title: 'Factor of a free scale, less one', value: group => (is_number(group.figures.scale_error) ? Math.abs(group.figures.scale_error) : null),
    text: group => percent_signed(group.figures.scale_error), numeric: true },
  number('Time', 'time', 'ms', 'Of a frame: median, of the processor where that is known'),
  number('p99', 'time_p99', 'ms', 'Of a frame, by the wall: 99 of 100 take less'),
  number('Start', 'start_s', 's', 'Time of the first pose'),
  { name: 'Health', title: 'Frames initializing, tracking, degraded and lost, and resets, of all repeats', value: group => (group.ok.length ? group.health[1] / Math.max(1, sum(group.health)) : null) },
];
columns[13].value = group => group.figures.start;
columns[13].text = group => text_of(group.figures.start);

const of_map = [
  number('Loops', 'loops', '', 'That the map closed; median over the repeats'),
  number('ATE final', 'ate_final', 'm', 'Of the poses as the map has them at the end of the run; ATE is that of the causal poses. Median over the repeats'),
];

const sum = values => values.reduce((a, b) => a + b, 0);
function percent_signed(value) {
  return is_number(value) ? `${value > 0 ? '+' : ''}${text_of(100 * value, 2)} %` : dash;
}

function health_cell(group) {
  if (!group.ok.length) return dash;
  const total = Math.max(1, sum(group.health));
  const text = health_names.map((name, i) => `${name} ${group.health[i]}`).join(', ') + `, resets ${group.figures.resets}`;
  return element('div', { class: 'health', title: text },
    element('div', { class: 'health-bar', 'aria-hidden': 'true' }, group.health.map((count, i) =>
      count > 0 && element('i', { class: `health-${health_names[i]}`, style: `width:${100 * count / total}%` }))),
    element('span', {}, group.health.map((count, i) => element('span', { class: `count-${health_names[i]}` }, `${count}`)),
      group.figures.resets > 0 && element('span', { class: 'resets' }, `${group.figures.resets} reset${group.figures.resets > 1 ? 's' : ''}`),
      element('span', { class: 'hidden' }, text)));
}

export class ResultsTable {
  /// `store`: chosen configurations and the present data set; `on_open(group)` when a reader wants to see one.
  constructor(comparison, store, on_open) {
    Object.assign(this, { comparison, store, on_open });
    this.columns = comparison.has_map ? [...columns.slice(0, 5), ...of_map, ...columns.slice(5)] : columns;
    this.sort = { column: 0, down: false };
    this.filter = { text: '', dataset: '', sensors: '', features: '', backend: '', failures: false };
    this.all = false;
    this.count = element('p', { class: 'note', role: 'status' });
    this.more = element('button', { type: 'button', class: 'more', onclick: () => { this.all = true; this.update(); } });
    this.body = element('tbody');
    this.heads = this.columns.map((column, i) => element('th', { scope: 'col', class: column.numeric ? 'number' : '', title: column.title },
      element('button', { type: 'button', onclick: () => this.sort_by(i) }, column.name, column.unit && element('small', {}, ` ${column.unit}`))));
    this.sorting = select('Sort by', this.columns.map((column, i) => [String(i), [column.name, column.unit].filter(Boolean).join(' ')]), '0', value => this.sort_by(Number(value), false));
    this.sorting.classList.add('sorting');
    this.node = element('div', {}, this.filters(), element('div', { class: 'above-table' }, this.count, health_legend()),
      element('div', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': 'Results' },
        element('table', { class: 'results' }, element('thead', {}, element('tr', {}, this.heads)), this.body)), this.more);
    this.update();
    store.subscribe(() => this.mark());
  }

  filters() {
    const change = (name, value) => { this.filter[name] = value; this.update(); };
    const parts = ['sensors', 'features', 'backend'];
    const values = part => [...new Set(this.comparison.configurations.map(name => this.comparison.sensors(name)[part]))].filter(Boolean);
    const choose = (label, name, entries) => entries.length > 1 && select(label, [['', 'all'], ...entries.map(entry => [entry, entry])], '', value => change(name, value));
    return element('div', { class: 'filters' },
      element('label', { class: 'search' }, element('span', {}, 'Filter'), element('input', { type: 'search', placeholder: 'words of a name', oninput: event => change('text', event.target.value) })),
      choose('Data set', 'dataset', this.comparison.datasets),
      parts.map(part => choose(part[0].toUpperCase() + part.slice(1), part, values(part))),
      this.comparison.groups.some(group => group.failed.length) && checkbox('only with failures', false, value => change('failures', value)),
      this.sorting);
  }

  sort_by(column, turn = true) {
    this.sort = { column, down: turn && this.sort.column === column && !this.sort.down };
    this.sorting.querySelector('select').value = String(column);
    this.update();
  }

  rows() {
    const { text, dataset, failures } = this.filter, words = text.toLowerCase().split(/\s+/).filter(Boolean);
    const rows = this.comparison.groups.filter(group => {
      const about = this.comparison.sensors(group.configuration), name = `${group.configuration} ${group.dataset}`.toLowerCase();
      return (!dataset || group.dataset === dataset) && (!failures || group.failed.length > 0) && words.every(word => name.includes(word)) &&
        ['sensors', 'features', 'backend'].every(part => !this.filter[part] || about[part] === this.filter[part]);
    });
    const { value } = this.columns[this.sort.column], sign = this.sort.down ? -1 : 1, missing = v => v === null || v === undefined || v === '';
    return rows.sort((a, b) => {
      const x = value(a), y = value(b);
      if (missing(x) || missing(y)) return Number(missing(x)) - Number(missing(y));  // what is unknown comes last
      return sign * (typeof x === 'string' ? x.localeCompare(y) : x === y ? 0 : x - y) || a.configuration.localeCompare(b.configuration) || a.dataset.localeCompare(b.dataset);
    });
  }

  update() {
    const rows = this.rows(), shown = this.all ? rows : rows.slice(0, first_rows);
    this.heads.forEach((head, i) => head.setAttribute('aria-sort', i === this.sort.column ? (this.sort.down ? 'descending' : 'ascending') : 'none'));
    this.count.textContent = rows.length === this.comparison.groups.length ? `${rows.length} rows: each is one configuration on one data set` : `${rows.length} of ${this.comparison.groups.length} rows`;
    this.body.replaceChildren(...shown.map(group => this.row(group)));
    this.more.hidden = shown.length === rows.length;
    this.more.textContent = `Show all ${rows.length} rows`;
    this.mark();
  }

  row(group) {
    const box = element('input', { type: 'checkbox', 'aria-label': `Draw ${group.configuration}`, onchange: event => this.store.choose(group.configuration, event.target.checked) });
    const failure = group.failed.length > 0 && element('div', { class: 'failure' }, group.reasons.map(([reason, count]) =>
      element('div', {}, element('strong', {}, count > 1 ? `${count} runs failed: ` : 'failed: '), reason)));
    const name = element('th', { scope: 'row' }, element('div', { class: 'name' }, box, element('i', { class: 'swatch' }),
      element('button', { type: 'button', class: 'open', title: 'Show its charts on this data set', onclick: () => this.on_open(group) }, name_of(group.configuration))), failure);
    const row = element('tr', { class: group.ok.length ? '' : 'all-failed' }, name, this.columns.slice(1).map(column =>
      element('td', { class: column.numeric ? 'number' : '', 'data-label': [column.name, column.unit].filter(Boolean).join(' ') }, column.text ? column.text(group) : health_cell(group))));
    row.group = group;
    return row;
  }

  /// Which configurations are drawn, and in which color.
  mark() {
    for (const row of this.body.children) {
      const style = this.store.style_of(row.group.configuration), box = row.querySelector('input'), swatch = row.querySelector('.swatch');
      box.checked = style !== null;
      swatch.style.setProperty('--color', style?.color ?? 'transparent');
      swatch.dataset.dashed = String((style?.dash.length ?? 0) > 0);
    }
  }
}
