// The first view: what the run does now. It only shows; what it shows comes in events (link.js).
import { clock, colourBar, lines, map } from './draw.js';
import { ask, command, keys } from './link.js';

const $ = (id) => document.getElementById(id);
const kSpan = 60000; // ms of real time in the trace
const kMostPoints = 2400;

const now = {
  hello: { operator: '', commands: false }, state: null, readings: null, picture: null, counts: [], psi: null,
  trace: [], taxel: -1, compensated: false, top: 0, topRun: 0,
  loop: null, before: null, // {run, taxel, last, x, y}
  loopAsked: 0, asking: false, answered: 0, sent: 0, dirty: { trace: true, picture: true, loop: true }, came: 0,
};

const put = (node, text) => { if (node.textContent !== text) node.textContent = text; };
const number = (value, digits) => (value == null ? '–' : value.toFixed(digits));

function numbers(base64) {
  const text = atob(base64);
  const out = new Array(text.length / 2);
  for (let i = 0; i < out.length; i += 1) out[i] = text.charCodeAt(2 * i) + 256 * text.charCodeAt(2 * i + 1);
  return out;
}

function reading(name, value, unit, colour) {
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

function showState() {
  const { state } = now;
  if (!state) return;
  const view = state.view || null;
  const live = state.live && view;
  document.title = view ? `${live ? view.state : view.outcome} · run ${view.run} · tactbench` : 'tactbench';
  put($('which'), view ? `Run ${view.run} · sensor ${view.sensor || '–'} · ${live ? '' : 'last run, '}operator ${view.operator || '–'}` : 'No run yet');
  put($('state'), live ? view.state : view ? `no run is live: the last one ${view.outcome === 'incomplete' ? (view.lives ? 'opens its devices' : 'was broken off') : view.outcome}` : 'waiting for the first run');
  put($('phase'), live ? view.phase : view ? [view.reason, state.next ? `next: ${state.next}` : ''].filter(Boolean).join(' · ') : state.unread || 'start one: tactbench run, or tactbench demo');
  put($('bench'), view ? `bench ${view.bench}${live && view.rate !== 1 ? ` · ${view.rate > 0 ? `${view.rate} × real time` : 'simulated clock'}` : ''}` : '');
  $('safe').className = `safe ${state.safe.state}`;
  put($('safe-state'), { proved: '✓ proved safe', loaded: '▲ in use', unknown: '✗ not proved' }[state.safe.state]);
  put($('safe-words'), state.safe.words);
  put($('store'), `store ${state.store}`);
  $('simulated').hidden = state.origin !== 'simulated';
  showProgress(live ? { ...view, ...(now.readings && now.readings.run === view.run ? now.readings : {}) } : view, live);
  showPrompt(live ? view : null);
  showCommands(live ? view : null);
  showEvents(state.events);
  const press = live && view.target_n != null;
  $('press').hidden = !(press || (now.picture && now.picture.press));
}

function showProgress(view, live) {
  const share = view && view.steps > 0 ? view.step / view.steps : view && !live && view.outcome === 'completed' ? 1 : null;
  $('bar').firstElementChild.style.width = `${100 * (share || 0)}%`;
  $('bar').setAttribute('aria-valuenow', Math.round(100 * (share || 0)));
  put($('percent'), share == null ? '–' : `${Math.floor(100 * share)} %`);
  const rate = live && view.rate > 0 ? view.rate : 1;
  const left = live && view.left_high_s > 0
    ? `${clock(view.left_s / rate)} left (${clock(view.left_low_s / rate)} to ${clock(view.left_high_s / rate)}, 10–90 %)` : live ? 'time left not known' : '';
  put($('left'), left + (live && view.prompts_left > 0 ? ` + ${view.prompts_left} prompt${view.prompts_left > 1 ? 's' : ''}` : ''));
  put($('frames'), view && view.frames != null ? `${view.frames} frames stored${view.frames_planned ? ` of ${view.frames_planned} planned` : ''}` : '');
}

function showPrompt(view) {
  const asks = view && view.question;
  $('prompt').hidden = !asks;
  if (asks) {
    put($('question'), view.question);
    $('answer').hidden = !keys.command || now.sent === view.question_id;
    put($('prompt-note'), !keys.command ? `This link only reads. Answer at the bench: press Enter there, or tactbench resume ${view.run}`
      : now.sent === view.question_id ? 'Answered; the run opens its devices again.' : 'Or press Enter at the bench: the first answer counts.');
  }
  const answer = view && view.answer;
  if (answer && answer.question !== now.answered) {
    now.answered = answer.question;
    tell(`The question was answered by ${answer.who}${answer.text ? `: ${answer.text}` : ''}`);
  }
}

let toldTimer = 0;
export function tell(text) {
  put($('told'), text);
  $('told').hidden = false;
  clearTimeout(toldTimer);
  toldTimer = setTimeout(() => { $('told').hidden = true; }, 12000);
}

function showCommands(view) {
  const may = Boolean(keys.command);
  const state = view ? view.state : '';
  const on = { pause: state === 'running', resume: state === 'paused' || state === 'pausing', stop: Boolean(view), abort: Boolean(view), panic: Boolean(view) };
  for (const button of $('buttons').children) button.disabled = !may || !on[button.dataset.word];
  put($('who'), may ? `you command as ${now.hello.operator || '…'}` : 'this link only reads');
  $('copy').hidden = !may;
  if (!may) put($('command-note'), now.hello.commands ? 'Commands need the operator’s link.' : 'Nobody commands from this page: start it with --operator NAME.');
}

function showEvents(events) {
  const list = $('events');
  const text = JSON.stringify(events);
  if (list.dataset.shown === text) return;
  list.dataset.shown = text;
  list.replaceChildren(...events.map((event) => {
    const item = document.createElement('li');
    const bad = event.kind === 'fault' || event.id.startsWith('TB-');
    if (bad) item.className = event.kind === 'fault' ? 'fault' : 'warn';
    const time = document.createElement('time');
    time.textContent = clock(event.time_s);
    const kind = document.createElement('span');
    kind.className = 'kind';
    kind.textContent = event.kind;
    const detail = document.createElement('span');
    detail.textContent = `${event.id ? `${event.id}: ` : ''}${event.detail}`;
    item.append(time, kind, detail);
    if (event.try) {
      const cure = document.createElement('span');
      cure.className = 'try';
      cure.textContent = `To do: ${event.try}`;
      item.append(cure);
    }
    return item;
  }));
}

function showReadings() {
  const one = now.readings;
  const force = one && one.target_n != null;
  put($('trace-title'), force ? 'Force' : 'Pressure');
  const box = $('readings');
  const boxes = !one || one.time_s == null ? [] : force
    ? [reading('level', number(one.target_n, 2), 'N', 'setpoint'), reading('measured', number(one.force_n, 2), 'N', 'reference')]
    : [reading('set-point', number(one.setpoint_psi, 1), 'psi', 'setpoint'), reading('feedback', number(one.feedback_psi, 2), 'psi', 'feedback'),
      reading('reference', number(one.reference_psi, 2), 'psi', 'reference')];
  box.replaceChildren(...boxes);
  put($('settled'), one && one.time_s != null ? `${force ? '' : one.settled ? 'settled · ' : 'moving · '}${clock(one.time_s)} since the start` : '');
  $('trace').setAttribute('aria-label', one && one.time_s != null
    ? `Trace of the last minute. ${force ? `level ${number(one.target_n, 2)} N, measured ${number(one.force_n, 2)} N` : `set-point ${number(one.setpoint_psi, 1)}, feedback ${number(one.feedback_psi, 2)}, reference ${number(one.reference_psi, 2)} psi`}` : 'Trace of the last minute: no reading yet');
}

function drawTrace() {
  const { trace } = now;
  const force = now.readings != null && now.readings.target_n != null;
  const points = trace.filter((p) => (p.target != null) === force);
  const x = points.map((p) => p.t);
  const ys = force ? [['target', 'setpoint'], ['force', 'reference']] : [['set', 'setpoint'], ['feed', 'feedback'], ['ref', 'reference']];
  const high = Math.max(force ? 1 : 10, ...ys.flatMap(([key]) => points.map((p) => p[key] ?? 0)));
  lines($('trace'), {
    x: { low: x.length > 1 ? x[0] : 0, high: x.length > 1 ? Math.max(x[x.length - 1], x[0] + 1) : 60, label: 'process time', time: true },
    y: { low: 0, high: high * 1.08, label: force ? 'N' : 'psi' },
    series: ys.map(([key, colour], i) => ({ x, y: points.map((p) => p[key]), colour, width: i === 0 ? 1.5 : 2, dash: key === 'feed' ? [5, 3] : [] })),
    empty: 'no reading yet',
  });
}

function taxelWords() {
  const { picture, taxel } = now;
  if (!picture) return '';
  if (taxel < 0) return 'click a taxel for its own loop';
  if (taxel >= now.counts.length) return 'outside the array';
  const what = picture.dead.includes(taxel) ? ', dead' : picture.saturated.includes(taxel) ? ', saturated' : '';
  const psi = now.psi && !picture.dead.includes(taxel) ? `, ${(now.psi[taxel] / 100).toFixed(1)} psi compensated` : '';
  return `${(now.counts[taxel] * picture.volts_per_count).toFixed(3)} V${psi}${what}`;
}

function drawPicture() {
  const { picture } = now;
  if (!picture) return;
  const psi = now.compensated && now.psi;
  const values = psi ? now.psi.map((v) => v / 100) : now.counts.map((v) => v * picture.volts_per_count);
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
  put($('picture-title'), `${picture.title}${picture.void ? ' (void branch)' : ''}, ${picture.rows} × ${picture.columns} taxels${model}`);
  const values = now.counts.map((v) => v * picture.volts_per_count);
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

function drawLoop() {
  const { loop, before } = now;
  const series = [];
  if (before && before.x.length) series.push({ ...before, colour: 'before', width: 1.5 });
  if (loop && loop.x.length) series.push({ ...loop, colour: 'reference', width: 2, dot: true });
  const xs = series.flatMap((one) => one.x), ys = series.flatMap((one) => one.y);
  const axis = loop ? loop.axis : 'psi';
  lines($('loop'), {
    x: { low: 0, high: Math.max(axis === 'N' ? 1 : 10, ...xs) * 1.03, label: axis === 'N' ? 'force in N' : 'reference in psi' },
    y: { low: Math.min(0, ...ys), high: Math.max(0.2, ...ys) * 1.06, label: 'V' }, series, empty: 'no frame yet',
  });
  const name = now.taxel < 0 ? 'the mean taxel' : now.picture ? `row ${Math.floor(now.taxel / now.picture.columns)}, column ${now.taxel % now.picture.columns}` : 'a taxel';
  put($('loop-title'), `Loop of ${name}`);
  $('loop').setAttribute('aria-label', `Output against pressure of ${name}, ${loop ? loop.x.length : 0} frames${before && before.x.length ? `, over run ${before.run}` : ''}`);
  const legend = $('loop-legend');
  const words = `${loop ? `run ${loop.run}` : ''}|${before && before.x.length ? before.run : ''}`;
  if (legend.dataset.shown === words) return;
  legend.dataset.shown = words;
  legend.replaceChildren();
  for (const [one, colour, text] of [[loop, 'reference', 'this run'], [before && before.x.length ? before : null, 'before', 'last completed run of the sensor']]) {
    if (!one) continue;
    const span = document.createElement('span');
    const line = document.createElement('i');
    line.className = `of-${colour}`;
    span.append(line, `${text}, ${one.run}`);
    legend.append(span);
  }
}

async function askLoop() {
  const { state, picture } = now;
  if (now.asking || !state || !state.view || Date.now() - now.loopAsked < 500) return;
  const { run } = state.view, { taxel } = now;
  const known = now.loop && now.loop.run === run && now.loop.taxel === taxel ? now.loop : null;
  if (known && picture && picture.run === run && picture.position <= known.last) return;
  now.asking = true;
  now.loopAsked = Date.now();
  try {
    const got = await ask(`/loop?run=${run}&taxel=${taxel}&after=${known ? known.last : 0}`);
    if (taxel === now.taxel) {
      now.loop = known ? { ...got, x: known.x.concat(got.x).slice(-6000), y: known.y.concat(got.y).slice(-6000) } : got;
      const earlier = state.before;
      if (earlier && (!now.before || now.before.run !== earlier || now.before.taxel !== taxel)) now.before = await ask(`/loop?run=${earlier}&taxel=${taxel}`);
      if (!earlier) now.before = null;
      now.dirty.loop = true;
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
  }
  if (name === 'readings') {
    if (now.readings && now.readings.run !== data.run) now.trace = [];
    now.readings = data;
    if (data.time_s != null) {
      const at = Date.now();
      const last = now.trace[now.trace.length - 1];
      if (!last || last.t !== data.time_s) now.trace.push({ at, t: data.time_s, set: data.setpoint_psi, feed: data.feedback_psi, ref: data.reference_psi, target: data.target_n, force: data.force_n });
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
    now.counts = numbers(data.counts);
    now.psi = data.psi ? numbers(data.psi) : null;
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
    put(note, answer.text);
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
