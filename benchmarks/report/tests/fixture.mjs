// Made-up comparisons and debug data, the same in every run, and pages that hold them.
//   node tests/fixture.mjs compare|debug NAME FILE.html; NAME of debug: usual, map, saved
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

/// mulberry32
function random_of(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), state | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}
const round = value => Number(value.toPrecision(6));

const places = {
  flight: t => [3 * Math.sin(0.5 * t), 2 * Math.sin(0.8 * t + 0.4), 1.2 + 0.5 * Math.sin(0.33 * t)],
  car: t => [18 * Math.sin(0.16 * t), 0.2 * Math.sin(0.3 * t), 7 * t],
  hand: t => [0.4 * Math.sin(1.3 * t), 0.3 * Math.sin(1.7 * t), 1 + 0.25 * Math.sin(0.9 * t)],
};

function dataset_of(name, place, frames, rate, rest = {}) {
  const t = Array.from({ length: frames }, (_, i) => round(i / rate));
  const truth = { t, x: [], y: [], z: [] };
  for (const each of t) ['x', 'y', 'z'].forEach((axis, k) => truth[axis].push(round(places[place](each)[k])));
  return { name, frames, duration_s: frames / rate, rate_hz: rate, width: 752, height: 480, has_depth: false, has_imu: true,
    truth, place, ...rest };
}

/// Points and edges of a room of twice the size of the way.
function map_of(dataset, has_points, has_lines, random) {
  const axes = ['x', 'y', 'z'].map(axis => places_of(dataset).map(p => p[['x', 'y', 'z'].indexOf(axis)]));
  const low = axes.map(a => Math.min(...a)), high = axes.map(a => Math.max(...a));
  const margin = 0.25 * Math.max(...high.map((h, i) => h - low[i]));
  const box = low.map((l, i) => [l - margin, high[i] + margin]);
  const points = [], segments = [];
  for (let i = 0; has_points && i < 300; ++i) {
    const p = box.map(([a, b]) => round(a + (b - a) * random()));
    const wall = Math.floor(3 * random());
    p[wall] = round(box[wall][random() < 0.5 ? 0 : 1]);
    points.push(p);
  }
  for (let i = 0; has_lines && i < 40; ++i) {
    const p = box.map(([a, b]) => round(a + (b - a) * random())), q = [...p];
    const wall = i % 3, along = (wall + 1 + (i % 2)) % 3;
    p[wall] = q[wall] = round(box[wall][random() < 0.5 ? 0 : 1]);
    q[along] = round(p[along] + 0.3 * margin * (1 + random()));
    segments.push([...p, ...q]);
  }
  return { points, segments };
}
const places_of = dataset => Array.from({ length: 40 }, (_, i) => places[dataset.place](i / 39 * dataset.duration_s));

function run_of(configuration, dataset, repeat, index) {
  const [sensors, features, backend] = configuration.split('/');
  const random = random_of(7919 * index + 104729 * repeat + 31 * dataset.name.length + 1);
  const run = { configuration, dataset: dataset.name, repeat, first_frame: repeat, status: 'ok', error: '', causal: true };
  const has_truth = dataset.truth.t.length > 0, has_lines = features.includes('line'), has_points = features !== 'lines';
  const size = (0.01 + 0.012 * (index % 7)) * (0.8 + 0.5 * random()) * (dataset.place === 'car' ? 30 : 1);
  const phases = [0, 1, 2].map(() => 6.28 * random());
  const begin = repeat + 8 + Math.floor(20 * random()), series = { t: [], track_ms: [], estimate_ms: [], map_ms: [], total_ms: [], health: [], points: [], lines: [] };
  const trajectory = { t: [], x: [], y: [], z: [], error: [] };
  const lost_from = begin + Math.floor(random() * dataset.frames * 2), counts = [0, 0, 0, 0];
  for (let i = repeat; i < dataset.frames; ++i) {
    const t = i / dataset.rate_hz;
    const health = i < begin ? 0 : i >= lost_from && i < lost_from + 6 ? 3 : i >= lost_from + 6 && i < lost_from + 25 ? 2 : 1;
    ++counts[health];
    const track = 0.6 + 0.25 * random() + 0.1 * (index % 5), estimate = (backend === 'window' ? 1.6 : 0.7) + 0.3 * random();
    const map = i % 7 === 0 ? 2 + 3 * random() : 0.1;
    series.t.push(round(t));
    series.track_ms.push(round(track));
    series.estimate_ms.push(round(estimate));
    series.map_ms.push(round(map));
    series.total_ms.push(round(track + estimate + map));
    series.health.push(health);
    series.points.push(has_points ? Math.round(120 + 50 * Math.sin(0.4 * t + phases[0]) + 15 * random()) * (health === 3 ? 0 : 1) : 0);
    if (has_lines) series.lines.push(Math.round(28 + 9 * Math.sin(0.7 * t + phases[1]) + 4 * random()));
    if (health === 0 || health === 3) continue;
    const p = places[dataset.place](t).map((value, k) => value + size * Math.sin((0.3 + 0.13 * k) * t + phases[k]) * (0.5 + t / dataset.duration_s));
    trajectory.t.push(round(t));
    ['x', 'y', 'z'].forEach((axis, k) => trajectory[axis].push(round(p[k])));
    const truth = places[dataset.place](t);
    trajectory.error.push(has_truth ? round(Math.hypot(...p.map((value, k) => value - truth[k]))) : null);
  }
  const sorted = [...series.total_ms].sort((a, b) => a - b), errors = trajectory.error;
  const rmse = has_truth ? round(Math.sqrt(errors.reduce((sum, e) => sum + e * e, 0) / errors.length)) : null;
  const alignment = sensors === 'mono' ? 'sim3' : sensors.endsWith('imu') ? 'posyaw' : 'se3';
  return Object.assign(run, {
    alignment, scale: alignment === 'sim3' ? round(3 + random()) : 1, scale_error: has_truth ? round(0.01 * (random() - 0.5)) : null,
    frames: dataset.frames - repeat, poses: errors.length, compared: has_truth ? errors.length : 0,
    coverage: has_truth ? round(errors.length / (dataset.frames - repeat)) : null,
    ate: { rmse, median: rmse && round(0.9 * rmse), max: rmse && round(Math.max(...errors)) },
    rpe_1s: { translation_rmse: rmse && round(0.2 * rmse), rotation_rmse_deg: rmse && round(0.1 + 0.2 * random()) },
    health: { initializing: counts[0], tracking: counts[1], degraded: counts[2], lost: counts[3], resets: counts[3] ? 1 : 0 },
    start_s: round(begin / dataset.rate_hz),
    time_ms: { median: sorted[sorted.length >> 1], p99: sorted[Math.floor(0.99 * sorted.length)], max: sorted[sorted.length - 1] },
    frame_series: series, trajectory,
    ...(repeat === 0 ? { map: map_of(dataset, has_points, has_lines, random) } : {}),
  });
}

/// As of a run with a map.
function with_map(run) {
  const map = Object.fromEntries(['learn', 'query', 'verify', 'solve'].map((stage, k) => [stage, { mean: 0.02 + 0.01 * k, max: 2 + k }]));
  const map_counts = { keyframes: 42, evicted: 0, queries: 30, verified: 9, rejected_by_gate: 1, rejected_by_tilt: 0, rejected_as_ambiguous: 2, loops: 3 + run.repeat, corrections: 2, relocalizations: 1 };
  return { ...run, with_map: true, map_counts, ate_final: { rmse: round(run.ate.rmse / 4), median: round(run.ate.rmse / 5), max: run.ate.rmse }, time_ms: { ...run.time_ms, map } };
}

function comparison_of(configurations, datasets, repeats) {
  const failed = (run, error) => {
    const { configuration, dataset, repeat, first_frame } = run;
    return { configuration, dataset, repeat, first_frame, status: 'failed', error };
  };
  const runs = [];
  datasets.forEach(dataset => configurations.forEach((name, index) => {
    for (let repeat = 0; repeat < repeats; ++repeat) {
      const run = run_of(name, dataset, repeat, index);
      if (name.startsWith('rgbd') && !dataset.has_depth) runs.push(failed(run, 'needs depth images and the calibration\'s depth scale'));
      else if (name === 'mono/lines/window' && repeat % 3 === 1) runs.push(failed(run, 'no pose in 500 frames: <too little parallax> & few lines'));
      else runs.push(run);
    }
  }));
  return {
    format: 'plumbline-compare', version: 1,
    machine: { cpu: 'Example CPU @ 2.50GHz', cores: 2, memory_gib: 23.5, os: 'Debian GNU/Linux 12', compiler: 'GCC 12.2.0', build: 'Release', plumbline: '0.1.0' },
    processes: 2,
    datasets: datasets.map(({ place, ...rest }) => rest),
    configurations: configurations.map(name => {
      const [sensors, features, backend] = name.split('/');
      return { name, sensors, features, backend, bytes: 3500000 };
    }),
    runs,
  };
}

function comparison_with_map() {
  const out = comparison_of(['mono-imu/points/window', 'rgbd/points/window'], [dataset_of('sample_flight', 'flight', 120, 20, { has_depth: true })], 2);
  out.runs = out.runs.flatMap(run => (run.configuration.startsWith('rgbd') ? [with_map(run)] : [run, with_map(run)]));
  return out;
}

const few = ['mono-imu/points/window', 'mono-imu/points+lines/window', 'mono-imu/points+lines/direct', 'mono/points/window',
  'mono/lines/window', 'rgbd/points/window', 'mono-imu/points+lines+collinear/window'];
const product = (...lists) => lists.reduce((all, list) => all.flatMap(a => list.map(b => [...a, b])), [[]]);
const forty = product(['mono', 'mono-imu', 'rgbd', 'rgbd-imu'],
  ['points', 'lines', 'points+lines', 'points+collinear', 'points+lines+collinear'], ['window', 'direct']).map(each => each.join('/'));
const no_truth = { t: [], x: [], y: [], z: [] };

export const comparisons = {
  usual: () => comparison_of(few, [dataset_of('sample_flight', 'flight', 500, 20), dataset_of('sample_car', 'car', 200, 10, { has_imu: false }),
    dataset_of('sample_hand_without_truth', 'hand', 200, 30, { truth: no_truth, has_depth: true })], 4),
  large: () => comparison_of(forty, Array.from({ length: 8 }, (_, i) =>
    dataset_of(`recording_${i + 1}`, ['flight', 'car', 'hand'][i % 3], 100, 10, { has_depth: true })), 8),
  map: comparison_with_map,
  one: () => comparison_of(few.slice(0, 1), [dataset_of('sample_flight', 'flight', 60, 20)], 1),
  zero: () => comparison_of([], [], 0),
  failed: () => comparison_of(['rgbd/points/window'], [dataset_of('sample_flight', 'flight', 60, 20)], 2),
};

/// Keyframes along a way, with loops, pairs of keyframes that see the same, and the points of a room.
function keyframe_map(dataset, keyframes = 24) {
  const all = Array.from({ length: keyframes }, (_, i) => places[dataset.place](i / (keyframes - 1) * dataset.duration_s).map(round));
  return {
    keyframes: { x: all.map(p => p[0]), y: all.map(p => p[1]), z: all.map(p => p[2]), world: all.map((_, i) => (i < keyframes / 2 ? 0 : 1)) },
    loops: [[0, keyframes - 4], [2, keyframes - 2], [3, keyframes - 1]],
    covisible: all.slice(1).map((_, i) => [i, i + 1]),
    points: map_of(dataset, true, false, random_of(3)).points,
  };
}

/// As `plumbline map --report` writes it.
export function saved_map_data(keyframes = 24) {
  const dataset = dataset_of('sample', 'flight', 240, 20), map = keyframe_map(dataset, keyframes);
  return { format: 'plumbline-map', version: 1, title: 'house <of a room>.map', summary: 'made by a rig with an IMU: meters, z up', has_imu: true, t: [],
    map: { ...map, counts: { keyframes, worlds: 2, features: 9000, points: map.points.length, loops: 3 }, path: 23.4, extent: [8, 6, 3] } };
}

/// The map of a run: the odometry drifts, the map corrects it in the last third.
function run_map(dataset, { t, x, y, z }, with_truth) {
  const drift = (at, share) => { const i = t.indexOf(at); return { x: round(x[i] + share * at / 10), y: round(y[i] + share * at / 16), z: z[i] }; };
  const path = share => ({ t, ...Object.fromEntries(['x', 'y', 'z'].map(axis => [axis, t.map(at => drift(at, share(at))[axis])])) });
  const last = t.at(-1) ?? 0, joined = t.find(at => at > 0.66 * last) ?? 0, odometry = path(() => 1), causal = path(at => (at < joined ? 1 : 0.1)), final = path(() => 0.05), k = t.indexOf(joined);
  return { ...keyframe_map(dataset), odometry, causal, final, truth: with_truth ? path(() => 0) : { t: [], x: [], y: [], z: [] },
    relocalizations: { t: [joined], x: [causal.x[k]], y: [causal.y[k]], z: [causal.z[k]] },
    counts: { keyframes: 24, evicted: 0, queries: 17, verified: 8, rejected_by_gate: 1, rejected_by_tilt: 0, rejected_as_ambiguous: 2, loops: 3, corrections: 2, relocalizations: 1 },
    ate_m: with_truth ? { odometry: 0.61, causal: 0.34, final: 0.021 } : null };
}

/// As `plumbline run --debug` writes it; its pictures are drawings.
export function debug_data({ with_truth = true, with_pictures = true, with_map: has_map = false, frames = 240 } = {}) {
  const random = random_of(5), dataset = dataset_of('sample', 'flight', frames, 20), run = run_of('mono-imu/points+lines/window', dataset, 0, 1);
  const wave = (size, speed, noise) => dataset.truth.t.map(t => round(size * Math.sin(speed * t) + noise * random()));
  const above = (level, noise) => dataset.truth.t.map((_, i) => (i < 12 ? null : round(level + noise * random())));
  const columns = {};
  for (const kind of ['points', 'lines']) {
    columns[`${kind}_located`] = run.frame_series.points.map(n => (kind === 'points' ? n : Math.round(n / 4)));
    for (const state of ['unlocated', 'rejected', 'lost']) columns[`${kind}_${state}`] = above(5, 8);
    columns[`${kind}_innovation_median_sigma`] = above(1, 0.4);
    columns[`${kind}_innovation_p90_sigma`] = above(1.9, 0.6);
    columns[`${kind}_innovation_median_px`] = above(0.3, 0.2);
    columns[`${kind}_innovation_p90_px`] = above(0.8, 0.5);
  }
  columns.sigma_position_m = above(0.02, 0.01);
  columns.sigma_rotation_deg = above(0.2, 0.05);
  for (const axis of ['x', 'y', 'z']) {
    columns[`velocity_${axis}`] = wave(1, 0.7, 0.02);
    for (const bias of ['gyro', 'accel']) {
      columns[`bias_${bias}_${axis}`] = wave(0.01, 0.1, 0.001);
      columns[`sigma_bias_${bias}_${axis}`] = above(0.002, 0.0005);
    }
  }
  columns.imu_missing = wave(0, 1, 0.02);
  for (const stage of ['track', 'estimate', 'map', 'total']) columns[`${stage}_ms`] = run.frame_series[`${stage}_ms`];
  ['learn', 'query', 'verify', 'solve'].forEach((stage, k) => { columns[`map_${stage}_ms`] = dataset.truth.t.map((_, i) => (has_map && i % 6 === k ? round(0.5 + random()) : 0)); });
  const { t, x, y, z } = run.trajectory;
  return {
    format: 'plumbline-debug', version: 1, title: 'mono-imu/points+lines/window on sample <of a room>',
    summary: `${frames} frames: ${t.length} poses, 0 skipped, 0 refused; median 2.61 ms, longest 6.22 ms`,
    t: dataset.truth.t, health: run.frame_series.health, columns, kinds: ['points', 'lines'], has_imu: true,
    errors: with_truth ? { t, position_m: run.trajectory.error, rotation_deg: t.map(() => round(0.1 + 0.2 * random())), nees_pose: t.map(() => round(4 + 5 * random())) } : null,
    trajectory: { t, x, y, z }, map: has_map ? run_map(dataset, run.trajectory, with_truth) : null,
    truth: with_truth ? { t, x: t.map(s => round(places.flight(s)[0])), y: t.map(s => round(places.flight(s)[1])), z: t.map(s => round(places.flight(s)[2])) } : null,
    pictures: with_pictures ? dataset.truth.t.map((_, row) => ({ row, file: picture(row) })) : [],
  };
}

const doctor_noise = {
  imu_noise: {
    rest_s: 12.5,
    gyroscope: { density: { value: 1.71e-4, low: 1.66e-4, high: 1.76e-4 }, random_walk: { value: 2.1e-5, low: 1.1e-5, high: 3e-5 }, vibration_rms: 0.012, vibration_peak_hz: null },
    accelerometer: { density: { value: 2.02e-3, low: 1.97e-3, high: 2.1e-3 }, random_walk: { value: 1e-4, low: 0, high: 3.4e-4 }, vibration_rms: 1.52, vibration_peak_hz: 61.3 },
  },
  noise_series: Object.fromEntries([['gyroscope', 1.7e-4], ['accelerometer', 2e-3]].map(([sensor, density]) => [sensor, {
    allan: { tau_s: [0.005, 0.01, 0.02, 0.04, 0.08], deviation: [0.005, 0.01, 0.02, 0.04, 0.08].map(tau => density / Math.sqrt(tau)) },
    spectrum: { hz: Array.from({ length: 128 }, (_, i) => 0.78 * (i + 1)), density: Array.from({ length: 128 }, (_, i) => density * (1 + 300 / (i + 1) ** 2)) },
  }])),
};
/// As `plumbline doctor --report` writes it.
export function doctor_data({ with_imu = true, with_looks = true } = {}) {
  const t = Array.from({ length: 160 }, (_, i) => round(i / 20)), at = Array.from({ length: 1600 }, (_, i) => round(i / 200)), random = random_of(9);
  const axes = size => Object.fromEntries(['x', 'y', 'z'].map((axis, k) => [axis, at.map(s => round(size * Math.sin((k + 1) * s) + 0.1 * size * random()))]));
  return {
    format: 'plumbline-doctor', version: 1, dataset: 'flight <of a room>',
    diagnoses: [['OK', 'recording', '160 images, 1600 IMU samples: times, rates, units and contents are plausible'], ['NOTE', 'files', 'imu.csv: columns after the last one that is needed are ignored'],
      ['ERROR', 'time offset', 'images and gyroscope turn together where images are taken 110.0 ms earlier than stamped: give --time-offset -0.110'], ['WARN', 'still part', '8 % of the image does not move <while> the camera turns'],
      ['WARN', 'corners', '22 corners are followed from frame to frame: blurred, dark, or little to see?']].map(([level, check, text]) => ({ level, check, text })),
    ...(with_imu ? doctor_noise : { imu_noise: null, noise_series: null }),
    series: {
      images: { intervals: { t: t.slice(1), ms: t.slice(1).map((_, i) => (i === 80 ? 250 : 50)) } },
      imu: with_imu ? { intervals: { t: at.slice(1), ms: at.slice(1).map(() => 5) }, gyroscope: { t: at, ...axes(0.8) }, accelerometer: { t: at, ...axes(6) } } : null,
      looks: with_looks ? { t, brightness: t.map(s => round(110 + 20 * Math.sin(s))), contrast: t.map(() => round(40 + 5 * random())), corners: t.map((_, i) => (i ? Math.round(180 + 30 * random()) : null)) } : null,
    },
  };
}
const picture = row => 'data:image/svg+xml,' + encodeURIComponent(`<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 752 542" width="752" height="542">
<rect width="752" height="542" fill="#222"/><rect width="752" height="480" fill="#777"/><circle cx="${40 + 2.6 * row}" cy="240" r="60" fill="#9b9"/>
<text x="12" y="520" fill="#eee" font-size="24" font-family="sans-serif">frame ${row}</text></svg>`);

/// The page as the program writes it.
export function page_with(page, data, folder = join(dirname(fileURLToPath(import.meta.url)), '..', 'dist')) {
  const html = readFileSync(join(folder, `${page}.html`), 'utf8'), line = 'id="plumbline-data">null<';
  if (html.split(line).length !== 2) throw new Error(`${page}.html has not one place for its data`);
  return html.replace(line, () => `id="plumbline-data">${JSON.stringify(data).replaceAll('<', '\\u003c')}<`);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [page, name, file] = process.argv.slice(2);
  const data = page === 'doctor' ? doctor_data() : page === 'debug' ? { usual: () => debug_data(), map: () => debug_data({ with_map: true }), saved: () => saved_map_data() }[name]() : comparisons[name]();
  writeFileSync(file, page_with(page, data));
}
