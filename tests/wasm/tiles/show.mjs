// Shows a tileset in headless Chromium and saves the image. Prints what the page tells, as JSON. Exit code 1 where a tile
// cannot be loaded, or content lies outside its box.
import { readFile, writeFile } from 'node:fs/promises';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

import { chromium as executablePath, modules, required, serve } from '../browser.mjs';

const { chromium } = required('playwright-core');

const here = path.dirname(fileURLToPath(import.meta.url));
const options = { '--size': '1280x720', '--error': '1' };
const names = [];
for (let i = 2; i < process.argv.length; ++i) {
  if (process.argv[i] in options) options[process.argv[i]] = process.argv[++i];
  else names.push(process.argv[i]);
}
if (names.length !== 3) {
  console.error('show.mjs: expected TILES_FOLDER VIEW.json OUT.png [--size WxH] [--error PX]');
  process.exit(2);
}
const [folder, viewFile, image] = names;
const [width, height] = options['--size'].split('x').map(Number);

const { url: site, close } = await serve({ modules, tileset: folder, test: here });

const browser = await chromium.launch({
  executablePath,
  args: ['--no-sandbox', '--disable-quic', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
});
let failed = true;
try {
  const page = await browser.newPage({ viewport: { width, height } });
  const errors = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
  await page.goto(`${site}/test/viewer.html`);
  await page.waitForFunction(() => window.ready, null, { timeout: 30e3 });
  const view = JSON.parse(await readFile(viewFile, 'utf8'));
  const facts = await page.evaluate((of) => window.show(of), {
    tileset: `${site}/tileset/tileset.json`, view, width, height, error: Number(options['--error']),
  });
  const shot = await page.evaluate(() => document.querySelector('canvas').toDataURL('image/png'));
  await writeFile(image, Buffer.from(shot.split(',')[1], 'base64'));
  console.log(JSON.stringify({ ...facts, errors }));
  failed = errors.length > 0 || facts.failures.length > 0 || facts.outside.most > 1e-6;
} finally {
  await browser.close();
  close();
}
process.exit(failed ? 1 : 0);
