// The page of a comparison in a browser.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, describe, test } from 'node:test';
import { launch, launch_flat, open, scroll_through, wait_until_drawn } from './browser.mjs';
import { comparisons, page_with } from './fixture.mjs';

const folder = mkdtempSync(join(tmpdir(), 'plumbline-report-'));
const data = {}, file = {};
for (const name of Object.keys(comparisons)) {
  data[name] = comparisons[name]();
  file[name] = join(folder, `${name}.html`);
  writeFileSync(file[name], page_with('compare', data[name]));
}
let browser, flat;
before(async () => { [browser, flat] = [await launch(), await launch_flat()]; });
after(async () => {
  await browser.close();
  await flat.close();
  rmSync(folder, { recursive: true });
});

const columns = ['Configuration', 'Data set', 'Runs', 'ATE m', 'worst m', 'Coverage', 'Aligned', 'Causal', 'RPE m', 'RPE deg', 'Scale error', 'Time ms', 'p99 ms', 'Start s', 'Health'];
const dash = '–';

/// Texts of the table: one object for each row, by the names of the columns.
async function table(page) {
  const rows = await page.$$eval('.results tbody tr', all => all.map(row => [...row.children].map((cell, i) => (i === 0 ? cell.querySelector('.open') : cell).textContent)));
  return rows.map(cells => Object.fromEntries(columns.map((name, i) => [name, cells[i]])));
}
const press = async (page, selector, text) => {
  const found = await page.evaluateHandle((all, wanted) => [...document.querySelectorAll(all)].find(node => node.textContent.trim() === wanted), selector, text);
  assert.ok(found.asElement(), `no ${selector} "${text}"`);
  await found.asElement().click();
  await wait_until_drawn(page);
};
const card_of = async (page, title) => (await page.evaluateHandle(wanted => [...document.querySelectorAll('.card')].find(node => node.querySelector('h3')?.textContent === wanted), title)).asElement();
const show = async (page, title) => {
  const card = await card_of(page, title);
  await card.evaluate(node => node.scrollIntoView({ block: 'center' }));
  await wait_until_drawn(page);
  return card;
};
const labels_of = card => card.$$eval('.u-legend .curve .u-label', all => all.map(label => label.textContent));
/// How many colors the canvases of a card show, a measure of whether anything is drawn.
const colors_in = card => card.evaluate(node => {
  const canvas = node.querySelector('canvas'), copy = document.createElement('canvas');
  copy.width = canvas.width;
  copy.height = canvas.height;
  const context = copy.getContext('2d');
  context.drawImage(canvas, 0, 0);
  return new Set(new Uint32Array(context.getImageData(0, 0, copy.width, copy.height).data.buffer)).size;
});
const median = values => {
  const sorted = [...values].sort((a, b) => a - b), half = sorted.length / 2;
  return sorted.length % 2 ? sorted[Math.floor(half)] : (sorted[half - 1] + sorted[half]) / 2;
};
const near = (text, value) => Math.abs(Number(text) - value) <= 0.006 * Math.abs(value);

describe('a usual comparison', () => {
  let page;
  before(async () => { page = await open(browser, file.usual); });
  after(async () => {
    assert.deepEqual(page.complaints, []);
    await page.close();
  });

  test('states its machine, its runs and its failures', async () => {
    const text = await page.$eval('header', node => node.textContent);
    for (const part of ['7 configurations on 3 data sets, 84 runs', '11 failed', 'Example CPU @ 2.50GHz, 2 cores, 23.5 GiB', 'GCC 12.2.0', '2 processes']) assert.ok(text.includes(part), `"${part}" is not in "${text}"`);
  });

  test('has a row for each configuration and data set, with medians over the repeats', async () => {
    const rows = await table(page);
    assert.equal(rows.length, 21);
    for (const row of rows) {
      const runs = data.usual.runs.filter(run => run.configuration === row.Configuration && run.dataset === row['Data set']), ok = runs.filter(run => run.status === 'ok');
      assert.equal(row.Runs, ok.length === runs.length ? `${runs.length}` : `${ok.length} of ${runs.length}`);
      const ates = ok.map(run => run.ate.rmse).filter(value => value !== null);
      while (ok.length && ates.length && ates.length < runs.length) ates.push(Infinity);
      if (ok.length === 0) {
        assert.equal(row['ATE m'], dash);
      } else if (ates.length === 0) {
        assert.deepEqual([row['ATE m'], row['worst m']], [dash, dash]);
      } else if (ates.includes(Infinity)) {
        assert.ok(near(row['ATE m'], median(ates)));
        assert.deepEqual([row['worst m'], row.Coverage], ['failed', '0 %']);
      } else {
        assert.ok(near(row['ATE m'], median(ates)), `${row['ATE m']} is not ${median(ates)}`);
        assert.ok(near(row['worst m'], Math.max(...ates)));
      }
      if (ok.length) assert.ok(near(row['Time ms'], median(ok.map(run => run.time_ms.median))));
    }
  });

  test('shows no ATE without coverage, alignment and causality', async () => {
    const with_ate = (await table(page)).filter(row => /\d/.test(row['ATE m']));
    assert.equal(with_ate.length, 12);
    for (const row of with_ate) {
      assert.match(row.Coverage, /^\d+(\.\d)? %$/);
      assert.match(row.Aligned, /^(se3|sim3|posyaw)$/);
      assert.match(row.Causal, /^(yes|no)$/);
    }
  });

  test('shows failures with their reason, as text', async () => {
    const failures = await page.$$eval('.results .failure', all => all.map(node => node.textContent));
    assert.equal(failures.length, 5);
    assert.ok(failures.includes('failed: no pose in 500 frames: <too little parallax> & few lines'));
    assert.ok(failures.includes('4 runs failed: needs depth images and the calibration\'s depth scale'));
    assert.match(await page.$eval('.failures', node => node.textContent), /5 runs failed on this data set.*mono\/lines\/window 1 of 4: no pose/);
  });

  test('sorts by a click and by the keyboard; what is unknown comes last', async () => {
    await press(page, '.results thead button', 'ATE m');
    const ates = async () => (await table(page)).map(row => row['ATE m']);
    const check = (values, sign) => {
      const numbers = values.filter(value => /\d/.test(value)).map(Number);
      assert.equal(numbers.length, 12);
      assert.ok(values.slice(12).every(value => value === dash));
      for (let i = 1; i < numbers.length; ++i) assert.ok(sign * (numbers[i] - numbers[i - 1]) >= 0, values.join(' '));
    };
    check(await ates(), 1);
    const sorted = () => page.$$eval('.results thead th', all => all.map(head => head.getAttribute('aria-sort')).filter(sort => sort !== 'none'));
    assert.deepEqual(await sorted(), ['ascending']);
    await page.keyboard.press('Enter');
    check(await ates(), -1);
    assert.deepEqual(await sorted(), ['descending']);
    await press(page, '.results thead button', 'worst m');
    const worst = (await table(page)).map(row => row['worst m']);
    assert.deepEqual([worst.indexOf('failed'), worst.lastIndexOf('failed'), worst.indexOf(dash)], [10, 11, 12], 'a failure is worse than any number');
    await press(page, '.results thead button', 'Configuration');
  });

  test('filters by words, data set and failures', async () => {
    await page.type('.search input', 'lines window');
    assert.ok((await table(page)).length === 9 && (await table(page)).every(row => /lines.*window/.test(row.Configuration)));
    await page.select('.filters select', 'sample_car');
    assert.equal((await table(page)).length, 3);
    await page.click('.filters input[type=checkbox]');
    assert.deepEqual((await table(page)).map(row => row.Configuration), ['mono/lines/window']);
    await page.click('.filters input[type=checkbox]');
    await page.select('.filters select', '');
    await page.$eval('.search input', input => { input.value = ''; input.dispatchEvent(new Event('input')); });
    assert.equal((await table(page)).length, 21);
  });

  test('begins with the best configurations of a data set with truth', async () => {
    assert.equal(await page.$eval('#dataset', node => node.textContent), 'On sample_flight');
    const labels = await labels_of(await show(page, 'Position error'));
    assert.deepEqual(labels, ['mono-imu/points/window', 'mono-imu/points+lines/window', 'mono-imu/points+lines/direct', 'mono/points/window']);
  });

  test('draws every chart', async () => {
    for (const title of ['In space', 'From above', 'Position error', 'Time of a frame', 'Features tracked', 'Health', 'Error over the repeats', 'Time over the repeats', 'Repeat by repeat', 'Difference of the position error, B − A']) {
      const card = await show(page, title);
      assert.ok(await card.$('canvas'), `${title} has no canvas`);
      if (title !== 'In space') assert.ok(await colors_in(card) > 8, `${title} is empty`);
    }
    const space = await show(page, 'In space'), tools = await space.$('.tools');
    const shot = async () => {
      await tools.evaluate(node => { node.style.opacity = 0; });
      const picture = Buffer.from(await (await space.$('canvas')).screenshot()).toString('base64');
      await tools.evaluate(node => { node.style.opacity = 1; });
      return picture;
    };
    const first = await shot();
    await press(page, '.tools button', '⟲');
    assert.ok(await shot() !== first, 'turning the view in space changes nothing');
    await press(page, '.tools button', 'Reset');
    assert.ok(await shot() === first, 'the first view does not come back');
    await (await space.$('input[type=checkbox]')).click();
    await wait_until_drawn(page);
    assert.ok(await shot() !== first, 'the truth is not drawn');
    await (await space.$('input[type=checkbox]')).click();
  });

  test('draws the configurations whose boxes are checked, each in one color everywhere', async () => {
    const name = 'mono-imu/points+lines+collinear/window', box = `.list input[data-configuration="${name}"]`;
    await page.focus(box);
    await page.keyboard.press('Space');
    await wait_until_drawn(page);
    assert.ok((await labels_of(await show(page, 'Position error'))).includes(name));
    assert.ok(await page.$eval(box, node => document.activeElement === node), 'the box lost the focus');
    const colors = await page.evaluate(wanted => {
      const color = node => getComputedStyle(node).getPropertyValue('--color');
      return [...document.querySelectorAll('.results tbody tr')].filter(row => row.querySelector('.open').textContent === wanted).map(row => color(row.querySelector('.swatch')))
        .concat([...document.querySelectorAll('.list label')].filter(label => label.textContent.startsWith(wanted)).map(label => color(label.querySelector('.swatch'))));
    }, name);
    assert.equal(colors.length, 4);
    assert.equal(new Set(colors).size, 1);
    const marker = await (await card_of(page, 'Position error')).$$eval('.curve', (rows, wanted) => getComputedStyle(rows.find(row => row.textContent.startsWith(wanted)).querySelector('.u-marker')).backgroundColor, name);
    const [r, g, b] = [1, 3, 5].map(i => parseInt(colors[0].slice(i, i + 2), 16));
    assert.equal(marker, `rgb(${r}, ${g}, ${b})`);
    await page.keyboard.press('Space');
    await wait_until_drawn(page);
    assert.ok(!(await labels_of(await show(page, 'Position error'))).includes(name));
  });

  test('shows the time of each stage, and all stages of one run', async () => {
    const card = await show(page, 'Time of a frame');
    const largest = () => card.$eval('[role=img]', node => /largest ([\d.]+)/.exec(node.getAttribute('aria-label'))[1]);
    const total = await largest();
    await press(page, '.choice button', 'estimate');
    assert.ok(Number(await largest()) < Number(total));
    await (await card.$('select')).select('of mono/points/window');
    await wait_until_drawn(page);
    assert.deepEqual(await labels_of(card), ['total', 'track', 'estimate', 'map']);
    await press(page, '.choice button', 'total');
  });

  test('a click into a chart chooses a time in all of them', async () => {
    const card = await show(page, 'Position error'), over = await card.$('.u-over'), box = await over.boundingBox();
    await page.mouse.click(box.x + box.width / 2, box.y + 60);
    await wait_until_drawn(page);
    const shift = await (await show(page, 'Features tracked')).$eval('.now', node => new DOMMatrix(getComputedStyle(node).transform).e / node.parentNode.clientWidth);
    assert.ok(Math.abs(shift - 0.5) < 0.01, `${shift}`);
  });

  test('goes to another data set, and reports a missing ground truth', async () => {
    await press(page, '.tabs button', 'sample_hand_without_truth');
    assert.equal(await page.$eval('#dataset', node => node.textContent), 'On sample_hand_without_truth');
    const card = await show(page, 'Position error');
    assert.equal(await card.$('canvas'), null);
    assert.match(await card.evaluate(node => node.textContent), /no truth, so there are no errors/);
    assert.ok(await colors_in(await show(page, 'From above')) > 8);
    await press(page, '.open', 'mono-imu/points/window');  // the first such row is that of sample_car
    assert.equal(await page.$eval('#dataset', node => node.textContent), 'On sample_car');
    await press(page, '.tabs button', 'sample_flight');
  });

  test('compares two configurations', async () => {
    const [a, b] = await page.$$('section:last-of-type .filters select');
    await a.select('mono/points/window');
    await wait_until_drawn(page);
    await (await page.$$('section:last-of-type .filters select'))[1].select('mono-imu/points/window');
    await wait_until_drawn(page);
    assert.ok(b);
    const row = name => page.$$eval('.pair tbody tr', (rows, wanted) => [...rows.find(each => each.children[0].textContent === wanted).children].slice(1).map(cell => cell.textContent), name);
    const ate = configuration => median(data.usual.runs.filter(run => run.configuration === configuration && run.dataset === 'sample_flight').map(run => run.ate.rmse));
    const [left, right, change, better] = await row('ATE, median m');
    assert.ok(near(left, ate('mono/points/window')) && near(right, ate('mono-imu/points/window')));
    assert.ok(near(change.split(' ')[0], ate('mono-imu/points/window') - ate('mono/points/window')), change);
    assert.equal(better, 'B');
    assert.deepEqual((await row('Aligned')).slice(0, 2), ['sim3', 'posyaw']);
    for (const name of ['Coverage', 'Causal']) assert.ok((await row(name)).slice(0, 2).every(text => text !== dash));
    assert.match(await (await show(page, 'Repeat by repeat')).evaluate(node => node.textContent), /B has the smaller ATE in 4 of 4 repeats/);
    await press(page, 'button', 'Swap');
    assert.equal((await row('ATE, median m'))[3], 'A');
    assert.match(await (await show(page, 'Repeat by repeat')).evaluate(node => node.textContent), /B has the smaller ATE in 0 of 4 repeats/);
  });

  test('has a name for everything that can be operated or seen', async () => {
    const nameless = await page.evaluate(() => [...document.querySelectorAll('button, input, select, [role=img]')].filter(node =>
      !(node.getAttribute('aria-label') || (node.tagName === 'BUTTON' && node.textContent.trim()) || node.closest('label')?.textContent.trim())).map(node => node.outerHTML.slice(0, 120)));
    assert.deepEqual(nameless, []);
  });

  test('is light or dark as a reader wants it', async () => {
    const background = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const light = await background();
    await press(page, '.theme', 'Theme: auto');
    await press(page, '.theme', 'Theme: light');
    assert.notEqual(await background(), light);
    await press(page, '.theme', 'Theme: dark');
    assert.equal(await background(), light);
  });
});

for (const [name, size] of [['a phone', { width: 390, height: 844, dark: true }], ['a small phone', { width: 320, height: 640 }], ['a tablet', { width: 820, height: 1100 }]])
  test(`fits ${name} without scrolling sideways`, async () => {
    const page = await open(name === 'a phone' ? browser : flat, file.usual, size);
    await scroll_through(page);
    const wide = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
    assert.ok(wide[0] <= wide[1], `${wide}`);
    assert.equal(await page.$eval('.results', node => getComputedStyle(node).display === 'block'), size.width < 700);
    assert.deepEqual(page.complaints, []);
    await page.close();
  });

test('reports missing WebGL, and draws the rest', async () => {
  const page = await open(flat, file.usual);
  assert.match(await (await show(page, 'In space')).evaluate(node => node.textContent), /no WebGL.*The view from above shows the same/);
  assert.ok(await colors_in(await show(page, 'From above')) > 8);
  await scroll_through(page);
  assert.deepEqual(page.complaints, []);
  await page.close();
});

for (const [name, expected] of [['zero', /There are no runs in this comparison/], ['one', /1 configuration on 1 data set, 1 run\./], ['failed', /2 runs failed: needs depth images/]])
  test(`a comparison with ${name}`, async () => {
    const page = await open(flat, file[name]);
    await scroll_through(page);
    assert.match(await page.evaluate(() => document.body.innerText), expected);
    assert.deepEqual(page.complaints, []);
    await page.close();
  });

test('40 configurations x 8 data sets x 8 repeats do not freeze the page', async () => {
  const begin = Date.now(), page = await open(flat, file.large);
  const opened = Date.now() - begin;
  assert.ok(opened < 15000, `opened after ${opened} ms`);
  assert.ok((await page.$$('canvas')).length < 6, 'charts out of view are drawn');
  assert.equal((await page.$$('.results tbody tr')).length, 40);
  await press(page, '.more', 'Show all 320 rows');
  assert.equal((await page.$$('.results tbody tr')).length, 320);
  const timed = async act => {
    const start = Date.now();
    await act();
    return Date.now() - start;
  };
  assert.ok(await timed(() => press(page, '.results thead button', 'ATE m')) < 5000);
  await show(page, 'Position error');
  for (const box of (await page.$$('.list input:not(:checked)')).slice(0, 4)) {
    const name = await box.evaluate(node => node.dataset.configuration);
    const took = await timed(async () => { await page.click(`.list input[data-configuration="${name}"]`); await wait_until_drawn(page); });
    assert.ok(took < 5000, `${took} ms to draw one more`);
  }
  await scroll_through(page);
  assert.deepEqual(page.complaints, []);
  await page.close();
});

test('takes processor times where there are some, and reports what is missing or of another machine', async () => {
  const whole = comparisons.one(), other = join(folder, 'other.html');
  whole.plans = [{ id: 'a', runs: 3 }];
  whole.runs[0].time_ms.cpu_median = 1.25;
  whole.runs.push({ ...whole.runs[0], repeat: 1, machine: { ...whole.machine, cpu: 'Other' }, frame_series: undefined });
  writeFileSync(other, page_with('compare', whole));
  const page = await open(flat, other);
  assert.equal((await table(page))[0]['Time ms'], '1.25');
  assert.match(await page.$eval('header', node => node.textContent), /2 runs, 1 missing\..*Some runs were made on other machines \(2 in all\)/);
  await scroll_through(page);
  assert.deepEqual(page.complaints, []);
  await page.close();
});

test('runs with a map are rows of their own, with their loops and the error of the final poses', async () => {
  const data = comparisons.map(), mapped = join(folder, 'mapped.html');
  writeFileSync(mapped, page_with('compare', data));
  const page = await open(flat, mapped);
  const heads = await page.$$eval('.results thead th', all => all.map(node => node.textContent));
  assert.deepEqual(heads, [...columns.slice(0, 5), 'Loops', 'ATE final m', ...columns.slice(5)]);
  const rows = await page.$$eval('.results tbody tr', all => all.map(row => [...row.children].map((cell, i) => (i === 0 ? cell.querySelector('.open') : cell).textContent)));
  assert.deepEqual(rows.map(row => row[0]).sort(), ['mono-imu/points/window', 'mono-imu/points/window --map', 'rgbd/points/window --map']);
  for (const row of rows) {
    const runs = data.runs.filter(run => (run.with_map ? `${run.configuration} --map` : run.configuration) === row[0]), has_map = row[0].endsWith('--map');
    assert.equal(row[2], '2');
    if (has_map) assert.ok(near(row[5], 3.5) && near(row[6], median(runs.map(run => run.ate_final.rmse))), row.join(' '));
    else assert.deepEqual(row.slice(5, 7), [dash, dash]);
    assert.ok(near(row[3], median(runs.map(run => run.ate.rmse))));
  }
  await scroll_through(page);
  assert.deepEqual(page.complaints, []);
  await page.close();
});
