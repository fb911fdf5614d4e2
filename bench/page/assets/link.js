// The way to the server: the link's keys, the stream of events, questions and commands. The keys stand behind the # of the
// link, which a browser does not send; they go in a header, never in an address.
const kept = 'tactbench-keys';

function takeKeys() {
  const found = /^#([0-9a-f]{32})(?:\.([0-9a-f]{32}))?$/.exec(location.hash);
  if (found) {
    sessionStorage.setItem(kept, JSON.stringify({ read: found[1], command: found[2] || '' }));
    history.replaceState(null, '', '#/now');
  }
  try {
    return JSON.parse(sessionStorage.getItem(kept)) || { read: '', command: '' };
  } catch {
    return { read: '', command: '' };
  }
}

export const keys = takeKeys();
const bearer = () => ({ Authorization: `Bearer ${keys.command || keys.read}` });

export const viewersLink = () => `${location.origin}/#${keys.read}`;

// Answers as JSON; throws an Error with the server's words.
export async function ask(path) {
  const response = await fetch(path, { headers: bearer() });
  const text = await response.text();
  let json = null;
  try { json = JSON.parse(text); } catch { /* a refusal in words */ }
  if (!response.ok) throw new Error((json && json.error) || text.trim() || `answer ${response.status}`);
  return json;
}

export async function command(body) {
  const response = await fetch('/command', {
    method: 'POST',
    headers: { ...bearer(), 'Content-Type': 'application/json', 'X-Tactbench': '1' },
    body: JSON.stringify(body),
  });
  const text = await response.text();
  try { return JSON.parse(text); } catch { return { taken: false, text: text.trim() }; }
}

const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const kNoWord = 15000; // ms without a byte, after which the stream is opened anew

function takeEvents(text, onEvent) {
  let rest = text;
  for (let end = rest.indexOf('\n\n'); end >= 0; end = rest.indexOf('\n\n')) {
    const lines = rest.slice(0, end).split('\n');
    rest = rest.slice(end + 2);
    const name = lines.find((line) => line.startsWith('event: '));
    const data = lines.find((line) => line.startsWith('data: '));
    if (name && data) onEvent(name.slice(7), JSON.parse(data.slice(6)));
  }
  return rest;
}

async function stream(onEvent) {
  const given = new AbortController();
  let timer = 0;
  const alive = () => {
    clearTimeout(timer);
    timer = setTimeout(() => given.abort(), kNoWord);
  };
  try {
    alive();
    const response = await fetch('/events', { headers: bearer(), signal: given.signal });
    if (!response.ok) return { status: response.status, words: (await response.text()).trim() };
    const reader = response.body.getReader();
    const decoder = new TextDecoder();
    for (let text = ''; ;) {
      const { done, value } = await reader.read();
      if (done) return { status: 0, words: '' };
      alive();
      text = takeEvents(text + decoder.decode(value, { stream: true }), onEvent);
    }
  } catch {
    return { status: 0, words: '' };
  } finally {
    clearTimeout(timer);
  }
}

// For ever: after each break it comes back. onRefused(words) where the server gives a reason.
export async function follow(onEvent, onRefused) {
  for (;;) {
    const end = await stream(onEvent);
    if (end.status !== 0) onRefused(end.status, end.words);
    await wait(end.status === 401 || end.status === 503 ? 5000 : 1000);
  }
}
