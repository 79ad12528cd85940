// The page of a debug folder in a browser.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import { launch, launch_flat, open, scroll_through, wait_until_drawn } from './browser.mjs';
import { debug_data, page_with, saved_map_data } from './fixture.mjs';

const folder = mkdtempSync(join(tmpdir(), 'plumbline-debug-'));
const write = (name, data) => {
  const file = join(folder, `${name}.html`);
  writeFileSync(file, page_with('debug', data));
  return file;
};
let browser, flat;
before(async () => { [browser, flat] = [await launch(), await launch_flat()]; });
after(async () => {
  await browser.close();
  await flat.close();
  rmSync(folder, { recursive: true });
});
const titles = page => page.$$eval('h3', all => all.map(node => node.textContent));

describe('a run', () => {
  let page;
  before(async () => { page = await open(browser, write('usual', debug_data())); });
  after(async () => {
    assert.deepEqual(page.complaints, []);
    await page.close();
  });
  const frame = () => page.$eval('#frame', image => /frame (\d+)/.exec(decodeURIComponent(image.src))[1]);

  test('has its title as text, and a chart for everything there is', async () => {
    assert.equal(await page.$eval('h1', node => node.textContent), 'mono-imu/points+lines/window on sample <of a room>');
    await scroll_through(page);
    const expected = ['In space', 'Health', 'Position error [m]', 'Points', 'Lines', 'Innovation of points, expected 1.18 and 2.15 [sigma]', 'Innovation of points [px]', 'Innovation of lines, expected 1.18 and 2.15 [sigma]',
      'Innovation of lines [px]', 'Rotation error [deg]', 'NEES, aligned at the first pose; expected 6', 'Velocity [m/s]', 'Gyroscope bias [rad/s]', 'Its sigma [rad/s]', 'Accelerometer bias [m/s²]', 'Its sigma [m/s²]',
      'Fraction of the time without valid IMU samples', 'Time of a frame [ms]', 'From above'];
    assert.deepEqual(await titles(page), expected);
    assert.equal((await page.$$('.card canvas')).length, expected.length);
  });

  test('goes to a frame by the slider, the arrow keys and a click into a chart', async () => {
    assert.equal(await frame(), '0');
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('ArrowLeft');
    assert.equal(await frame(), '1');
    await page.$eval('#slider', slider => { slider.value = 100; slider.dispatchEvent(new Event('input')); });
    assert.equal(await frame(), '100');
    const over = await page.$('.cards .card:nth-of-type(2) .u-over'), box = await over.boundingBox();
    await page.mouse.click(box.x + 0.75 * box.width, box.y + box.height / 2);
    await wait_until_drawn(page);
    assert.ok(Math.abs(Number(await frame()) - 0.75 * 239) < 2, await frame());
    const shifts = await page.$$eval('.now', all => all.map(node => new DOMMatrix(getComputedStyle(node).transform).e / node.parentNode.clientWidth));
    assert.ok(shifts.length >= 1 && shifts.every(shift => Math.abs(shift - 0.75) < 0.01), `${shifts}`);
    for (let i = 0; i < 70; ++i) await page.keyboard.press('ArrowRight');
    assert.equal(await frame(), '239');
  });
});

describe('a run with a map', () => {
  let page;
  before(async () => { page = await open(browser, write('map', debug_data({ with_map: true }))); });
  after(async () => {
    assert.deepEqual(page.complaints, []);
    await page.close();
  });
  const rows = () => page.$$eval('.counts tr', all => Object.fromEntries(all.map(row => [...row.children].map(cell => cell.textContent))));

  test('has its counts and the errors of its trajectories', async () => {
    await scroll_through(page);
    assert.ok((await titles(page)).includes('Time of the map\'s stages [ms]'));
    const counts = await rows();
    assert.equal(counts.Loops, '3');
    assert.equal(counts['Refused as ambiguous'], '2');
    assert.equal(counts.Relocalizations, '1');
    assert.equal(counts['ATE, odometry'], '0.610 m');
    assert.equal(counts['ATE, final'], '0.0210 m');
  });

  test('draws keyframes, loops, relocalizations and the trajectories, and without what is not chosen', async () => {
    const layers = await page.$$eval('.look .check', all => all.map(node => [node.textContent, node.querySelector('input').checked]));
    assert.deepEqual(layers, [...['truth', 'odometry', 'causal', 'final', 'keyframes', 'loops', 'relocalizations', 'points'].map(name => [name, true]), ['covisibility', false]]);
    const above = () => page.$$eval('.card', all => all.find(node => node.textContent.includes('From above')).querySelector('canvas').toDataURL());
    await page.$$eval('.card', all => all.find(node => node.textContent.includes('From above')).scrollIntoView());
    await wait_until_drawn(page);
    let before = await above();
    for (const [name] of layers) {
      await page.$$eval('.look .check', (all, text) => all.find(node => node.textContent === text).querySelector('input').click(), name);
      await wait_until_drawn(page);
      const after = await above();
      assert.notEqual(after, before, `${name} is not drawn`);
      before = after;
    }
  });
});

describe('a saved map', () => {
  test('shows keyframes, loops, covisibility and points', async () => {
    const page = await open(browser, write('saved', saved_map_data()));
    await scroll_through(page);
    assert.equal(await page.$eval('h1', node => node.textContent), 'house <of a room>.map');
    assert.deepEqual(await titles(page), ['In space', 'From above', 'Map']);
    assert.deepEqual(await page.$$eval('.check', all => all.map(node => node.textContent)), ['keyframes', 'loops', 'points', 'covisibility']);
    assert.match(await page.$eval('.counts', node => node.innerText), /Keyframes\s+24[^]*Worlds\s+2[^]*Loops\s+3[^]*23\.4[^]*8\.00 x 6\.00 x 3\.00/);
    assert.deepEqual(page.complaints, []);
    await page.close();
  });

  test('without keyframes, and on a phone', async () => {
    const empty = await open(flat, write('empty', saved_map_data(0)));
    assert.match(await empty.evaluate(() => document.body.innerText), /There are no keyframes in this map/);
    await empty.close();
    for (const data of [saved_map_data(), debug_data({ with_map: true })]) {
      const page = await open(flat, write('phone_map', data), { width: 390, height: 844, dark: true });
      await scroll_through(page);
      const wide = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
      assert.ok(wide[0] <= wide[1], `${wide}`);
      assert.deepEqual(page.complaints, []);
      await page.close();
    }
  });
});

test('a run without truth and without pictures', async () => {
  const page = await open(flat, write('plain', debug_data({ with_truth: false, with_pictures: false })));
  await scroll_through(page);
  assert.ok(!(await titles(page)).some(title => /error|NEES/.test(title)));
  assert.equal(await page.$('#frame'), null);
  assert.deepEqual(page.complaints, []);
  await page.close();
});

test('a run that never had a pose', async () => {
  const data = { ...debug_data({ frames: 10 }), errors: null, trajectory: { t: [], x: [], y: [], z: [] }, truth: { t: [], x: [], y: [], z: [] } };
  const page = await open(flat, write('none', data));
  await scroll_through(page);
  assert.match(await page.evaluate(() => document.body.innerText), /This run has no trajectory/);
  assert.deepEqual(page.complaints, []);
  await page.close();
});

test('a run on a phone', async () => {
  const page = await open(flat, write('phone', debug_data()), { width: 390, height: 844, dark: true });
  await scroll_through(page);
  const wide = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(wide[0] <= wide[1], `${wide}`);
  assert.deepEqual(page.complaints, []);
  await page.close();
});
