// The words of the first view: state, progress, question, commands, events, readings.
import { clock } from './draw.js';
import { keys } from './link.js';
import { $, now, number, put, reading } from './seen.js';

export function showState() {
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

export function showProgress(view, live) {
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

export function showReadings() {
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
