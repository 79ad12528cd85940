/// Colors that the color-blind can distinguish (tests/palette.test.mjs), on white and on black. A seventh line has the
/// first color again, dashed.
export const light = ['#0045c6', '#e59336', '#0d8555', '#d090be', '#873e01', '#31adff'];
export const dark = ['#3a86f0', '#d8501f', '#1fdc98', '#b8609a', '#fecb2e', '#c0ddf7'];
const dashes = [[], [8, 4], [2, 3]];

export function style_of(slot, is_dark) {
  const colors = is_dark ? dark : light;
  return { color: colors[slot % colors.length], dash: dashes[Math.floor(slot / colors.length) % dashes.length] };
}

/// The first free slot.
export function free_slot(taken) {
  let slot = 0;
  while (taken.includes(slot)) ++slot;
  return slot;
}
