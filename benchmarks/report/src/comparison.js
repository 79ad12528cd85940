/// The runs of a comparison, grouped by configuration and data set.
import { largest, median, smallest, is_number } from './figures.js';

export const health_names = ['initializing', 'tracking', 'degraded', 'lost'];

const distinct = values => [...new Set(values)];
const group_key = (configuration, dataset) => JSON.stringify([configuration, dataset]);

/// All repeats of one configuration on one data set. `figures` are medians over the runs that did not fail, and the
/// worst of them; `typical` is the run whose error is nearest to the median.
class Group {
  constructor(configuration, dataset, runs) {
    this.configuration = configuration;
    this.dataset = dataset;
    this.runs = [...runs].sort((a, b) => a.repeat - b.repeat);
    this.ok = this.runs.filter(run => run.status === 'ok');
    this.failed = this.runs.filter(run => run.status !== 'ok');
    const all = get => this.ok.map(run => get(run));
    this.figures = {
      ate: median(all(run => run.ate?.rmse)),
      ate_worst: largest(all(run => run.ate?.rmse)),
      rpe: median(all(run => run.rpe_1s?.translation_rmse)),
      rpe_rotation: median(all(run => run.rpe_1s?.rotation_rmse_deg)),
      scale_error: median(all(run => run.scale_error)),
      coverage: median(all(run => run.coverage)),
      coverage_worst: smallest(all(run => run.coverage)),
      time: median(all(run => run.time_ms?.median)),
      time_p99: median(all(run => run.time_ms?.p99)),
      time_max: largest(all(run => run.time_ms?.max)),
      start: median(all(run => run.start_s)),
      resets: this.ok.reduce((sum, run) => sum + (run.health?.resets ?? 0), 0),
    };
    this.health = health_names.map(name => this.ok.reduce((sum, run) => sum + (run.health?.[name] ?? 0), 0));
    this.alignment = distinct(all(run => run.alignment).filter(Boolean)).join(', ');
    this.causal = this.ok.length ? this.ok.every(run => run.causal) : null;
    const distance = run => (is_number(run.ate?.rmse) ? Math.abs(run.ate.rmse - this.figures.ate) : Infinity);
    this.typical = this.ok.reduce((best, run) => (!best || distance(run) < distance(best) ? run : best), null);
  }

  /// Reasons of the failures with their number, the most frequent first.
  get reasons() {
    const counts = new Map();
    for (const run of this.failed) counts.set(run.error || 'no reason given', (counts.get(run.error || 'no reason given') ?? 0) + 1);
    return [...counts].sort((a, b) => b[1] - a[1]);
  }

  /// What an error is worth: "96 % of the frames, se3, causal".
  get terms() {
    if (!this.ok.length) return '';
    return [is_number(this.figures.coverage) ? `${Math.floor(100 * this.figures.coverage + 1e-6)} % covered` : 'coverage unknown',
      this.alignment || 'not aligned', this.causal ? 'causal' : 'not causal'].join(', ');
  }
}

export class Comparison {
  constructor(data) {
    const runs = data?.runs ?? [];
    this.machine = data?.machine ?? {};
    this.processes = data?.processes ?? 1;
    this.runs = runs;
    this.datasets = distinct([...(data?.datasets ?? []).map(each => each.name), ...runs.map(run => run.dataset)]);
    this.configurations = distinct([...(data?.configurations ?? []).map(each => each.name), ...runs.map(run => run.configuration)]);
    this.about_dataset = new Map((data?.datasets ?? []).map(each => [each.name, each]));
    this.about_configuration = new Map((data?.configurations ?? []).map(each => [each.name, each]));

    const by_group = new Map();
    for (const run of runs) {
      const key = group_key(run.configuration, run.dataset);
      if (!by_group.has(key)) by_group.set(key, []);
      by_group.get(key).push(run);
    }
    this.groups = [...by_group.values()].map(group => new Group(group[0].configuration, group[0].dataset, group));
    this.index = new Map(this.groups.map(group => [group_key(group.configuration, group.dataset), group]));
  }

  group(configuration, dataset) {
    return this.index.get(group_key(configuration, dataset)) ?? null;
  }
  truth(dataset) {
    const truth = this.about_dataset.get(dataset)?.truth;
    return truth?.t?.length ? truth : null;
  }
  sensors(configuration) {
    const [sensors, features, backend] = configuration.split('/');
    const about = this.about_configuration.get(configuration) ?? {};
    return { sensors: about.sensors ?? sensors, features: about.features ?? features ?? '', backend: about.backend ?? backend ?? '' };
  }
}
