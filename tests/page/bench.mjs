// A folder with a simulated bench, the program under test in it, and a browser on its page.
import { spawn, spawnSync } from 'node:child_process';
import { appendFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

export const kLongest = 60_000; // ms for what takes a second on a quiet machine

export class Bench {
  constructor(program) {
    this.program = program;
    this.folder = mkdtempSync(join(tmpdir(), 'tactbench-page-'));
    const runtime = join(this.folder, 'runtime');
    mkdirSync(runtime, { mode: 0o700 });
    this.env = { ...process.env, TACTBENCH_RUNTIME_DIR: runtime, HOME: this.folder, NO_COLOR: '1' };
    this.started = [];
    this.call('init');
  }

  call(...words) {
    const done = spawnSync(this.program, words, { cwd: this.folder, env: this.env, encoding: 'utf8', timeout: 120_000 });
    if (done.status !== 0) throw new Error(`tactbench ${words.join(' ')}: ${done.status}\n${done.stdout}${done.stderr}`);
    return done.stdout;
  }

  write(name, text) { writeFileSync(join(this.folder, name), text); }
  append(name, text) { appendFileSync(join(this.folder, name), text); }
  read(name) { return readFileSync(join(this.folder, name), 'utf8'); }

  // Runs beside; `ended` becomes its exit code, or the signal's name.
  start(...words) { return this.spawned(this.program, words); }

  spawned(command, words) {
    const child = spawn(command, words, { cwd: this.folder, env: this.env, stdio: ['ignore', 'pipe', 'pipe'] });
    child.said = '';
    child.stdout.on('data', (text) => { child.said += text; });
    child.stderr.on('data', (text) => { child.said += text; });
    child.ended = new Promise((done) => { child.on('exit', (code, signal) => done(code ?? signal)); });
    this.started.push(child);
    return child;
  }

  // The same on a terminal of its own, where a person would answer.
  start_in_terminal(...words) {
    const quoted = [this.program, ...words].map((word) => `'${word}'`).join(' ');
    return this.spawned('script', ['-qefc', quoted, '/dev/null']);
  }

  async page(...words) {
    const child = this.start('page', '--port', '0', '--json', ...words);
    await until(() => child.said.includes('\n}') || child.exitCode !== null, 'the page names its link');
    return { child, ...JSON.parse(child.said) };
  }

  end() {
    for (const child of this.started) {
      if (child.exitCode !== null || child.signalCode !== null) continue;
      child.kill('SIGCONT');
      child.kill('SIGKILL');
    }
    rmSync(this.folder, { recursive: true, force: true, maxRetries: 5 });
  }
}

export async function until(so, what) {
  for (const end = Date.now() + kLongest; Date.now() < end;) {
    if (await so()) return;
    await new Promise((done) => setTimeout(done, 25));
  }
  throw new Error(`never came true: ${what}`);
}

export const launch = (path) => chromium.launch({ executablePath: path, args: process.getuid() === 0 ? ['--no-sandbox'] : [] });

// A viewer in a browser: what it complains of is kept.
export async function viewer(browser, link, { width = 1280, height = 900, dark = false } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: dark ? 'dark' : 'light' });
  const page = await context.newPage();
  page.setDefaultTimeout(kLongest);
  const complaints = [];
  page.on('console', (message) => { if (message.type() === 'error') complaints.push(message.text()); });
  page.on('pageerror', (error) => complaints.push(String(error)));
  page.on('dialog', (dialog) => { complaints.push(`a dialog of the browser: ${dialog.message()}`); dialog.dismiss(); });
  page.on('request', (request) => { if (!request.url().startsWith(link.split('#')[0])) complaints.push(`asks elsewhere: ${request.url()}`); });
  await page.goto(link);
  return {
    page, complaints,
    text: (id) => page.textContent(`#${id}`),
    async says(id, part) {
      try {
        await page.waitForFunction(([name, words]) => document.getElementById(name).textContent.includes(words) && !document.getElementById(name).hidden, [id, part]);
      } catch {
        throw new Error(`#${id} never says "${part}"; it says "${await page.textContent(`#${id}`)}"`);
      }
    },
    // What was told, also after it was hidden again.
    told: (part) => page.waitForFunction((words) => document.getElementById('told').textContent.includes(words), part),
    hidden: (id) => page.waitForFunction((name) => document.getElementById(name).hidden, id),
    shown: (id) => page.waitForFunction((name) => !document.getElementById(name).hidden, id),
  };
}
