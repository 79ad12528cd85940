// The page of `plumbline live --page`, with a server in the place of the program.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { launch, launch_flat, wait_until_drawn } from './browser.mjs';
import { corrected, moved } from '../src/corrected.js';

const html = await readFile(join(dirname(fileURLToPath(import.meta.url)), '../dist/live.html'), 'utf8');
const page_text = html.replace('id="plumbline-data">null<', 'id="plumbline-data">{"title":"plumbline live: x","has_imu":true}<');
const asked = [], asked_map = [];
let poses = 0, part = 0, map = null, browser, server;

function answer(url) {
  asked.push(url.search);
  const from = Number(url.searchParams.get('part')) === part ? Number(url.searchParams.get('from')) : 0;
  const rows = Array.from({ length: poses - from }, (_, i) => from + i);
  return { part, from, frames: poses, dropped: 2, health: 'tracking', reason: 'none', total_ms: 3.25, is_over: false, is_all: true, has_map: map !== null,
    t: rows.map(i => 0.05 * i), x: rows.map(i => Math.cos(0.1 * i)), y: rows.map(i => Math.sin(0.1 * i)), z: rows.map(() => 1),
    ...(map && { world: rows.map(i => [Math.cos(0.1 * i), Math.sin(0.1 * i), 1]) }) };
}

/// A keyframe at each tenth pose; a loop has moved them up by `rise`.
function map_of({ version, keyframes, rise = 0, loops = [], lines = [] }) {
  const all = Array.from({ length: keyframes }, (_, i) => i);
  return { version, map: {
    counts: { keyframes, loops: loops.length, corrections: loops.length }, loops, lines, points: all.map(i => [2 * Math.cos(i), 2 * Math.sin(i), rise]),
    keyframes: { t: all.map(i => 0.5 * i), x: all.map(i => Math.cos(i)), y: all.map(i => Math.sin(i)), z: all.map(() => 1 + rise), world: all.map(() => 0) },
    corrections: { t: all.map(i => 0.5 * i), S_map_world: all.map(() => [1, 0, 0, 0, 1, 0, 0, rise]) },
    relocalizations: { t: [0.5], world: [[1, 0, 1]] },
  } };
}
function answer_map(url) {
  asked_map.push(url.search);
  return Number(url.searchParams.get('version')) === map.version ? { version: map.version } : map;
}
async function serve() {
  const made = createServer((request, response) => {
    const url = new URL(request.url, 'http://127.0.0.1');
    response.setHeader('Content-Type', url.pathname === '/' ? 'text/html' : 'application/json');
    response.end(url.pathname === '/' ? page_text : JSON.stringify(url.pathname === '/map' ? answer_map(url) : answer(url)));
  });
  await new Promise(done => made.listen(0, '127.0.0.1', done));
  return made;
}

before(async () => {
  browser = await launch_flat();
  server = await serve();
});
after(async () => {
  await browser.close();
  server.closeAllConnections();
  server.close();
});

test('The trajectory grows, and is read anew where poses were left out', async () => {
  const page = await browser.newPage(), complaints = [];
  page.on('pageerror', error => complaints.push(error.stack));
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  assert.equal(await page.title(), 'plumbline live: x');
  await page.waitForFunction(() => document.getElementById('state').textContent.startsWith('tracking; 0 frames, 2 dropped'));
  assert.equal(await page.$('canvas'), null);
  poses = 40;
  await page.waitForFunction(() => document.getElementById('state').textContent.includes('40 frames'));
  await page.waitForSelector('canvas');
  poses = 60;
  await page.waitForFunction(() => document.getElementById('state').textContent.includes('60 frames'));
  await page.waitForFunction(() => document.querySelectorAll('canvas').length === 1);
  part = 1;
  poses = 30;
  await page.waitForFunction(() => document.getElementById('state').textContent.includes('30 frames'));
  poses = 31;
  await page.waitForFunction(() => document.getElementById('state').textContent.includes('31 frames'));
  for (const expected of ['?from=0&part=0', '?from=40&part=0', '?from=60&part=0', '?from=30&part=1']) assert.ok(asked.includes(expected), expected);
  server.closeAllConnections();
  await new Promise(done => server.close(done));
  await page.waitForFunction(() => document.getElementById('state').textContent.endsWith('the run is over'));
  assert.deepEqual(complaints, []);
});

test('The map grows, layers appear as there is something to draw, and stay as they were chosen', async () => {
  poses = part = 0;
  map = { version: 0 };
  server = await serve();
  const in_space = await launch();
  try {
    for (const [width, height] of [[1400, 900], [390, 844]]) {
      const page = await in_space.newPage(), complaints = [];
      page.on('pageerror', error => complaints.push(error.stack));
      await page.setViewport({ width, height, isMobile: width < 500, hasTouch: width < 500 });
      const layers = () => page.$$eval('.check', all => all.map(node => [node.textContent, node.querySelector('input').checked]));
      const figure = name => page.$$eval('.counts tr', (rows, key) => rows.find(row => row.cells[0].textContent === key)?.cells[1].textContent, name);
      [poses, map] = [0, { version: 0 }];
      await page.goto(`http://127.0.0.1:${server.address().port}/`);
      await page.waitForFunction(() => document.getElementById('state').textContent.includes('0 frames'));
      assert.equal(await page.$('canvas'), null);
      [poses, map] = [40, map_of({ version: 1, keyframes: 4 })];
      await page.waitForSelector('.counts');
      assert.equal(await figure('Keyframes'), '4');
      assert.deepEqual(await layers(), [['causal', false], ['corrected', true], ['keyframes', true], ['relocalizations', true], ['points', true]]);
      await page.$$eval('.check input', inputs => { inputs[4].checked = false; inputs[4].dispatchEvent(new Event('change')); });
      [poses, map] = [60, map_of({ version: 2, keyframes: 6, rise: 0.5, loops: [[0, 5]], lines: [[0, 0, 0, 1, 1, 1]] })];
      await page.waitForFunction(() => [...document.querySelectorAll('.check')].some(node => node.textContent === 'loops'));
      assert.equal(await figure('Loops'), '1');
      assert.deepEqual(await layers(), [['causal', false], ['corrected', true], ['keyframes', true], ['loops', true], ['relocalizations', true], ['points', false], ['lines', true]]);
      assert.ok(asked_map.includes('?version=0') && asked_map.includes('?version=1'));
      await wait_until_drawn(page);
      assert.equal(await page.$$eval('.card canvas', all => all.length), 2);
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth), `${width} px: wider than the page`);
      assert.deepEqual(complaints, []);
      await page.close();
    }
  } finally {
    await in_space.close();
  }
});

test('A pose has the correction of the latest keyframe before it', () => {
  const half = Math.SQRT1_2, close = (found, expected) => found.forEach((value, k) => assert.ok(Math.abs(value - expected[k]) < 1e-12, `${found}`));
  close(moved([2, 0, 0, half, half, 1, 0, 0], [1, 0, 3]), [1, 2, 6]);  // a quarter about z
  close(moved([1, half, 0, 0, half, 0, 0, 0], [0, 1, 0]), [0, 0, 1]);
  close(moved([1, 0, half, 0, half, 0, 0, 0], [0, 0, 1]), [1, 0, 0]);
  const identity = [1, 0, 0, 0, 1, 0, 0, 0], shifted = [1, 0, 0, 0, 1, 10, 0, 0], world = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]];
  const path = corrected({ t: [0, 1, 2, 3], world }, { t: [1, 2], S_map_world: [identity, shifted] });
  assert.deepEqual(path.x, [0, 1, 12, 13]);
  assert.deepEqual(corrected({ t: [0, 1, 2, 3], world }, { t: [], S_map_world: [] }).x, [0, 1, 2, 3]);
});
