// Draws the scenes of wasm_primitives_scenes with three.js in headless Chromium and compares every pixel (page.js).
//   node run.mjs SCENES_PROGRAM FOLDER
// writes what it needs, and images of the first wrong scenes, to FOLDER. SIGHTLINE_IMAGES=1 keeps images of all scenes.
import { spawnSync } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import { join } from 'node:path';

import { modules, need, npmPackage, runTest, sources } from '../browser.mjs';

const three = join(modules, 'three', 'build');
const [program, folder] = process.argv.slice(2);
need(three, program, join(npmPackage, 'js', 'primitives.js'));
mkdirSync(folder, { recursive: true });
const { status } = spawnSync(program, [join(folder, 'scenes')], { stdio: 'inherit' });
if (status !== 0) throw new Error(`${program} failed`);
await runTest({
  page: `/test/page.html${process.env.SIGHTLINE_IMAGES ? '?images' : ''}`,
  roots: { three, sightline: join(npmPackage, 'js'), test: join(sources, 'tests', 'wasm', 'primitives'), made: folder },
  folder,
});
