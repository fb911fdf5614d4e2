// The page: which view is shown, how old the news is, and the stream that feeds the first view.
import { follow, keys, viewersLink } from './link.js';
import * as now from './now.js';
import { tell } from './panels.js';
import { $ } from './seen.js';
import * as store from './store.js';

let heard = 0;
let refused = '';

function showView() {
  let place = [''];
  try { place = location.hash.replace(/^#\//, '').split('/').map(decodeURIComponent); } catch { /* no place of this page */ }
  const stored = store.isPlace(place[0]);
  $('view-now').hidden = stored;
  $('view-store').hidden = !stored;
  const section = { run: 'runs', compare: 'runs', sensor: 'sensors' }[place[0]] || place[0];
  for (const link of document.querySelectorAll('nav a')) {
    if (link.dataset.view === (stored ? section : 'now')) link.setAttribute('aria-current', 'page');
    else link.removeAttribute('aria-current');
  }
  if (stored) store.show(place);
  else store.leave();
  now.redraw();
  window.scrollTo(0, 0);
}

// Old data looks old: a bar after 2 s without news, grey after 10 s.
function age() {
  const page = heard ? (Date.now() - heard) / 1000 : 0;
  const run = now.silence() + page;
  let words = refused;
  if (!words && !keys.read) words = 'This address lacks its key: open the complete link that tactbench printed.';
  if (!words && page >= 2) words = `No news for ${Math.floor(page)} s: the page’s program is stopped or has ended. The values shown are old. At the bench: tactbench status`;
  else if (!words && run >= 2) words = `The run has sent nothing for ${Math.floor(run)} s: its process is stopped. The values shown are old; check the rig.`;
  const bar = $('old');
  if (bar.hidden !== !words) bar.hidden = !words;
  if (bar.textContent !== words) bar.textContent = words;
  document.body.classList.toggle('stale', Math.max(page, run) >= 10);
}

function take(name, data) {
  heard = Date.now();
  refused = '';
  now.take(name, data);
  window.tactbench.events += 1;
}

// For the tests and the curious: how many events came, and how long each picture took from there to the screen, in ms.
window.tactbench = { events: 0, delays: [] };

function frame() {
  const came = now.draw();
  if (came) window.tactbench.delays.push(performance.now() - came);
  if (window.tactbench.delays.length > 500) window.tactbench.delays.shift();
  requestAnimationFrame(frame);
}

now.begin();
window.addEventListener('hashchange', showView);
window.addEventListener('resize', now.redraw);
window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', now.redraw);
document.addEventListener('visibilitychange', now.redraw);
$('copy').addEventListener('click', async () => {
  try {
    await navigator.clipboard.writeText(viewersLink());
    tell('The link for viewers is in the clipboard: it reads and cannot command.');
  } catch {
    tell(viewersLink());
  }
});
showView();
setInterval(age, 250);
requestAnimationFrame(frame);
if (keys.read) {
  follow(take, (status, words) => {
    refused = status === 401 ? 'This link is of an earlier start of the page: open the one that tactbench printed last.' : words;
  });
}
