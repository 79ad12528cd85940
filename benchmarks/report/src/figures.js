/// Numbers as text, and their statistics. A missing number is null.
export const dash = '–';
export const is_number = value => typeof value === 'number' && Number.isFinite(value);

export function text_of(value, digits = 3) {
  if (value === Infinity) return 'failed';
  if (!is_number(value)) return dash;
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-4) return value.toExponential(1);
  return value.toFixed(Math.max(0, digits - 1 - Math.floor(Math.log10(size))));
}
export const with_unit = (value, unit) => (is_number(value) ? `${text_of(value)} ${unit}` : dash);
/// Rounded down: 99.9 % is not all.
export const percent = value => (is_number(value) ? `${Math.floor(1000 * value + 1e-6) / 10} %` : dash);
export const signed = value => (is_number(value) && value > 0 ? '+' : '') + text_of(value);

const known = values => values.filter(is_number);
export function quantile(values, part) {
  const sorted = Float64Array.from(values.filter(value => is_number(value) || value === Infinity)).sort();
  if (sorted.length === 0) return null;
  const at = part * (sorted.length - 1), low = Math.floor(at), high = Math.ceil(at);
  return sorted[low] === sorted[high] ? sorted[low] : sorted[low] + (at - low) * (sorted[high] - sorted[low]);
}
/// An infinite value is one that failed.
export const median = values => quantile(values, 0.5);
export const largest = values => (values.includes(Infinity) ? [Infinity] : known(values)).reduce((a, b) => (a === null || b > a ? b : a), null);
export const smallest = values => known(values).reduce((a, b) => (a === null || b < a ? b : a), null);
export const mean = values => (known(values).length ? known(values).reduce((a, b) => a + b, 0) / known(values).length : null);
