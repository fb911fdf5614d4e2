// What the page shows beside a pressure run: the compensated picture, force and stage, the night, the demonstration, and a
// question that is asked in a terminal too: node views.test.mjs PROGRAM CHROMIUM.
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { Bench, launch, until, viewer } from './bench.mjs';

const [program, browserPath] = process.argv.slice(2);
const kRecipe = 'schema = 1\nname = "asked"\nunit = "psi"\nturning_points = [0, 20, 0]\nstep = 10\ndwell_s = 1\n[conditioning]\ncycles = 0\n[prompt]\nbefore = "Is the sensor clamped?"\n';
const kPress = 'schema = 1\nname = "press"\nkind = "press"\ndwell_s = 1\nrepeats = 20\n[press]\nobject = "ring"\npositions_mm = [[30.0, 30.0]]\nforces_n = [2, 6]\nhold = "position"\n'
  + 'approach_mm_per_s = 0.5\ncontact_n = 0.2\nservo_mm_per_s = 0.05\nclear_mm = 5.0\ntare = true\n[conditioning]\ncycles = 0\npeak_n = 6\n';
const kNight = 'schema = 1\nname = "small"\n\n[[scenario]]\nname = "one"\nabout = "two frames"\nrecipes = ["zero-check"]\nfits = false\n';

const bench = new Bench(program);
const steps = [];
let browser, one;

async function step(name, act) {
  const begun = Date.now();
  await act();
  steps.push(`${((Date.now() - begun) / 1000).toFixed(1).padStart(5)} s  ${name}`);
}

const run = (...words) => bench.start('run', ...words, '--bench', 'bench.toml', '--sensor', 'V-1', '--operator', 'tess', '--no-seating', '-q');

try {
  bench.write('asked.toml', kRecipe);
  bench.write('press.toml', kPress);
  bench.write('night.toml', kNight);
  bench.call('sensors', 'add', 'V-1', '--type', 'sensor.toml');
  bench.call('run', 'descending', '--bench', 'bench.toml', '--sensor', 'V-1', '--operator', 'tess', '--no-seating', '-q', '--set', 'recipe.repeats=1');
  bench.call('fit', '1', '-q');
  bench.call('nightly', 'night.toml', '--db', 'night.db', '--html', 'night.html', '-q');
  const server = await bench.page('--operator', 'bob', '--night', 'night.html');
  browser = await launch(browserPath);
  one = await viewer(browser, server.link);

  await step('compensated: the picture in psi, by the models of the earlier run', async () => {
    const running = run('ascending', '--set', 'recipe.repeats=50', '--rate', '60');
    await until(() => one.page.isEnabled('#show-psi'), 'the compensated picture can be chosen');
    await one.page.click('#show-psi');
    await one.says('picture-title', 'of run 1');
    assert.equal(await one.page.getAttribute('#show-psi', 'aria-pressed'), 'true');
    await one.page.click('#map', { position: { x: 60, y: 60 } });
    // One taxel's corrected indication follows the reference, where the pressure is on.
    await one.page.waitForFunction(() => {
      const psi = document.getElementById('taxel-words').textContent.match(/([\d.]+) psi compensated/);
      const reference = document.getElementById('readings').textContent.match(/reference\s*([\d.]+)/);
      return psi && reference && Number(reference[1]) > 20 && Math.abs(Number(psi[1]) - Number(reference[1])) < 3;
    });
    running.kill('SIGTERM');
    await running.ended;
  });

  await step('force and stage of a run that presses', async () => {
    const running = run('press.toml', '--rate', '20');
    await one.shown('press');
    for (const name of ['Fz', 'Tz', 'z']) await one.says('press-values', name);
    await one.says('trace-title', 'Force');
    // The loop of forces alone: that of the pressures before has other axes.
    await one.page.waitForFunction(() => /force.*: run \d+, [1-9]\d* frames$/.test(document.getElementById('loop').getAttribute('aria-label')));
    running.kill('SIGTERM');
    await running.ended;
  });

  await step('question in a terminal: the page answers, and the terminal is told', async () => {
    const words = ['run', 'asked.toml', '--bench', 'bench.toml', '--sensor', 'V-1', '--operator', 'tess', '--no-seating'];
    const terminal = bench.start_in_terminal(...words);
    await one.says('question', 'Is the sensor clamped?');
    await until(() => terminal.said.includes('Is the sensor clamped?'), 'the terminal asks');
    await one.page.fill('#answer-text', 'clamped');
    await one.page.click('#answer button');
    await until(() => terminal.said.includes('bob'), 'the terminal names who answered');
    await terminal.ended;
    await one.says('state', 'completed');
  });

  await step('night: the table that nightly wrote', async () => {
    await one.page.click('[data-view=night]');
    await one.page.frameLocator('iframe').getByText('small').first().waitFor();
  });
  assert.deepEqual(one.complaints, []);

  await step('demo: an address at once, and the run in it', async () => {
    const demo = bench.start('demo', '--page', '--rate', '150', '--db', 'demo.db', '-o', 'demo.html');
    await until(() => /page: (http\S+)/.test(demo.said) || demo.exitCode !== null, 'demo names its page');
    const watched = await viewer(browser, demo.said.match(/page: (http\S+)/)[1]);
    await watched.says('state', 'running');
    await watched.shown('simulated');
    await watched.page.waitForFunction(() => /\d:\d\d:\d\d/.test(document.getElementById('left').textContent));
    await watched.says('picture-title', 'frame ');
    assert.deepEqual(watched.complaints, []);
    assert.ok(existsSync(join(bench.folder, 'demo.db')));
    demo.kill('SIGTERM');
    await demo.ended;
  });
  console.log(steps.join('\n'));
} catch (error) {
  console.log(steps.join('\n'));
  console.error(error);
  process.exitCode = 1;
} finally {
  if (browser) await browser.close();
  bench.end();
}
