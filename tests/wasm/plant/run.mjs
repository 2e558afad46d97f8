// Draws plants in headless Chromium, with culling and without, and compares them with images of the native tools
// (page.js). Models are generated; real ones come from SIGHTLINE_DATA.
//   node run.mjs - FOLDER     for models, images of the tools, and the page's own beside them
import { spawnSync } from 'node:child_process';
import { copyFileSync, mkdirSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';

import { dataPath, modules, need, npmPackage, programPath, runTest, sources } from '../browser.mjs';

const three = join(modules, 'three', 'build');
const [generate, info, render, trace] = ['generate', 'info', 'render', 'trace'].map((name) =>
  programPath(`sightline-${name}`),
);
need(three, join(npmPackage, 'js', 'three.js'), generate, info, render, trace);
const folder = process.argv[3] ?? join(sources, 'build', 'tests', 'wasm-plant');
mkdirSync(folder, { recursive: true });

function run(program, ...args) {
  const done = spawnSync(program, args, { encoding: 'utf8' });
  if (done.status !== 0) throw new Error(`${program} ${args.join(' ')}: ${done.stderr}`);
  return done.stdout;
}

const files = ['plant.rvm', 'plant.slc'].map((name) => {
  run(generate, '--items', '2000', '--seed', '3', join(folder, name));
  return name;
});
for (const name of ['HA-MECH.RVM', 'HA-PIPE.RVM', 'WD1-PSUP.RVM']) {
  const path = dataPath(join('huldra', name));
  if (path) copyFileSync(path, join(folder, name));
  if (path) files.push(name);
  else console.log(`without huldra/${name}, which is not below SIGHTLINE_DATA`);
}

const models = files.map((file) => {
  const numbers = run(info, join(folder, file)).match(/^bounds +(.*?) +to +(.*?) m$/m);
  const [low, high] = [numbers[1], numbers[2]].map((corner) => corner.trim().split(/ +/).map(Number));
  const middle = low.map((x, i) => (x + high[i]) / 2);
  const half = low.map((x, i) => (high[i] - x) / 2);
  const at = (x, y, z) => [x, y, z].map((share, i) => middle[i] + share * half[i]);
  const size = Math.hypot(...half);
  const range = { near: 0.01 * size, far: 5 * size };
  const views = [
    { eye: at(-1.5, -1.5, 1.8), target: middle, fovy_deg: 40, ...range },
    { eye: at(0.3, -0.4, 0.5), target: at(-0.5, 0.6, -0.2), fovy_deg: 75, ...range, near: 0.001 * size },
    { eye: at(0.5, -2, 1.5), target: middle, ortho_height: size, ...range },
    {
      ...{ eye: at(1.5, 1.2, 1.4), target: middle, fovy_deg: 50, ...range },
      sections: [{ n: [-0.6, 0, -0.8], d: 0.6 * middle[0] + 0.8 * middle[2] }],
    },
  ].map((view, i) => {
    const name = `${basename(file)}_${i}`;
    const path = (suffix) => join(folder, `${name}${suffix}`);
    writeFileSync(path('.json'), JSON.stringify({ up: [0, 0, 1], ...view }));
    const common = [join(folder, file), '--view', path('.json')];
    run(trace, ...common, '--size', '64x48', '--ids', path('_ids.png'));
    run(render, ...common, '--size', '640x480', '--plain', '--out', path('_native.png'));
    return { name, ...view };
  });
  return { file, low, high, views };
});
writeFileSync(join(folder, 'models.json'), JSON.stringify(models));

await runTest({
  page: '/test/plant/page.html',
  roots: { three, sightline: npmPackage, test: join(sources, 'tests', 'wasm'), made: folder },
  folder,
});
