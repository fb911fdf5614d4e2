// The views of what is stored: runs, sensors, nights. Tables come from the store; reports, comparisons and trends are the
// documents that the command line writes, in a frame.
import { ask } from './link.js';

const view = () => document.getElementById('view-store');

// An element with attributes and children; texts are texts, whatever they hold.
function h(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, '');
    else if (value !== false && value != null) node.setAttribute(name, value);
  }
  node.append(...children.flat().filter((child) => child != null));
  return node;
}

function verdictClass(verdict) {
  if (/conditional|inconclusive/.test(verdict)) return 'doubt';
  return verdict.includes('pass') ? 'good' : verdict.includes('fail') ? 'bad' : '';
}

const names = (run) => run.recipes.map((recipe) => recipe.name).join(', ');
const head = (words) => h('thead', {}, h('tr', {}, words.map((word) => h('th', { scope: 'col' }, word))));

function runRow(run, chosen, changed) {
  const box = h('input', { type: 'checkbox', 'aria-label': `compare run ${run.run}`, onchange: (event) => {
    if (event.target.checked) chosen.add(run.run); else chosen.delete(run.run);
    changed();
  } });
  box.checked = chosen.has(run.run);
  return h('tr', {}, h('td', {}, box), h('td', { class: 'n' }, h('a', { href: `#/run/${run.run}` }, String(run.run))),
    h('td', {}, run.started_utc.replace('T', ' ').replace('Z', '')), h('td', { class: 'wrap' }, run.sensor), h('td', { class: 'wrap' }, names(run)),
    h('td', { class: run.outcome === 'completed' ? '' : 'doubt' }, run.outcome + (run.void ? ', VOID' : '') + (run.lives ? ' (under way)' : '')),
    h('td', { class: 'n' }, String(run.frames)), h('td', { class: verdictClass(run.verdict) }, run.verdict), h('td', {}, run.origin),
    h('td', { class: 'wrap' }, [run.purpose, ...run.tags.map((tag) => `[${tag}]`)].filter(Boolean).join(' ')));
}

const columns = ['compare', 'run', 'started (UTC)', 'sensor', 'recipes', 'outcome', 'frames', 'verdict', 'origin', 'purpose'];
const fits = (run, words) => words.every((word) => `run ${run.run} ${run.started_utc} ${run.sensor} ${names(run)} ${run.outcome} ${run.verdict} ${run.origin} ${run.operator} ${run.purpose} ${run.tags.join(' ')}`.toLowerCase().includes(word));

async function runs(filter) {
  const { runs: all, left_out: leftOut } = await ask('/runs');
  const chosen = new Set();
  const body = h('tbody');
  const compare = h('button', { disabled: true, onclick: () => { location.hash = `#/compare/${[...chosen].sort((a, b) => a - b).join('/')}`; } }, 'Compare two runs');
  const search = h('input', { type: 'search', 'aria-label': 'Filter the runs', placeholder: 'filter: sensor, recipe, verdict, date …', value: filter || '', oninput: () => fill() });
  const count = h('span', { class: 'muted', role: 'status' });
  const changed = () => { compare.disabled = chosen.size !== 2; };
  function fill() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const shown = all.filter((run) => fits(run, words));
    body.replaceChildren(...shown.map((run) => runRow(run, chosen, changed)));
    count.textContent = `${shown.length} of ${all.length} runs${leftOut ? `, ${leftOut} older ones are not listed` : ''}`;
  }
  fill();
  return [h('h1', {}, 'Runs'), h('div', { class: 'tools' }, search, compare, count),
    all.length ? h('div', { class: 'card wide', tabindex: '0', role: 'region', 'aria-label': 'Table of runs' }, h('table', {}, head(columns), body)) : h('p', {}, 'There is no run in this store yet.')];
}

// The document's frame, when the program has made it; its words where it cannot.
function frame(path, title) {
  const box = h('div', {}, h('p', { class: 'muted', role: 'status' }, `${title}: is being made…`));
  ask(path).then(({ path: made }) => box.replaceChildren(h('iframe', { src: made, title, referrerpolicy: 'no-referrer' })))
    .catch((error) => box.replaceChildren(h('p', { class: 'notice' }, error.message)));
  return box;
}

const fact = (name, value) => h('div', {}, h('dt', {}, name), h('dd', {}, value || '–'));

async function run(number) {
  const { runs: all } = await ask('/runs');
  const one = all.find((other) => other.run === Number(number));
  if (!one) return [h('h1', {}, `Run ${number}`), h('p', { class: 'notice' }, 'It is not among the newest runs of this store.')];
  return [h('p', { class: 'muted' }, h('a', { href: '#/runs' }, 'Runs'), ' / '), h('h1', {}, `Run ${one.run}`),
    h('dl', { class: 'facts card' }, fact('sensor', h('a', { href: `#/sensor/${encodeURIComponent(one.sensor)}` }, one.sensor)), fact('recipes', names(one)), fact('operator', one.operator),
      fact('started (UTC)', one.started_utc), fact('outcome', `${one.outcome}${one.void ? ', VOID' : ''}: ${one.reason}`), fact('safe state', one.safe_state),
      fact('frames', String(one.frames)), fact('verdict', h('span', { class: verdictClass(one.verdict) }, one.verdict)), fact('origin', one.origin), fact('purpose', one.purpose)),
    one.fitted ? null : h('p', { class: 'notice' }, `This run has no models: its report shows what was measured. tactbench fit ${one.run} makes models.`),
    h('h2', {}, 'Report'), one.frames > 0 ? frame(`/make/report?run=${one.run}`, `Report of run ${one.run}`) : h('p', {}, 'It has no frame to report on.')];
}

async function compare(first, second) {
  return [h('p', { class: 'muted' }, h('a', { href: '#/runs' }, 'Runs'), ' / '), h('h1', {}, `Runs ${first} and ${second}`),
    frame(`/make/compare?run=${first}&with=${second}`, `Comparison of runs ${first} and ${second}`)];
}

async function sensors() {
  const { sensors: all } = await ask('/sensors');
  const body = h('tbody', {}, all.map((sensor) => h('tr', {}, h('td', { class: 'wrap' }, h('a', { href: `#/sensor/${encodeURIComponent(sensor.serial)}` }, sensor.serial)),
    h('td', { class: 'wrap' }, sensor.type), h('td', { class: 'wrap' }, sensor.scanner || 'any'), h('td', { class: 'n' }, String(sensor.runs.length)),
    h('td', {}, sensor.runs.length ? h('a', { href: `#/run/${sensor.runs[0]}` }, `run ${sensor.runs[0]}`) : '–'), h('td', { class: 'wrap' }, sensor.note))));
  return [h('h1', {}, 'Sensors'), all.length ? h('div', { class: 'card wide', tabindex: '0', role: 'region', 'aria-label': 'Table of sensors' }, h('table', {}, head(['serial', 'type', 'scanner', 'runs', 'newest', 'note']), body))
    : h('p', {}, 'No sensor is registered in this store.')];
}

async function sensor(serial) {
  const [{ sensors: all }, { runs: history }] = await Promise.all([ask('/sensors'), ask('/runs')]);
  const one = all.find((other) => other.serial === serial);
  if (!one) return [h('h1', {}, serial), h('p', { class: 'notice' }, 'It is not registered in this store.')];
  const rows = history.filter((run) => run.sensor === serial).map((run) => h('tr', {}, h('td', { class: 'n' }, h('a', { href: `#/run/${run.run}` }, String(run.run))),
    h('td', {}, run.started_utc.replace('T', ' ').replace('Z', '')), h('td', { class: 'wrap' }, names(run)), h('td', {}, run.outcome + (run.void ? ', VOID' : '')), h('td', { class: verdictClass(run.verdict) }, run.verdict), h('td', { class: 'wrap' }, run.purpose)));
  return [h('p', { class: 'muted' }, h('a', { href: '#/sensors' }, 'Sensors'), ' / '), h('h1', {}, serial), h('p', { class: 'muted' }, [one.type, one.note].filter(Boolean).join(' · ')),
    h('h2', {}, 'History'), h('div', { class: 'card wide', tabindex: '0', role: 'region', 'aria-label': 'Runs of this sensor' }, h('table', {}, head(['run', 'started (UTC)', 'recipes', 'outcome', 'verdict', 'purpose']), h('tbody', {}, rows))),
    h('h2', {}, 'Trend'), one.figures ? frame(`/make/sensor?serial=${encodeURIComponent(serial)}`, `Figures of ${serial} over time`) : h('p', {}, 'No figures of it are kept yet: tactbench fit keeps them.')];
}

async function night(hello) {
  const { subjects } = await ask('/nights');
  const out = [h('h1', {}, 'Night')];
  if (hello.night) out.push(h('h2', {}, 'The last night'), frame('/make/night', 'The night’s table'));
  if (subjects.length) out.push(h('h2', {}, `Figures over the nights, ${subjects.length} scenarios`), frame('/make/nights', 'Figures over the nights'));
  if (out.length === 1) out.push(h('p', {}, 'This store keeps no nights. '), h('p', { class: 'muted' }, 'tactbench nightly SUITE --db nights.db --html night.html keeps one; then: tactbench page --db nights.db --night night.html'));
  return out;
}

const places = { runs, run, compare, sensors, sensor, night };
let shown = 0;

// The view of a place such as ["run", "5"].
export async function show(place, hello) {
  const mine = ++shown;
  view().replaceChildren(h('p', { class: 'muted' }, 'Reading the store…'));
  let content;
  try {
    content = place[0] === 'night' ? await night(hello) : await places[place[0]](...place.slice(1));
  } catch (error) {
    content = [h('h1', {}, 'The store does not answer'), h('p', { class: 'notice' }, error.message)];
  }
  if (mine === shown) view().replaceChildren(...content.filter(Boolean));
}

export const leave = () => { shown += 1; view().replaceChildren(); };
export const isPlace = (name) => Object.hasOwn(places, name);
