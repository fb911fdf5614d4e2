// What the first view has seen, and how values become text and elements.
export const $ = (id) => document.getElementById(id);

export const now = {
  hello: { operator: '', commands: false, night: false }, state: null, readings: null, picture: null, volts: [], psi: null,
  trace: [], taxel: -1, compensated: false, top: 0, topRun: 0,
  loop: null, before: null, // {run, taxel, last, axis, t, set, x, y}
  loopAsked: 0, asking: false, answered: 0, sent: 0, dirty: { trace: true, picture: true, loop: true }, came: 0,
};

export const put = (node, text) => { if (node.textContent !== text) node.textContent = text; };
// Children made anew only where `key` is another one than before: a screen reader is not disturbed.
export function renew(node, key, make) {
  const text = JSON.stringify(key);
  if (node.dataset.shown === text) return;
  node.dataset.shown = text;
  node.replaceChildren(...[make()].flat());
}
export const number = (value, digits) => (value == null ? '–' : value.toFixed(digits));

// An element with attributes and children; texts are texts, whatever they hold.
export function h(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, '');
    else if (value !== false && value != null) node.setAttribute(name, value);
  }
  node.append(...children.flat(9).filter((child) => child != null && child !== ''));
  return node;
}

export const line = (colour) => h('i', { class: `of-${colour}` });
export const reading = (name, value, unit, colour) => h('div', {}, h('dt', {}, colour ? line(colour) : null, name), h('dd', {}, value, h('small', {}, ` ${unit}`)));

// verdict: {word, of_means, models_of, decided}, or null.
const kindOf = (word) => (/conditional|inconclusive/.test(word) ? 'doubt' : word.includes('pass') ? 'good' : 'bad');
const signOf = (word) => ({ good: '✓', bad: '✗', doubt: '▲' }[kindOf(word)]);
export const badge = (verdict) => (verdict ? h('span', { class: `badge ${kindOf(verdict.word)}` }, `${signOf(verdict.word)} ${verdict.word}`) : '–');
export function largeVerdict(verdict, origin) {
  const { word, of_means: means, models_of: models, decided } = verdict;
  return [
    h('p', { class: `large ${kindOf(word)}${word.length > 4 ? ' long' : ''}` }, h('span', {}, `${signOf(word)} ${word.toUpperCase()}`), origin === 'simulated' ? h('small', {}, 'simulated') : ''),
    h('p', {}, `${decided[0].toUpperCase()}${decided.slice(1)}${means ? '. Judged by mean errors only' : ''}. `, models ? h('a', { href: `#/run/${models}` }, `Report of run ${models}`) : ''),
  ];
}
