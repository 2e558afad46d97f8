// Converts a generated plant to 3D Tiles, validates every .glb by the Khronos validator, shows the tiles by
// 3d-tiles-renderer in headless Chromium, and compares the image with that of sightline-render.
//   node run.mjs - FOLDER     for what it makes
import { spawnSync } from 'node:child_process';
import { mkdirSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { modules, need, programPath, sources } from '../browser.mjs';

const kItems = 5000;
const kMostFlip = 0.02; // mean, of all pixels: edges differ

const here = dirname(fileURLToPath(import.meta.url));
const folder = process.argv[3] ?? join(sources, 'build', 'tests', 'wasm-tiles');
const programs = ['generate', 'convert', 'render'].map((name) => programPath(`sightline-${name}`));
need(...programs, ...['3d-tiles-renderer', 'gltf-validator', 'playwright-core'].map((name) => join(modules, name)));
const [generate, convert, render] = programs;

function run(command, ...args) {
  const done = spawnSync(command, args, { stdio: ['ignore', 'pipe', 'inherit'], encoding: 'utf8' });
  if (done.status === 0) return done.stdout;
  console.log(`FAILED: ${command} ${args.join(' ')}\n${done.stdout}`);
  process.exit(1);
}
const script = (name, ...args) => run(process.execPath, join(here, name), ...args);

rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
const at = (name) => join(folder, name);
run(generate, '--items', String(kItems), at('plant.slc'));
// As the validator sees numbers: without compression all of them.
for (const [name, ...options] of [['plain', '--uncompressed'], ['rows', '--collections'], ['tiles']]) {
  run(convert, at('plant.slc'), at(name), '--tiles', '--tolerance', '0.005', ...options);
  console.log(`${name}: ${script('validate.mjs', at(name)).trim()}`);
}

const view = { eye: [-60, -45, 35], target: [0, 0, 5], up: [0, 0, 1], fovy_deg: 50, near: 0.1, far: 1000 };
writeFileSync(at('view.json'), JSON.stringify(view));
console.log(script('show.mjs', at('tiles'), at('view.json'), at('viewer.png'), '--size', '640x360').trim());
run(render, at('plant.slc'), '--plain', '--view', at('view.json'), '--size', '640x360', '--out', at('sightline.png'),
  '--compare', at('viewer.png'), '--mean', '255', '--json', at('compare.json'));
const flip = JSON.parse(run(process.execPath, '-p', `JSON.stringify(require(${JSON.stringify(at('compare.json'))}))`)).compare.flip.mean;
console.log(`mean FLIP ${flip.toFixed(5)}, at most ${kMostFlip}`);
if (flip <= kMostFlip) process.exit(0);
console.log(`FAILED: look at ${at('viewer.png')} and ${at('sightline.png')}`);
process.exit(1);
