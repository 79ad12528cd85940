/// The runs of a comparison, grouped by configuration and data set.
import { largest, median, smallest, is_number } from './figures.js';

export const health_names = ['initializing', 'tracking', 'degraded', 'lost'];

/// Processor time where it is recorded: other processes affect it less.
export const time_of = run => run.time_ms?.cpu_median ?? run.time_ms?.median;

/// Name of what is compared: runs with a map are rows of their own.
export const label_of = run => (run.with_map ? `${run.configuration} --map` : run.configuration);

const distinct = values => [...new Set(values)];
const group_key = (configuration, dataset) => JSON.stringify([configuration, dataset]);

/// All repeats of one configuration on one data set. `figures` are medians over the repeats, and the worst of them: a run
/// that failed has an infinite error and covers nothing, other figures are of those that did not fail. `typical` is the
/// run whose error is nearest to the median, of those with series of their frames.
class Group {
  constructor(configuration, dataset, runs) {
    this.configuration = configuration;
    this.dataset = dataset;
    this.runs = [...runs].sort((a, b) => a.repeat - b.repeat);
    this.ok = this.runs.filter(run => run.status === 'ok');
    this.failed = this.runs.filter(run => run.status !== 'ok');
    const all = get => this.ok.map(run => get(run));
    const ates = all(run => run.ate?.rmse), has_ate = ates.some(is_number);
    ates.push(...this.failed.map(() => Infinity));
    this.figures = {
      ate: has_ate ? median(ates) : null,
      ate_worst: has_ate ? largest(ates) : null,
      ate_final: median(all(run => run.ate_final?.rmse)),
      loops: median(all(run => run.map_counts?.loops)),
      rpe: median(all(run => run.rpe_1s?.translation_rmse)),
      rpe_rotation: median(all(run => run.rpe_1s?.rotation_rmse_deg)),
      scale_error: median(all(run => run.scale_error)),
      coverage: this.ok.length ? smallest([...all(run => run.coverage), ...this.failed.map(() => 0)]) : null,
      time: median(all(time_of)),
      time_p99: median(all(run => run.time_ms?.p99)),
      time_max: largest(all(run => run.time_ms?.max)),
      start: median(all(run => run.start_s)),
      resets: this.ok.reduce((sum, run) => sum + (run.health?.resets ?? 0), 0),
    };
    this.health = health_names.map(name => this.ok.reduce((sum, run) => sum + (run.health?.[name] ?? 0), 0));
    this.alignment = distinct(all(run => run.alignment).filter(Boolean)).join(', ');
    this.causal = this.ok.length ? this.ok.every(run => run.causal) : null;
    const middle = median(all(run => run.ate?.rmse)), whole = this.ok.filter(run => run.frame_series);
    const distance = run => (is_number(run.ate?.rmse) ? Math.abs(run.ate.rmse - middle) : Infinity);
    this.typical = (whole.length ? whole : this.ok).reduce((best, run) => (!best || distance(run) < distance(best) ? run : best), null);
  }

  /// Reasons of the failures with their number, the most frequent first.
  get reasons() {
    const counts = new Map();
    for (const run of this.failed) counts.set(run.error || 'no reason given', (counts.get(run.error || 'no reason given') ?? 0) + 1);
    return [...counts].sort((a, b) => b[1] - a[1]);
  }

  /// The terms of an error: "96 % of the frames, se3, causal".
  get terms() {
    if (!this.ok.length) return '';
    return [is_number(this.figures.coverage) ? `${Math.floor(100 * this.figures.coverage + 1e-6)} % covered` : 'coverage unknown',
      this.alignment || 'not aligned', this.causal ? 'causal' : 'not causal'].join(', ');
  }
}

export class Comparison {
  constructor(data) {
    const runs = (data?.runs ?? []).map(run => ({ ...run, configuration: label_of(run) }));
    const names = (data?.configurations ?? []).map(each => each.name), labels = distinct(runs.map(run => run.configuration));
    this.machine = data?.machine ?? {};
    this.processes = data?.processes ?? 1;
    this.missing = Math.max(0, (data?.plans ?? []).reduce((sum, plan) => sum + plan.runs, 0) - runs.length);
    this.machines = 1 + distinct(runs.filter(run => run.machine).map(run => JSON.stringify(run.machine))).length;
    this.runs = runs;
    this.datasets = distinct([...(data?.datasets ?? []).map(each => each.name), ...runs.map(run => run.dataset)]);
    this.configurations = distinct([...names.flatMap(name => (labels.includes(`${name} --map`) ? [labels.includes(name) && name, `${name} --map`] : name)).filter(Boolean), ...labels]);
    this.has_map = runs.some(run => run.with_map);
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
    const name = configuration.replace(/ --map$/, ''), [sensors, features, backend] = name.split('/');
    const about = this.about_configuration.get(name) ?? {};
    return { sensors: about.sensors ?? sensors, features: about.features ?? features ?? '', backend: about.backend ?? backend ?? '' };
  }
}
