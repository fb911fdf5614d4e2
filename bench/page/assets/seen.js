// What the first view has seen, and how values become text.
export const $ = (id) => document.getElementById(id);

export const now = {
  hello: { operator: '', commands: false }, state: null, readings: null, picture: null, counts: [], psi: null,
  trace: [], taxel: -1, compensated: false, top: 0, topRun: 0,
  loop: null, before: null, // {run, taxel, last, x, y}
  loopAsked: 0, asking: false, answered: 0, sent: 0, dirty: { trace: true, picture: true, loop: true }, came: 0,
};

export const put = (node, text) => { if (node.textContent !== text) node.textContent = text; };
export const number = (value, digits) => (value == null ? '–' : value.toFixed(digits));

export function numbers(base64) {
  const text = atob(base64);
  const out = new Array(text.length / 2);
  for (let i = 0; i < out.length; i += 1) out[i] = text.charCodeAt(2 * i) + 256 * text.charCodeAt(2 * i + 1);
  return out;
}

export function reading(name, value, unit, colour) {
  const box = document.createElement('div');
  const dt = document.createElement('dt');
  if (colour) {
    const line = document.createElement('i');
    line.className = `of-${colour}`;
    dt.append(line);
  }
  dt.append(name);
  const dd = document.createElement('dd');
  const small = document.createElement('small');
  small.textContent = ` ${unit}`;
  dd.append(value, small);
  box.append(dt, dd);
  return box;
}
