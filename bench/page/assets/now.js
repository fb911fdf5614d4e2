// The first view: what the run does now. It only shows; what it shows comes in events (link.js).
import { colourBar, lines, map } from './draw.js';
import { ask, command } from './link.js';
import { showProgress, showReadings, showState, tell } from './panels.js';
import { $, h, line, now, number, put, reading, renew } from './seen.js';

const kSpan = 60000; // ms of real time in the trace
const kMostPoints = 6000;

// What is wanted and what is measured: of a live run the last minute's readings, else all frames of the store.
function traced() {
  const { state, readings, loop } = now;
  if (state && state.live) {
    const force = readings != null && readings.target_n != null;
    const points = now.trace.filter((p) => (p.target != null) === force);
    const all = (key) => points.map((p) => p[key]);
    return { unit: force ? 'N' : 'psi', t: all('t'), settled: all('settled'), want: all(force ? 'target' : 'set'), got: all(force ? 'force' : 'ref'), feed: force ? [] : all('feed') };
  }
  const { axis, t, set, x } = loop || { axis: 'psi', t: [], set: [], x: [] };
  return { unit: axis, t, settled: t.map(() => true), want: set, got: x, feed: [] };
}

// Set-point and reference are one line to the eye: their difference has a chart of its own.
function drawTrace() {
  const { unit, t, settled, want, got, feed } = traced();
  const x = { low: t.length > 1 ? t[0] : 0, high: t.length > 1 ? Math.max(t[t.length - 1], t[0] + 1) : 60, time: true };
  const high = Math.max(unit === 'N' ? 1 : 10, ...want, ...got.map((v) => v ?? 0));
  lines($('trace'), {
    x, y: { low: 0, high: high * 1.08, label: unit }, empty: now.state && now.state.live ? 'no reading yet' : 'no frame stored',
    series: [{ x: t, y: want, colour: 'setpoint', width: 5 }, { x: t, y: got, colour: 'reference' }],
  });
  const off = (values) => values.map((v, i) => (v == null || !settled[i] ? null : v - want[i]));
  const series = [...(feed.length ? [['feedback', off(feed)]] : []), ['reference', off(got)]];
  const most = series.map(([, values]) => Math.max(0, ...values.map(Math.abs)));
  const top = Math.max(unit === 'N' ? 0.05 : 0.1, ...most) * 1.15;
  lines($('off'), { x: { ...x, label: 'process time' }, y: { low: -top, high: top, label: '' }, series: series.map(([colour, y]) => ({ x: t, y, colour, width: 1.5 })) });
  const names = { reference: unit === 'N' ? 'measured − level' : 'reference − set-point', feedback: 'feedback − set-point' };
  const texts = series.map(([colour], i) => [colour, `${names[colour]}: at most ${most[i].toFixed(2)} ${unit}${feed.length && i === series.length - 1 ? ' (settled)' : ''}`]);
  if (!now.state || !now.state.live) texts.unshift(['setpoint', unit === 'N' ? 'level' : 'set-point']);
  renew($('off-legend'), t.length ? texts : [], () => (t.length ? texts.map(([colour, text]) => h('span', {}, line(colour), text)) : []));
}

function taxelWords() {
  const { picture, taxel } = now;
  if (!picture) return '';
  if (taxel < 0) return 'click a taxel for its own loop';
  if (taxel >= now.volts.length) return 'outside the array';
  const what = picture.dead.includes(taxel) ? ', dead' : picture.saturated.includes(taxel) ? ', saturated' : '';
  const psi = now.psi && !picture.dead.includes(taxel) ? `, ${now.psi[taxel].toFixed(1)} psi compensated` : '';
  return `${now.volts[taxel].toFixed(3)} V${psi}${what}`;
}

function drawPicture() {
  const { picture } = now;
  if (!picture) return;
  const psi = now.compensated && now.psi;
  const values = psi || now.volts;
  if (now.topRun !== picture.run) { now.top = 0; now.topRun = picture.run; }
  now.top = Math.max(now.top, 0.1 * picture.full_scale_v, ...(psi ? [] : values));
  const top = psi ? Math.max(60, Math.ceil(Math.max(...values) / 10) * 10) : now.top;
  map($('map'), { rows: picture.rows, columns: picture.columns, values, top, dead: picture.dead, saturated: picture.saturated, chosen: now.taxel });
  colourBar($('scale'), { top, unit: psi ? 'psi' : 'V', digits: psi ? 0 : 2 });
}

function showPicture() {
  const { picture } = now;
  if (!picture) return;
  $('show-psi').disabled = !now.psi;
  if (!now.psi) now.compensated = false;
  $('show-raw').setAttribute('aria-pressed', String(!now.compensated));
  $('show-psi').setAttribute('aria-pressed', String(now.compensated));
  const model = now.compensated ? ` · ${picture.model}${picture.unknown ? `, history of ${picture.unknown} taxels not known yet` : ''}` : '';
  put($('picture-title'), `${picture.peak ? 'highest load: ' : ''}${picture.title}${picture.void ? ' (void branch)' : ''}, ${picture.rows} × ${picture.columns} taxels${model}`);
  const values = now.volts;
  put($('legend'), [picture.dead_known ? `▨ dead: ${picture.dead.length}` : 'dead taxels: judged under load', `▧ saturated: ${picture.saturated.length}`,
    `mean ${(values.reduce((a, b) => a + b, 0) / values.length).toFixed(3)} V`].join('   '));
  $('map').setAttribute('aria-label', `Picture of the array, ${picture.title}: ${values.length} taxels, ${Math.min(...values).toFixed(2)} to ${Math.max(...values).toFixed(2)} V, ${picture.dead.length} dead, ${picture.saturated.length} saturated`);
  put($('taxel-words'), taxelWords());
  if (!picture.press) return;
  const { wrench, place_mm: place } = picture.press;
  $('press-values').replaceChildren(
    ...['Fx', 'Fy', 'Fz'].map((name, i) => reading(name, number(wrench[i], 2), 'N')), ...['Tx', 'Ty', 'Tz'].map((name, i) => reading(name, number(wrench[i + 3], 1), 'N mm')),
    ...['x', 'y', 'z'].map((name, i) => reading(name, number(place[i], 3), 'mm')),
  );
}

// Only loops of one quantity share the axes: this run's, before its first frame the earlier run's.
function drawLoop() {
  const { loop, before, taxel, picture } = now;
  const full = (one) => one && one.x.length > 0;
  const axis = full(loop) ? loop.axis : full(before) ? before.axis : 'psi';
  const shown = [[before, 'before', 'last completed run of the sensor'], [loop, 'reference', 'this run']].filter(([one]) => full(one) && one.axis === axis);
  const xs = shown.flatMap(([one]) => one.x), ys = shown.flatMap(([one]) => one.y);
  lines($('loop'), {
    x: { low: 0, high: Math.max(axis === 'N' ? 1 : 10, ...xs) * 1.03, label: axis === 'N' ? 'force in N' : 'reference in psi' },
    y: { low: Math.min(0, ...ys), high: Math.max(0.2, ...ys) * 1.06, label: 'V' }, empty: 'no frame stored',
    series: shown.map(([one, colour]) => ({ x: one.x, y: one.y, colour, width: one === loop ? 2 : 1.5, dot: one === loop })),
  });
  const name = taxel < 0 ? 'the mean taxel' : picture ? `row ${Math.floor(taxel / picture.columns)}, column ${taxel % picture.columns}` : 'a taxel';
  put($('loop-title'), `Loop of ${name}`);
  $('loop').setAttribute('aria-label', `Output against ${axis === 'N' ? 'force' : 'pressure'} of ${name}: ${shown.map(([one]) => `run ${one.run}, ${one.x.length} frames`).join('; ')}`);
  renew($('loop-legend'), shown.map(([one, colour]) => [one.run, colour]), () => shown.map(([one, colour, text]) => h('span', {}, line(colour), `${text}, ${one.run}`)));
}

// The newer points behind the known ones; of another quantity they stand alone.
function joined(known, got) {
  if (!known || (got.x.length && got.axis !== known.axis)) return got;
  const out = { ...known, last: got.last };
  for (const key of ['t', 'set', 'x', 'y']) out[key] = known[key].concat(got[key]).slice(-kMostPoints);
  return out;
}

async function askLoop() {
  const { state, picture } = now;
  if (now.asking || !state || !state.view || Date.now() - now.loopAsked < 500) return;
  const { run } = state.view, { taxel } = now;
  const known = now.loop && now.loop.run === run && now.loop.taxel === taxel ? now.loop : null;
  if (known && picture && picture.run === run && picture.last <= known.last) return;
  now.asking = true;
  now.loopAsked = Date.now();
  try {
    const got = await ask(`/loop?run=${run}&taxel=${taxel}&after=${known ? known.last : 0}`);
    if (taxel === now.taxel) {
      now.loop = joined(known, got);
      const earlier = state.before;
      if (earlier && (!now.before || now.before.run !== earlier || now.before.taxel !== taxel)) now.before = await ask(`/loop?run=${earlier}&taxel=${taxel}`);
      if (!earlier) now.before = null;
      now.dirty.loop = now.dirty.trace = true;
      showReadings();
    }
  } catch { /* the next picture asks again */ } finally {
    now.asking = false;
  }
}

export function choose(taxel) {
  now.taxel = taxel;
  now.loopAsked = 0;
  const columns = now.picture ? now.picture.columns : 1;
  $('row').value = taxel < 0 ? '' : Math.floor(taxel / columns);
  $('column').value = taxel < 0 ? '' : taxel % columns;
  showPicture();
  askLoop();
  now.dirty.picture = true;
  now.dirty.loop = true;
}

export function take(name, data) {
  if (name === 'hello') now.hello = data;
  if (name === 'state') {
    now.state = data;
    if (data.view && now.readings && data.view.run !== now.readings.run) now.readings = null;
    if (data.live && data.view.readings && !now.readings) now.readings = { ...data.view, ...data.view.readings };
    showState();
    showReadings();
    now.dirty.trace = true;
  }
  if (name === 'readings') {
    if (now.readings && now.readings.run !== data.run) now.trace = [];
    now.readings = data;
    if (data.time_s != null) {
      const at = Date.now();
      const last = now.trace[now.trace.length - 1];
      if (!last || last.t !== data.time_s) now.trace.push({ at, t: data.time_s, set: data.setpoint_psi, feed: data.feedback_psi, ref: data.reference_psi, target: data.target_n, force: data.force_n, settled: data.settled || data.target_n != null });
      while (now.trace.length > kMostPoints || (now.trace.length && at - now.trace[0].at > kSpan)) now.trace.shift();
    }
    put($('phase'), data.phase);
    if (now.state && now.state.live) showProgress({ ...now.state.view, ...data }, true);
    showReadings();
    now.dirty.trace = true;
  }
  if (name === 'picture') {
    now.picture = data;
    now.came = performance.now();
    now.volts = data.volts;
    now.psi = data.psi || null;
    now.dirty.picture = true;
    showPicture();
  }
  askLoop();
}

// Returns when the picture came that is drawn now for the first time; 0: none.
export function draw() {
  const { dirty } = now;
  if (!(dirty.trace || dirty.picture || dirty.loop) || $('view-now').hidden || document.hidden) return 0;
  now.dirty = {};
  if (dirty.trace) drawTrace();
  if (dirty.picture) drawPicture();
  if (dirty.loop) drawLoop();
  const { came } = now;
  now.came = 0;
  return came;
}

export const redraw = () => { now.dirty = { trace: true, picture: true, loop: true }; };
export const silence = () => (now.state && now.state.live ? now.state.silent_s : 0);
export const runOnShow = () => (now.state && now.state.view ? now.state.view.run : 0);

async function send(word, more) {
  const note = $('command-note');
  const run = runOnShow();
  put(note, `${word}: sent, not acknowledged yet`);
  try {
    const answer = await command({ word, run, ...more });
    put(note, answer.by ? `${answer.text} (answered by ${answer.by})` : answer.text);
    return answer;
  } catch {
    put(note, `${word} was not sent: the page’s program does not answer. At the bench: tactbench ${word} ${run}`);
    return { taken: false, text: '' };
  }
}

const questions = {
  stop: ['Stop the run?', 'It ends now: vents, retracts, proves the safe state. What was measured counts; tactbench resume continues it.', 'Stop the run'],
  abort: ['Abort the run?', 'It ends now: vents, retracts, proves the safe state. For when something looked wrong.', 'Abort the run'],
};

function sure(word) {
  const [title, words, yes] = questions[word];
  put($('sure-title'), title);
  put($('sure-words'), words);
  put($('sure-yes'), yes);
  const dialog = $('sure');
  dialog.showModal();
  return new Promise((done) => { dialog.onclose = () => done(dialog.returnValue === 'yes'); dialog.returnValue = 'no'; });
}

export function begin() {
  for (const button of $('buttons').children) {
    button.addEventListener('click', async () => {
      const { word } = button.dataset;
      if (!questions[word] || await sure(word)) send(word);
    });
  }
  $('answer').addEventListener('submit', async (event) => {
    event.preventDefault();
    const question = now.state.view.question_id;
    const answer = await send('answer', { question, text: $('answer-text').value });
    if (answer.taken) {
      now.sent = question;
      $('answer-text').value = '';
    } else {
      tell(answer.text);
    }
    showState();
  });
  $('map').addEventListener('click', (event) => {
    if (!now.picture) return;
    const box = $('map').getBoundingClientRect();
    const row = Math.floor(((event.clientY - box.top) / box.height) * now.picture.rows);
    const column = Math.floor(((event.clientX - box.left) / box.width) * now.picture.columns);
    choose(row * now.picture.columns + column);
  });
  const typed = () => {
    if (!now.picture || $('row').value === '' || $('column').value === '') return;
    const row = Number($('row').value), column = Number($('column').value);
    if (row < now.picture.rows && column < now.picture.columns && row >= 0 && column >= 0) choose(row * now.picture.columns + column);
  };
  $('row').addEventListener('input', typed);
  $('column').addEventListener('input', typed);
  $('taxel').addEventListener('submit', (event) => event.preventDefault());
  $('mean').addEventListener('click', () => choose(-1));
  for (const [id, on] of [['show-raw', false], ['show-psi', true]]) {
    $(id).addEventListener('click', () => { now.compensated = on; showPicture(); now.dirty.picture = true; });
  }
}
