// Colors differ for those who do not see red, green or blue as others do, and from the page behind them.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { dark, free_slot, light, style_of } from '../src/palette.js';

const linear = hex => [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16) / 255).map(c => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
const times = (M, v) => M.map(row => row.reduce((sum, m, i) => sum + m * v[i], 0));
// Machado, Oliveira, Fernandes 2009, complete deficiency.
const eyes = {
  normal: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  protanopia: [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
  deuteranopia: [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
  tritanopia: [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]],
};
function lab(rgb) {
  const [x, y, z] = times([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]], rgb.map(c => Math.min(Math.max(c, 0), 1)));
  const [fx, fy, fz] = [x / 0.95047, y, z / 1.08883].map(t => (t > 0.008856 ? Math.cbrt(t) : 7.787 * t + 16 / 116));
  return [116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)];
}
const difference = (a, b, eye) => Math.hypot(...lab(times(eyes[eye], linear(a))).map((value, i) => value - lab(times(eyes[eye], linear(b)))[i]));
const luminance = hex => times([[0.2126, 0.7152, 0.0722]], linear(hex))[0];
const contrast = (a, b) => (Math.max(luminance(a), luminance(b)) + 0.05) / (Math.min(luminance(a), luminance(b)) + 0.05);

for (const [name, colors, page] of [['light', light, '#ffffff'], ['dark', dark, '#1b1821']]) {
  for (const eye of Object.keys(eyes))
    test(`${name} colors differ, ${eye}`, () => {
      for (let i = 0; i < colors.length; ++i)
        for (let j = 0; j < i; ++j) assert.ok(difference(colors[i], colors[j], eye) > 20, `${colors[i]} and ${colors[j]}: ${difference(colors[i], colors[j], eye).toFixed(1)}`);
    });
  test(`${name} colors stand out from the page`, () => {
    for (const color of colors) assert.ok(contrast(color, page) > 2, `${color}: ${contrast(color, page).toFixed(2)}`);
  });
}

test('a line beyond the colors differs by its dashes', () => {
  const styles = Array.from({ length: 18 }, (_, slot) => JSON.stringify(style_of(slot, false)));
  assert.equal(new Set(styles).size, 18);
});

test('a color that was given up is the next to be given', () => {
  assert.equal(free_slot([]), 0);
  assert.equal(free_slot([0, 2, 3]), 1);
});
