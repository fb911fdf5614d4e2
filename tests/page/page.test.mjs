// The page in a browser, from a run's first question to its end: node page.test.mjs PROGRAM CHROMIUM.
import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { readFileSync } from 'node:fs';
import { Bench, launch, until, viewer } from './bench.mjs';

const [program, browserPath] = process.argv.slice(2);
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const kSensor = '<img src=x onerror=alert(1)>';
const recipe = (name, more) => `schema = 1\nname = "${name}"\nunit = "psi"\nturning_points = [0, 40, 0, 40, 0]\nstep = 5\ndwell_s = 1\n${more}`;

const steps = [];
async function step(name, act) {
  const begun = Date.now();
  await act();
  steps.push(`${((Date.now() - begun) / 1000).toFixed(1).padStart(5)} s  ${name}`);
}

async function accessible(one, where) {
  await one.page.evaluate(axe);
  const { violations } = await one.page.evaluate(() => window.axe.run(document, { resultTypes: ['violations'], iframes: false }));
  const words = violations.map((v) => `${v.id}: ${v.help} (${v.nodes.map((n) => n.target.join(' ')).join(', ')})`);
  assert.deepEqual(words, [], `axe-core on ${where}`);
}

// Nothing is wider than its place on the screen, tables neither.
async function fits(one, where) {
  const wide = await one.page.evaluate(() => [document.documentElement, ...document.querySelectorAll('.wide')].filter((node) => node.scrollWidth > node.clientWidth).length);
  assert.equal(wide, 0, `${where} is cut`);
}

const bench = new Bench(program);
let browser;
try {
  bench.write('asked.toml', recipe('asked', 'repeats = 1\n[dwell]\ntolerance_s = 600\n[conditioning]\ncycles = 0\n[prompt]\nbefore = "Is the cable <b>plugged in</b>?"\n'));
  bench.write('long.toml', recipe('long', 'repeats = 1000\n[dwell]\ntolerance_s = 600\n[conditioning]\ncycles = 1\npeak = 40\n'));
  bench.write('short.toml', recipe('short', 'repeats = 1\n'));
  bench.call('sensors', 'add', kSensor, '--type', 'sensor.toml');
  const run = (...words) => bench.start('run', ...words, '--bench', 'bench.toml', '--sensor', kSensor, '--operator', 'tess', '--no-seating', '-q');
  const server = await bench.page('--operator', 'bob');
  browser = await launch(browserPath);
  let desk, phone, second, running;

  await step('an empty store says what to do', async () => {
    desk = await viewer(browser, server.link);
    await desk.says('state', 'waiting');
    await accessible(desk, 'the empty page');
    assert.ok(!(await desk.page.url()).includes(server.link.split('#')[1]), 'the keys left the address');
    desk.complaints.length = 0;
  });

  await step('a question appears without a reload, and of two answers one wins', async () => {
    running = run('asked.toml', 'long.toml', '--rate', '30');
    second = await viewer(browser, server.link, { dark: true });
    phone = await viewer(browser, server.readers_link, { width: 390, height: 844, dark: true });
    for (const one of [desk, second, phone]) await one.says('question', 'Is the cable <b>plugged in</b>?');
    await phone.says('prompt-note', 'tactbench resume');
    await desk.says('state', 'paused');
    await desk.page.waitForSelector('#safe.proved');
    await accessible(desk, 'a question');
    for (const [i, one] of [desk, second].entries()) await one.page.fill('#answer-text', `by viewer ${i}`);
    // Clicked on both, also where the other's answer has come first and the question is gone.
    await Promise.all([desk, second].map((one) => one.page.evaluate(() => document.querySelector('#answer button').click())));
    for (const one of [phone, desk, second]) await one.told('bob');
    let notes;
    await until(async () => {
      notes = await Promise.all([desk, second].map((one) => one.text('command-note')));
      return notes.every((note) => note && !note.includes('sent'));
    }, 'both have a reply to their answer');
    assert.notEqual(notes[0], notes[1], 'one was taken, the other was not');
  });

  await step('the run is seen: state, readings, picture, loop, progress', async () => {
    await desk.says('state', 'running');
    for (const one of [desk, phone]) await one.says('picture-title', 'frame ');
    await desk.says('which', kSensor);
    await desk.says('readings', 'reference');
    await desk.shown('simulated');
    await desk.page.waitForFunction(() => document.getElementById('loop').getAttribute('aria-label').match(/([1-9]\d+) frames/));
    await desk.page.click('#map', { position: { x: 60, y: 60 } });
    await desk.says('taxel-words', ' V');
    await desk.says('loop-title', 'row ');
    for (const [one, where] of [[desk, 'the desk'], [phone, 'the phone'], [second, 'the dark desk']]) {
      await accessible(one, where);
      await fits(one, where);
    }
  });

  await step('pause and resume from the page, with the safe state in words', async () => {
    await desk.page.click('[data-word=pause]');
    await desk.says('command-note', 'pauses');
    await desk.says('state', 'paused');
    await phone.page.waitForSelector('#safe.proved');
    await desk.page.click('[data-word=resume]');
    await desk.says('command-note', 'continues');
    await desk.says('state', 'running');
    assert.ok(!await phone.page.isVisible('[data-word=pause]'), 'a reader cannot command');
  });

  await step('old data looks old: a stopped run, a stopped page', async () => {
    running.kill('SIGSTOP');
    await desk.shown('old');
    await desk.page.waitForFunction(() => document.body.classList.contains('stale'));
    running.kill('SIGCONT');
    await desk.hidden('old');
    server.child.kill('SIGSTOP');
    await desk.shown('old');
    server.child.kill('SIGCONT');
    await desk.hidden('old');
    assert.ok(!(await desk.page.evaluate(() => document.body.classList.contains('stale'))));
  });

  await step('a killed run is seen to be broken off, and its return is seen', async () => {
    running.kill('SIGKILL');
    await desk.says('state', 'broken off');
    await desk.page.waitForSelector('#safe.unknown');
    running = bench.start('resume', '1', '-q');
    await desk.says('state', 'running');
    await until(() => desk.page.isEnabled('[data-word=stop]'), 'it can be stopped');
    await desk.page.click('[data-word=stop]');
    await desk.page.click('#sure-yes');
    await desk.says('state', 'stopped');
    await desk.page.waitForSelector('#safe.proved');
    assert.equal(await running.ended, 4);
  });

  await step('a fault is seen with what to do about it', async () => {
    bench.write('sound.toml', bench.read('bench.toml'));
    bench.append('bench.toml', '\n[[simulation.faults]]\nkind = "scanner_silent"\nat_psi = 20\n');
    const faulty = run('long.toml', '--rate', '200');
    await desk.says('state', 'failed');
    await desk.page.waitForSelector('#events .fault .try');
    assert.equal(await faulty.ended, 3, faulty.said);
  });

  await step('runs, a run with its report, two beside each other, a sensor', async () => {
    for (const seed of ['3', '4'])
      bench.call('run', 'short.toml', '--bench', 'sound.toml', '--sensor', kSensor, '--operator', 'tess', '--no-seating', '-q', '--seed', seed);
    await desk.page.click('[data-view=runs]');
    await desk.page.waitForSelector('#view-store tbody tr');
    assert.equal(await desk.page.locator('#view-store tbody tr').count(), 4);
    await desk.page.fill('input[type=search]', 'failed');
    assert.equal(await desk.page.locator('#view-store tbody tr').count(), 1);
    await desk.page.fill('input[type=search]', '');
    await accessible(desk, 'the runs');
    for (const run of [3, 4]) await desk.page.check(`[aria-label="compare run ${run}"]`);
    await desk.page.click('text=Compare two runs');
    await desk.page.frameLocator('iframe').getByRole('heading', { name: 'Comparison of two runs' }).waitFor();
    await desk.page.goto(`${server.link.split('#')[0]}#/run/3`);
    await desk.page.frameLocator('iframe').locator('h1').waitFor();
    await accessible(desk, 'a run');
    await desk.page.click('.facts a');
    await desk.page.waitForFunction((serial) => document.querySelector('#view-store h1')?.textContent === serial, kSensor);
    await phone.page.click('[data-view=sensors]');
    await phone.page.waitForSelector('#view-store tbody a');
    await accessible(phone, 'the sensors');
    await fits(phone, 'the sensors on the phone');
    await phone.hidden('night');
    await phone.page.evaluate(() => { location.hash = '#/%E0%A4%A'; });  // a broken escape is no place
    await phone.shown('view-now');
  });

  await step('a calibration’s verdict: on Now, in Runs, of the sensor, on the phone; the held-out run leads to the report', async () => {
    bench.call('calibrate', 'C-1', '--type', 'sensor.toml', '--bench', 'sound.toml', '--operator', 'tess', '-q');
    const { runs: all } = JSON.parse(bench.call('runs', 'list', '--sensor', 'C-1', '--json'));
    const [models, heldOut] = all.map((run) => run.run).sort((a, b) => a - b);
    await desk.page.goto(`${server.link.split('#')[0]}#/now`);
    await phone.page.goto(`${server.link.split('#')[0]}#/now`);
    for (const one of [desk, phone]) await one.page.waitForSelector(`#verdict a[href="#/run/${models}"]`);
    await desk.page.waitForFunction(() => document.querySelector('#loop').getBoundingClientRect().bottom < window.innerHeight);
    await accessible(desk, 'a verdict');
    for (const [place, rows] of [['runs', 6], ['sensors', 2]]) {
      await phone.page.click(`[data-view=${place}]`);
      await phone.page.waitForFunction((count) => document.querySelectorAll('#view-store tbody tr').length === count, rows);
      assert.ok(await phone.page.locator('tbody .badge').count() > 0);
      await fits(phone, `${place} on the phone`);
    }
    await desk.page.goto(`${server.link.split('#')[0]}#/run/${heldOut}`);
    await desk.page.waitForSelector(`.judged a[href="#/run/${models}"]`);
    await desk.page.waitForSelector('iframe');
    assert.equal(await desk.page.getByText('tactbench fit').count(), 0);
  });

  for (const [one, name] of [[desk, 'desk'], [second, 'second'], [phone, 'phone']]) assert.deepEqual(one.complaints, [], `the console of ${name}`);
  const delays = await second.page.evaluate(() => window.tactbench.delays.slice().sort((a, b) => a - b));
  steps.push(`FIGURE page_event_to_pixels_p95 ${delays[Math.floor(0.95 * delays.length)].toFixed(0)} ms, of ${delays.length} pictures`);
  const events = JSON.parse(bench.call('runs', 'show', '1', '--json')).events.map((event) => event.detail).join('\n');
  for (const word of ['answered', 'asked', 'resumed', 'stopped']) assert.ok(events.includes(`${word} by bob`), `the run's events name who: ${word}`);
  console.log(steps.join('\n'));
} catch (error) {
  console.log(steps.join('\n'));
  console.error(error);
  process.exitCode = 1;
} finally {
  if (browser) await browser.close();
  bench.end();
}
