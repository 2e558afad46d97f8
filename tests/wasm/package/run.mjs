// Uses the package as others do: installs what `npm pack` makes in a project of its own, compiles TypeScript that uses
// it, runs that in node, builds a page with Vite and opens it in headless Chromium. Needs the npm registry once.
//   node run.mjs - FOLDER     which the project is made in
import { spawnSync } from 'node:child_process';
import { cpSync, existsSync, mkdirSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

import { need, npmPackage, runTest, sources } from '../browser.mjs';

need(npmPackage);
const project = join(dirname(fileURLToPath(import.meta.url)), 'project');
const folder = process.argv[3] ?? join(sources, 'build', 'tests', 'wasm-package');

function run(command, ...args) {
  const done = spawnSync(command, args, { cwd: folder, encoding: 'utf8' });
  if (done.status === 0) return done.stdout;
  console.log(`FAILED: ${command} ${args.join(' ')}\n${done.stdout}${done.stderr}`);
  process.exit(1);
}

mkdirSync(folder, { recursive: true });
for (const made of ['compiled', 'dist', join('node_modules', 'sightline')])
  rmSync(join(folder, made), { recursive: true, force: true });
cpSync(project, folder, { recursive: true });
const installed = join(folder, 'node_modules', '.installed');
const lock = join(project, 'package-lock.json');
if (!existsSync(installed) || !readFileSync(installed).equals(readFileSync(lock))) {
  run('npm', 'ci', '--silent', '--no-audit', '--no-fund');
  cpSync(lock, installed);
}
const archive = run('npm', 'pack', '--silent', '--pack-destination', folder, npmPackage).trim();
run('npm', 'install', '--silent', '--no-audit', '--no-fund', '--no-save', '--prefer-offline', `./${archive}`);

const bin = (name) => join(folder, 'node_modules', '.bin', name);
run(bin('tsc'), '--project', '.');
console.log(run(process.execPath, join('compiled', 'node.js')).trim());
const vite = run(bin('vite'), 'build', '--logLevel', 'warn');
if (vite.trim() !== '') console.log(vite);
const assets = readdirSync(join(folder, 'dist', 'assets'));
console.log(`Vite made ${assets.join(', ')}`);
if (!assets.some((name) => name.endsWith('.wasm'))) {
  console.log('FAILED: Vite found no .wasm file');
  process.exit(1);
}
// Packages are built with threads or without.
const alone = assets.some((name) => name.includes('.threads-')) ? '' : '#alone';
await runTest({ page: `/page/${alone}`, roots: { page: join(folder, 'dist') }, folder, minutes: 2 });
