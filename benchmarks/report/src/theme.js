/// Light or dark: that of the system until the user chooses. Code that draws with colors subscribes to changes.
import { element } from './dom.js';

const key = 'plumbline-theme', modes = ['auto', 'light', 'dark'];
const system = window.matchMedia('(prefers-color-scheme: dark)');
const listeners = [];
let mode = 'auto';
try {
  if (modes.includes(localStorage.getItem(key))) mode = localStorage.getItem(key);
} catch { /* a page from the file system may have no storage */ }

export const is_dark = () => (mode === 'auto' ? system.matches : mode === 'dark');
export const on_theme = listener => listeners.push(listener);

function apply() {
  document.documentElement.dataset.theme = is_dark() ? 'dark' : 'light';
  for (const listener of listeners) listener();
}
system.addEventListener('change', apply);
apply();

export function theme_button() {
  const text = () => ({ auto: 'Theme: auto', light: 'Theme: light', dark: 'Theme: dark' }[mode]);
  const button = element('button', { type: 'button', class: 'theme', onclick: () => {
    mode = modes[(modes.indexOf(mode) + 1) % modes.length];
    try { localStorage.setItem(key, mode); } catch { /* as above */ }
    button.textContent = text();
    apply();
  } }, text());
  return button;
}

/// A color of style.css.
export const css_color = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
