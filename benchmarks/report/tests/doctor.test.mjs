// The page of `plumbline doctor --report` in a browser.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { launch_flat, open, scroll_through } from './browser.mjs';
import { doctor_data, page_with } from './fixture.mjs';

const folder = mkdtempSync(join(tmpdir(), 'plumbline-doctor-'));
let browser;
before(async () => { browser = await launch_flat(); });
after(async () => {
  await browser.close();
  rmSync(folder, { recursive: true });
});
async function opened(name, data, options) {
  const file = join(folder, `${name}.html`);
  writeFileSync(file, page_with('doctor', data));
  const page = await open(browser, file, options);
  await scroll_through(page);
  return page;
}
const texts = (page, selector) => page.$$eval(selector, all => all.map(node => node.textContent));

test('The worst findings come first, in the order of the checks among equals', async () => {
  const page = await opened('usual', doctor_data());
  assert.equal(await page.title(), 'plumbline doctor: flight <of a room>');
  assert.deepEqual(await texts(page, '.level'), ['ERROR', 'WARN', 'WARN', 'NOTE', 'OK']);
  assert.deepEqual(await texts(page, '.findings tbody th'), ['time offset', 'still part', 'corners', 'files', 'recording']);
  assert.equal(await page.$eval('.lead', node => node.textContent), '1 error, 2 warnings, 1 note');
  assert.match((await texts(page, '.findings tbody td:last-child'))[1], /does not move <while> the camera turns/);
  await page.close();
});

test('There is a chart for each sensor, and none for what is not there', async () => {
  const page = await opened('usual', doctor_data());
  assert.deepEqual(await texts(page, 'h3'), ['Time from image to image [ms]', 'Time from IMU sample to IMU sample [ms]', 'Gyroscope [rad/s]', 'Accelerometer [m/s²]',
    'Brightness of the images, 0 to 255', 'Corners followed from the image before', 'Gyroscope in motion: spectrum [rad/s/√Hz]', 'Accelerometer in motion: spectrum [m/s²/√Hz]',
    'Gyroscope at rest: Allan deviation [rad/s]', 'Accelerometer at rest: Allan deviation [m/s²]', 'Noise of the IMU, for a calibration']);
  assert.equal(await page.$$eval('canvas', all => all.length), 10);
  assert.deepEqual((await page.$eval('.paste', node => node.textContent)).split('\n'), ['# by 12.5 s at rest; intervals of 95 %', 'gyroscope_noise_density: 0.000171   # 0.000166 to 0.000176',
    'gyroscope_random_walk: 0.0000210   # 0.0000110 to 0.0000300', 'accelerometer_noise_density: 0.00202   # 0.00197 to 0.00210', '# accelerometer_random_walk: at most 0.000340; more time at rest is needed to tell it']);
  assert.match(await page.$eval('.place', node => node.getAttribute('aria-label')), /in ms\. interval: median 50\.0, largest 250$/);
  assert.deepEqual(page.complaints, []);
  const bare = await opened('bare', doctor_data({ with_imu: false, with_looks: false }));
  assert.deepEqual(await texts(bare, 'h3'), ['Time from image to image [ms]']);
  const empty = doctor_data({ with_imu: false, with_looks: false });
  empty.series.images = null;
  empty.diagnoses = [{ level: 'OK', check: 'recording', text: 'one image' }];
  const none = await opened('none', empty);
  assert.equal(await none.$('canvas'), null);
  assert.equal(await none.$eval('.lead', node => node.textContent), 'nothing wrong');
  for (const each of [bare, none]) assert.deepEqual(each.complaints, []);
  await Promise.all([page, bare, none].map(each => each.close()));
});

test('A phone shows all of it without scrolling sideways, with the dark theme', async () => {
  const page = await opened('narrow', doctor_data(), { width: 390, height: 800, dark: true });
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth));
  assert.deepEqual(page.complaints, []);
  await page.close();
});
