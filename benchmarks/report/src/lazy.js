/// Draws what is in view, and the remainder when it is scrolled into view. `draw` returns the function that removes it.
export class Lazy {
  constructor(node, draw) {
    this.draw = draw;
    this.clear = null;
    this.is_stale = true;
    this.is_visible = false;
    new IntersectionObserver(entries => {
      this.is_visible = entries[entries.length - 1].isIntersecting;
      this.update();
    }, { rootMargin: '150px' }).observe(node);
  }

  invalidate() {
    this.is_stale = true;
    this.update();
  }

  update() {
    if (!this.is_visible || !this.is_stale) return;
    this.is_stale = false;
    this.clear?.();
    this.clear = this.draw() ?? null;
  }
}
