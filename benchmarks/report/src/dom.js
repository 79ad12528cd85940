/// Makes an element: element('button', {class: 'plain', onclick: f}, 'text', other). Text is never read as HTML.
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (name === 'checked' || name === 'value') node[name] = value;
    else if (value !== null && value !== undefined && value !== false) node.setAttribute(name, value === true ? '' : value);
  }
  node.append(...children.flat(Infinity).filter(child => child !== null && child !== undefined && child !== false));
  return node;
}

/// A configuration's name, which breaks at its slashes only.
export function name_of(configuration) {
  const parts = configuration.split('/');
  return parts.map((part, i) => [element('span', { class: 'part' }, part + (i + 1 < parts.length ? '/' : '')), i + 1 < parts.length && element('wbr')]);
}

export function option(value, text, selected) {
  return element('option', { value, selected }, text);
}

export function checkbox(label, checked, onchange) {
  return element('label', { class: 'check' },
    element('input', { type: 'checkbox', checked, onchange: event => onchange(event.target.checked) }), label);
}

export function select(label, entries, value, onchange) {
  return element('label', { class: 'select' }, element('span', {}, label),
    element('select', { onchange: event => onchange(event.target.value) },
      entries.map(([key, text]) => option(key, text, key === value))));
}

/// One of a few, as buttons in a row.
export function choice(label, entries, value, onchange) {
  return element('div', { class: 'choice', role: 'group', 'aria-label': label }, entries.map(([key, text]) =>
    element('button', { type: 'button', 'aria-pressed': String(key === value), onclick: () => onchange(key) }, text)));
}

/// A chart with its title, what can be chosen about it, and a place to draw in.
export function card(title, controls = [], className = '') {
  const place = element('div', { class: 'place' });
  const note = element('p', { class: 'note' });
  const bar = element('div', { class: 'controls' }, controls);
  const node = element('figure', { class: `card ${className}` },
    element('figcaption', {}, element('h3', {}, title), bar), note, place);
  return { node, place, note, bar };
}
