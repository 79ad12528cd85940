/// The user's choice: configurations with a color each, and a data set. Views subscribe to it.
import { free_slot, style_of } from './palette.js';
import { is_dark, on_theme } from './theme.js';

export class Store {
  constructor() {
    this.chosen = new Map();  // configuration -> slot of the palette
    this.dataset = null;
    this.listeners = [];
    this.is_pending = false;
    on_theme(() => this.notify());
  }
  subscribe(listener) { this.listeners.push(listener); }
  notify() {
    if (this.is_pending) return;
    this.is_pending = true;
    requestAnimationFrame(() => {
      this.is_pending = false;
      for (const listener of this.listeners) listener();
    });
  }

  choose(configuration, is_chosen) {
    if (is_chosen && !this.chosen.has(configuration)) this.chosen.set(configuration, free_slot([...this.chosen.values()]));
    if (!is_chosen) this.chosen.delete(configuration);
    this.notify();
  }
  open(dataset) {
    this.dataset = dataset;
    this.notify();
  }
  style_of(configuration) {
    return this.chosen.has(configuration) ? style_of(this.chosen.get(configuration), is_dark()) : null;
  }
}
