// Draws docs/pictures/page.png from a simulated run: node picture.mjs PROGRAM CHROMIUM FILE.
import { Bench, launch, until, viewer } from './bench.mjs';

const [program, browserPath, file] = process.argv.slice(2);
const bench = new Bench(program);
let browser;
try {
  bench.call('sensors', 'add', 'S-1', '--type', 'sensor.toml');
  const words = ['ascending', '--bench', 'bench.toml', '--sensor', 'S-1', '--operator', 'me', '-q'];
  bench.call('run', ...words, '--set', 'recipe.repeats=1');
  const server = await bench.page('--operator', 'me');
  browser = await launch(browserPath);
  const one = await viewer(browser, server.link, { width: 1280, height: 1120 });
  bench.start('run', ...words, '--seed', '2', '--rate', '100');
  await one.says('state', 'running');
  await until(async () => /frame 3\d\d /.test(await one.text('picture-title')), 'three hundred frames');
  await one.page.screenshot({ path: file });
} finally {
  if (browser) await browser.close();
  bench.end();
}
