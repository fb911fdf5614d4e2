// The texts of the first view: state, verdict, progress, question, commands, events, readings.
import { clock } from './draw.js';
import { keys } from './link.js';
import { $, h, largeVerdict, now, number, put, reading, renew } from './seen.js';

const safeWords = { proved: '✓ safe', loaded: '▲ under pressure', unknown: '✗ not proved safe', none: 'no run' };

export function showState() {
  const { state } = now;
  if (!state) return;
  const view = state.view || null;
  const live = state.live && view;
  const verdict = live ? null : state.verdict;
  document.title = view ? `${live ? view.state : verdict ? verdict.word : view.outcome} · run ${view.run} · tactbench` : 'tactbench';
  put($('which'), view ? `${live ? 'Run' : 'Last run:'} ${view.run} · sensor ${view.sensor || '–'} · operator ${view.operator || '–'}` : 'No run yet');
  put($('state'), live ? view.state : !view ? 'waiting for the first run' : view.outcome !== 'incomplete' ? view.outcome : view.lives ? 'opens its devices' : 'broken off');
  $('state').className = !live && view && view.outcome !== 'completed' && !view.lives ? 'bad' : '';
  put($('phase'), live ? view.phase : view ? [view.reason, verdict || !state.next ? '' : `next: ${state.next}`].filter(Boolean).join(' · ') : state.unread || 'start one: tactbench run, or tactbench demo');
  put($('bench'), view ? `bench ${view.bench}${live && view.rate !== 1 ? ` · ${view.rate > 0 ? `${view.rate} × real time` : 'simulated clock'}` : ''}` : '');
  $('safe').className = `safe ${state.safe.state}`;
  put($('safe-state'), state.safe.state === 'loaded' && view.target_n != null ? '▲ under force' : safeWords[state.safe.state]);
  put($('safe-words'), state.safe.words);
  put($('store'), `store ${state.store}`);
  $('night').hidden = !(now.hello.night || state.nights);
  $('simulated').hidden = state.origin !== 'simulated';
  $('verdict').hidden = !verdict;
  $('progress').hidden = Boolean(verdict);
  if (verdict) renew($('verdict'), [verdict, state.origin], () => largeVerdict(verdict, state.origin));
  showProgress(live ? { ...view, ...(now.readings && now.readings.run === view.run ? now.readings : {}) } : view, live);
  showPrompt(live ? view : null);
  showCommands(live ? view : null);
  showEvents(state.events);
  $('press').hidden = !((live && view.target_n != null) || (now.picture && now.picture.press));
}

export function showProgress(view, live) {
  const share = view && view.steps > 0 ? view.step / view.steps : view && !live && view.outcome === 'completed' ? 1 : null;
  $('bar').firstElementChild.style.width = `${100 * (share || 0)}%`;
  $('bar').setAttribute('aria-valuenow', Math.round(100 * (share || 0)));
  put($('percent'), share == null ? '–' : `${Math.floor(100 * share)} %`);
  const time = live && ((s) => clock(view.rate > 0 ? s / view.rate : s));
  const left = !live ? '' : view.left_high_s > 0 ? `${time(view.left_s)} left (${time(view.left_low_s)} to ${time(view.left_high_s)}, 10–90 %)${view.rate > 0 ? '' : ' of process time'}`
    : view.left_s > 0 ? `about ${time(view.left_s)} left` : 'time left not known yet';
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

// Without a run, or for who only reads, there is nothing to command.
function showCommands(view) {
  const may = Boolean(keys.command);
  const state = view ? view.state : '';
  const on = { pause: state === 'running', resume: state === 'paused' || state === 'pausing', stop: true, abort: true, panic: true };
  $('commands').hidden = !(may && view);
  for (const button of $('buttons').children) button.disabled = !on[button.dataset.word];
  put($('who'), may ? `you command as ${now.hello.operator || '…'}` : now.hello.commands ? 'this link only reads; commands need the operator’s link' : 'this page only shows; with --operator NAME it commands');
  $('copy').hidden = !may;
}

function showEvents(events) {
  renew($('events'), events, () => events.map((event) => {
    const kind = event.kind === 'fault' ? 'fault' : event.id.startsWith('TB-') ? 'warn' : null;
    return h('li', { class: kind }, h('time', {}, clock(event.time_s)), h('span', { class: 'kind' }, event.kind),
      h('span', {}, `${event.id ? `${event.id}: ` : ''}${event.detail}`), event.try ? h('span', { class: 'try' }, `To do: ${event.try}`) : '');
  }));
}

export function showReadings() {
  const one = now.state && now.state.live && now.readings && now.readings.time_s != null ? now.readings : null;
  const force = one ? one.target_n != null : Boolean(now.loop && now.loop.axis === 'N');
  put($('trace-title'), `${force ? 'Force' : 'Pressure'}${now.state && !now.state.live && now.loop ? ` of run ${now.loop.run}, as stored` : ''}`);
  const values = !one ? [] : force ? [['level', one.target_n, 2, 'N', 'setpoint'], ['measured', one.force_n, 2, 'N', 'reference']]
    : [['set-point', one.setpoint_psi, 1, 'psi', 'setpoint'], ['feedback', one.feedback_psi, 2, 'psi', 'feedback'], ['reference', one.reference_psi, 2, 'psi', 'reference']];
  $('readings').replaceChildren(...values.map(([name, value, digits, unit, colour]) => reading(name, number(value, digits), unit, colour)));
  put($('settled'), one ? `${force ? '' : one.settled ? 'settled · ' : 'moving · '}${clock(one.time_s)}` : '');
  $('trace').setAttribute('aria-label', one ? `Trace of the last minute: ${values.map(([name, value, digits, unit]) => `${name} ${number(value, digits)} ${unit}`).join(', ')}` : 'Trace of the whole run, as stored');
}
