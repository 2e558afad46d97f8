// Culls scenes of three.js in headless Chromium, and compares images and picks with those without culling (page.js).
//   node run.mjs - FOLDER     for images of the first wrong views
import { join } from 'node:path';

import { modules, need, npmPackage, runTest, sources } from '../browser.mjs';

const three = join(modules, 'three', 'build');
need(three, join(npmPackage, 'js', 'three.js'));
await runTest({
  page: '/test/three/page.html',
  roots: { three, sightline: npmPackage, test: join(sources, 'tests', 'wasm') },
  folder: process.argv[3] ?? join(sources, 'build', 'tests', 'wasm-three'),
});
