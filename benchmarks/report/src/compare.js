/// The page of `plumbline compare`.
import { Comparison } from './comparison.js';
import { DatasetSection } from './dataset_section.js';
import { DifferenceSection } from './difference_section.js';
import { element } from './dom.js';
import { is_number, text_of } from './figures.js';
import { ResultsTable } from './results_table.js';
import { Store } from './store.js';
import { theme_button } from './theme.js';

const first_chosen = 4;

function header(comparison) {
  const { machine, runs } = comparison, failed = runs.filter(run => run.status !== 'ok').length;
  const plural = (count, name) => `${count} ${name}${count === 1 ? '' : 's'}`;
  const parts = [machine.cpu, is_number(machine.cores) && plural(machine.cores, 'core'), is_number(machine.memory_gib) && `${text_of(machine.memory_gib)} GiB`, machine.os, machine.compiler, machine.build, machine.plumbline && `plumbline ${machine.plumbline}`];
  return element('header', {}, element('div', {}, element('h1', {}, element('i', { class: 'bob', 'aria-hidden': 'true' }), 'plumbline compare'), theme_button()),
    element('p', { class: 'lead' }, `${plural(comparison.configurations.length, 'configuration')} on ${plural(comparison.datasets.length, 'data set')}, ${plural(runs.length, 'run')}`,
      failed > 0 && [', ', element('strong', { class: 'failure' }, `${failed} failed`)], comparison.missing > 0 && [', ', element('strong', { class: 'failure' }, `${comparison.missing} missing`)], '.'),
    element('p', { class: 'note machine' }, `Machine: ${parts.filter(Boolean).join(', ') || 'not stated'}. ${plural(comparison.processes, 'process')}`.replace('processs', 'processes') + ' side by side; compare times within this page only.' + (comparison.machines > 1 ? ` Some runs were made on other machines (${comparison.machines} in all): their times cannot be compared.` : '')));
}

function main() {
  const comparison = new Comparison(JSON.parse(document.getElementById('plumbline-data').textContent));
  const page = element('main');
  document.body.append(header(comparison), page);
  if (comparison.runs.length === 0) {
    page.append(element('p', { class: 'empty' }, 'There are no runs in this comparison.'));
    return;
  }
  const store = new Store();
  // The data set with truth that most configurations can do, and the best of them.
  const worth = name => comparison.groups.filter(group => group.dataset === name && group.ok.length).length + (comparison.truth(name) ? 0.5 : -1e6);
  store.dataset = comparison.datasets.reduce((best, name) => (worth(name) > worth(best) ? name : best));
  comparison.groups.filter(group => group.dataset === store.dataset && group.ok.length)
    .sort((a, b) => Math.min(a.figures.ate ?? Infinity, Number.MAX_VALUE) - Math.min(b.figures.ate ?? Infinity, Number.MAX_VALUE)).slice(0, first_chosen).forEach(group => store.choose(group.configuration, true));

  const dataset = new DatasetSection(comparison, store);
  const table = new ResultsTable(comparison, store, group => {
    store.choose(group.configuration, true);
    store.open(group.dataset);
    dataset.node.scrollIntoView({ behavior: window.matchMedia('(prefers-reduced-motion: reduce)').matches ? 'auto' : 'smooth' });
  });
  page.append(element('section', { 'aria-labelledby': 'results' }, element('h2', { id: 'results' }, 'Results'),
    element('p', { class: 'note' }, 'Medians over the repeats; a run that failed has an infinite error. Check a box to draw a configuration, choose its name to see it on that data set.'), table.node), dataset.node);
  if (comparison.configurations.length > 1) page.append(new DifferenceSection(comparison, store).node);
}

main();
