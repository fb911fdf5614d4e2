// The views of what is stored: runs, sensors, nights. Tables come from the store; reports, comparisons and trends are the
// documents that the command line writes, in a frame.
import { ask } from './link.js';
import { $, badge, h, largeVerdict, now } from './seen.js';

const view = () => $('view-store');
function names({ recipes }) {
  const times = new Map();
  for (const { name } of recipes) times.set(name, (times.get(name) || 0) + 1);
  return [...times].map(([name, n]) => (n > 1 ? `${name} × ${n}` : name)).join(', ');
}
const minute = (utc) => utc.slice(0, 16).replace('T', ' ');
const link = (...place) => `#/${place.map(encodeURIComponent).join('/')}`;
const title = (words, place, under) => [place ? h('p', { class: 'muted' }, h('a', { href: `#/${place.toLowerCase()}` }, place), ' / ') : '', h('h1', {}, words), under ? h('p', { class: 'muted' }, under) : ''];
const more = { class: 'more' }; // not on a phone
const small = (text) => (text ? h('small', { class: 'muted' }, text) : '');

function table(label, columns, rows) {
  return h('div', { class: 'card wide', tabindex: '0', role: 'region', 'aria-label': label },
    h('table', {}, h('thead', {}, h('tr', {}, columns.map(([word, attributes]) => h('th', { scope: 'col', ...attributes }, word)))), rows));
}

const runColumns = [['verdict'], ['run'], ['started (UTC)'], ['sensor, recipes'], ['outcome'], ['frames', more], ['purpose', more]];
const runRow = (run, box) => h('tr', {}, h('td', {}, badge(run.verdict)), h('td', {}, h('a', { href: link('run', run.run) }, String(run.run))),
  h('td', {}, minute(run.started_utc)), h('td', { class: 'wrap' }, run.sensor, small(names(run))),
  h('td', { class: run.outcome === 'completed' && !run.void ? '' : 'doubt' }, run.outcome + (run.void ? ', VOID' : '') + (run.lives ? ' (under way)' : ''), small(run.origin)),
  h('td', { class: 'n more' }, String(run.frames)), h('td', { class: 'wrap more' }, [run.purpose, ...run.tags.map((tag) => `[${tag}]`)].filter(Boolean).join(' ')), box ? h('td', more, box) : '');

const fits = (run, words) => words.every((word) => `run ${run.run} ${run.started_utc} ${run.sensor} ${names(run)} ${run.outcome} ${run.verdict ? run.verdict.word : ''} ${run.origin} ${run.operator} ${run.purpose} ${run.tags.join(' ')}`.toLowerCase().includes(word));

async function runs(filter) {
  const { runs: all, left_out: leftOut } = await ask('/runs');
  const chosen = new Set();
  const body = h('tbody');
  const compare = h('button', { ...more, disabled: true, onclick: () => { location.hash = link('compare', ...[...chosen].sort((a, b) => a - b)); } }, 'Compare two runs');
  const search = h('input', { type: 'search', 'aria-label': 'Filter the runs', placeholder: 'filter: sensor, recipe, verdict, date …', value: filter || '', oninput: () => fill() });
  const count = h('span', { class: 'muted', role: 'status' });
  const box = (run) => h('input', { type: 'checkbox', 'aria-label': `compare run ${run}`, checked: chosen.has(run), onchange: (event) => {
    if (event.target.checked) chosen.add(run); else chosen.delete(run);
    compare.disabled = chosen.size !== 2;
  } });
  function fill() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const shown = all.filter((run) => fits(run, words));
    body.replaceChildren(...shown.map((run) => runRow(run, box(run.run))));
    count.textContent = `${shown.length} of ${all.length} runs${leftOut ? `, ${leftOut} older ones are not listed` : ''}`;
  }
  fill();
  return [title('Runs'), h('div', { class: 'tools' }, search, compare, count),
    all.length ? table('Table of runs', [...runColumns, ['compare', more]], body) : h('p', {}, 'There is no run in this store yet.')];
}

// The document's frame, when the program has made it; its words where it cannot.
function frame(path, name) {
  const box = h('div', {}, h('p', { class: 'muted', role: 'status' }, `${name}: is being made…`));
  ask(path).then(({ path: made }) => box.replaceChildren(h('iframe', { src: made, title: name, referrerpolicy: 'no-referrer' })))
    .catch((error) => box.replaceChildren(h('p', { class: 'notice' }, error.message)));
  return box;
}

const fact = (name, value) => h('div', {}, h('dt', {}, name), h('dd', {}, value || '–'));

// A run that was judged by another run's models has its report there.
async function run(number) {
  const { runs: all } = await ask('/runs');
  const one = all.find((other) => other.run === Number(number));
  if (!one) return [title(`Run ${number}`, 'Runs'), h('p', { class: 'notice' }, 'It is not among the newest runs of this store.')];
  const report = one.report || one.run;
  return [title(`Run ${one.run}`, 'Runs'), one.verdict ? h('div', { class: 'judged' }, largeVerdict(one.verdict, one.origin)) : '',
    h('dl', { class: 'facts card' }, fact('sensor', h('a', { href: link('sensor', one.sensor) }, one.sensor)), fact('recipes', names(one)), fact('operator', one.operator),
      fact('started (UTC)', minute(one.started_utc)), fact('outcome', `${one.outcome}${one.void ? ', VOID' : ''}: ${one.reason}`), fact('safe state', one.safe_state),
      fact('frames', String(one.frames)), fact('origin', one.origin), fact('purpose', one.purpose)),
    one.report || one.outcome !== 'completed' || one.void ? '' : h('p', { class: 'notice' }, `This run has no models and no verdict: its report shows what was measured. tactbench fit ${one.run} makes models.`),
    h('h2', {}, report === one.run ? 'Report' : `Report of run ${report}, whose models were judged on this run`),
    one.frames > 0 ? frame(`/make/report?run=${report}`, `Report of run ${report}`) : h('p', {}, 'It has no frames for a report.')];
}

const compare = async (first, second) => [title(`Runs ${first} and ${second}`, 'Runs'), frame(`/make/compare?run=${first}&with=${second}`, `Comparison of runs ${first} and ${second}`)];

async function sensors() {
  const { sensors: all } = await ask('/sensors');
  const columns = [['verdict'], ['sensor'], ['calibrated'], ['due'], ['newest'], ['runs', more], ['scanner', more], ['note', more]];
  const row = (sensor) => h('tr', {}, h('td', {}, badge(sensor.verdict)), h('td', { class: 'wrap' }, h('a', { href: link('sensor', sensor.serial) }, sensor.serial), small(sensor.type)),
    h('td', {}, sensor.calibrated || '–'), h('td', { class: sensor.overdue ? 'bad' : '' }, sensor.due || '–'),
    h('td', {}, sensor.runs.length ? h('a', { href: link('run', sensor.runs[0]) }, `run ${sensor.runs[0]}`) : '–'),
    h('td', { class: 'n more' }, String(sensor.runs.length)), h('td', { class: 'wrap more' }, sensor.scanner || 'any'), h('td', { class: 'wrap more' }, sensor.note));
  return [title('Sensors'), all.length ? table('Table of sensors', columns, h('tbody', {}, all.map(row))) : h('p', {}, 'No sensor is registered in this store.')];
}

async function sensor(serial) {
  const [{ sensors: all }, { runs: history }] = await Promise.all([ask('/sensors'), ask('/runs')]);
  const one = all.find((other) => other.serial === serial);
  if (!one) return [title(serial, 'Sensors'), h('p', { class: 'notice' }, 'It is not registered in this store.')];
  const when = [one.calibrated ? `calibrated ${one.calibrated}` : 'not calibrated', one.due ? `${one.overdue ? 'overdue since' : 'due'} ${one.due}` : ''];
  return [title(serial, 'Sensors', [one.type, one.note, ...when].filter(Boolean).join(' · ')), one.verdict ? h('div', { class: 'judged' }, largeVerdict(one.verdict, one.origin)) : '',
    h('h2', {}, 'History'), table('Runs of this sensor', runColumns, h('tbody', {}, history.filter((run) => run.sensor === serial).map((run) => runRow(run)))),
    h('h2', {}, 'Trend'), one.figures ? frame(`/make/sensor?serial=${encodeURIComponent(serial)}`, `Figures of ${serial} over time`) : h('p', {}, 'No figures of it are kept yet: tactbench fit keeps them.')];
}

async function night() {
  while (!now.state) await new Promise((done) => { setTimeout(done, 50); });
  const { hello: { night: page }, state: { nights } } = now;
  return [title('Night'), page ? [h('h2', {}, 'The last night'), frame('/make/night', 'The night’s table')] : '',
    nights ? [h('h2', {}, `Figures over the nights, ${nights} scenarios`), frame('/make/nights', 'Figures over the nights')] : '', page || nights ? '' : h('p', {}, 'This store contains no nights.')];
}

const places = { runs, run, compare, sensors, sensor, night };
let shown = 0;

// The view of a place such as ["run", "5"].
export async function show(place) {
  const mine = ++shown;
  view().replaceChildren(h('p', { class: 'muted' }, 'Reading the store…'));
  let content;
  try {
    content = await places[place[0]](...place.slice(1));
  } catch (error) {
    content = [title('The store does not answer'), h('p', { class: 'notice' }, error.message)];
  }
  if (mine === shown) view().replaceChildren(...content.flat(3).filter(Boolean));
}

export const leave = () => { shown += 1; view().replaceChildren(); };
export const isPlace = (name) => Object.hasOwn(places, name);
