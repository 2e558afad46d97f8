// Validates each .glb of a folder of 3D Tiles by the Khronos validator. Exit code 1 where it finds an error or a warning.
import { readFile, readdir } from 'node:fs/promises';
import path from 'node:path';

import { required } from '../browser.mjs';

const validator = required('gltf-validator');

const folder = process.argv[2];
if (!folder) {
  console.error('validate.mjs: expected the folder of a tileset');
  process.exit(2);
}

// The validator does not know these extensions, and says so.
const expected = new Set(['UNSUPPORTED_EXTENSION', 'UNUSED_OBJECT']);

const names = (await readdir(path.join(folder, 'tiles'))).filter((name) => name.endsWith('.glb')).sort();
const counts = { files: names.length, errors: 0, warnings: 0, infos: 0, hints: 0 };
const codes = new Map();
for (const name of names) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(path.join(folder, 'tiles', name))), {
    uri: name,
    maxIssues: 100,
  });
  for (const { code, severity, message, pointer } of report.issues.messages) {
    codes.set(code, (codes.get(code) ?? 0) + 1);
    if (severity > 1 || expected.has(code)) continue;
    console.error(`${name}: ${pointer ?? ''}: ${code}: ${message}`);
    counts[severity === 0 ? 'errors' : 'warnings'] += 1;
  }
  counts.infos += report.issues.numInfos;
  counts.hints += report.issues.numHints;
}
console.log(JSON.stringify({ ...counts, codes: Object.fromEntries(codes) }));
process.exit(counts.errors + counts.warnings > 0 || names.length === 0 ? 1 : 0);
