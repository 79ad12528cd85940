/// Colours that the colour-blind can tell apart (after Okabe and Ito), on white and on black. A seventh line has the
/// first colour again, dashed.
export const light = ['#0072b2', '#d55e00', '#009e73', '#b8529a', '#b58900', '#56b4e9'];
export const dark = ['#3f9bea', '#ff7a33', '#1fc796', '#e08cc4', '#e8c43a', '#a6dcff'];
const dashes = [[], [8, 4], [2, 3]];

export function style_of(slot, is_dark) {
  const colors = is_dark ? dark : light;
  return { color: colors[slot % colors.length], dash: dashes[Math.floor(slot / colors.length) % dashes.length] };
}

/// The first slots that nobody has.
export function free_slot(taken) {
  let slot = 0;
  while (taken.includes(slot)) ++slot;
  return slot;
}

/// Of the time of a frame; the order is that in which the estimator does them.
export const stages = ['track', 'estimate', 'map'];
