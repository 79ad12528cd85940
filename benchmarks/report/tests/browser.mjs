// A headless Chromium, and a page in it that must not complain and must not ask the network for anything.
import { pathToFileURL } from 'node:url';
import puppeteer from 'puppeteer-core';

export const launch = (flags = []) => puppeteer.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-accelerated-2d-canvas', '--disable-gpu-rasterization', '--force-color-profile=srgb', '--hide-scrollbars', ...flags],
});

/// Drawing in space is slow without a graphics card: most tests do without.
export const launch_flat = () => launch(['--disable-webgl', '--disable-webgl2', '--disable-3d-apis']);

/// Opens a file; `page.complaints` has errors, warnings of the console and all requests but that for the file itself.
export async function open(browser, file, { width = 1400, height = 900, dark = false, scale = 1 } = {}) {
  const page = await browser.newPage(), url = pathToFileURL(file).href;
  page.complaints = [];
  page.on('console', message => {
    if (['error', 'warn'].includes(message.type()) && !message.text().includes('GPU stall due to ReadPixels')) page.complaints.push(`console: ${message.text()}`);
  });
  page.on('pageerror', error => page.complaints.push(`error: ${error.stack}`));
  page.on('request', request => {
    if (request.url() !== url && !request.url().startsWith('data:')) page.complaints.push(`request: ${request.url()}`);
  });
  await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: dark ? 'dark' : 'light' }, { name: 'prefers-reduced-motion', value: 'reduce' }]);
  await page.setViewport({ width, height, deviceScaleFactor: scale, isMobile: width < 500, hasTouch: width < 500 });
  await page.goto(url);
  await wait_until_drawn(page);
  return page;
}

/// Until all requested drawings are done.
export const wait_until_drawn = page => page.evaluate(() => new Promise(done => {
  let frames = 4;
  const next = () => (--frames ? requestAnimationFrame(next) : setTimeout(done, 30));
  requestAnimationFrame(next);
}));

/// Draws what is only drawn when it comes into view.
export async function scroll_through(page) {
  const height = await page.evaluate(() => document.documentElement.scrollHeight);
  for (let y = 0; y < height + 600; y += 600) {
    await page.evaluate(top => window.scrollTo(0, top), y);
    await wait_until_drawn(page);
  }
  await page.evaluate(() => window.scrollTo(0, 0));
  await wait_until_drawn(page);
}
