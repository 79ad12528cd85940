// The page of `plumbline live --page`, with a server in the place of the program.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { launch_flat } from './browser.mjs';

const html = await readFile(join(dirname(fileURLToPath(import.meta.url)), '../dist/live.html'), 'utf8');
const page_text = html.replace('id="plumbline-data">null<', 'id="plumbline-data">{"title":"plumbline live: x","has_imu":true}<');
const asked = [];
let poses = 0, part = 0, browser, server;

function answer(url) {
  asked.push(url.search);
  const from = Number(url.searchParams.get('part')) === part ? Number(url.searchParams.get('from')) : 0;
  const rows = Array.from({ length: poses - from }, (_, i) => from + i);
  return { part, from, frames: poses, dropped: 2, health: 'tracking', reason: 'none', total_ms: 3.25, is_over: false,
    t: rows.map(i => 0.05 * i), x: rows.map(i => Math.cos(0.1 * i)), y: rows.map(i => Math.sin(0.1 * i)), z: rows.map(() => 1) };
}

before(async () => {
  browser = await launch_flat();
  server = createServer((request, response) => {
    const url = new URL(request.url, 'http://127.0.0.1');
    response.setHeader('Content-Type', url.pathname === '/' ? 'text/html' : 'application/json');
    response.end(url.pathname === '/' ? page_text : JSON.stringify(answer(url)));
  });
  await new Promise(done => server.listen(0, '127.0.0.1', done));
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
