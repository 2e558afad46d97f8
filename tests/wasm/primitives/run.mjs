// Draws the scenes of wasm_primitives_scenes with three.js in headless Chromium and compares every pixel (page.js).
//   node run.mjs SCENES_PROGRAM FOLDER
// writes what it needs, and images of the first wrong scenes, to FOLDER. SIGHTLINE_NODE_MODULES names the folder where
// three is installed, SIGHTLINE_CHROMIUM the browser, SIGHTLINE_IMAGES=1 keeps images of all scenes.
import {spawn, spawnSync} from 'node:child_process';
import {existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {createServer} from 'node:http';
import {tmpdir} from 'node:os';
import {dirname, extname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const bindings = join(here, '..', '..', '..', 'bindings', 'wasm');
const [program, folder] = process.argv.slice(2);
const modules = process.env.SIGHTLINE_NODE_MODULES ?? join(here, 'node_modules');
const chromium = process.env.SIGHTLINE_CHROMIUM ?? '/usr/bin/chromium';
const three = join(modules, 'three', 'build');
for (const [path, what] of [[three, 'no three.js (SIGHTLINE_NODE_MODULES)'], [chromium, 'no browser (SIGHTLINE_CHROMIUM)']]) {
  if (existsSync(path)) continue;
  console.log(`SKIPPED: ${what}: ${path}`);
  process.exit(0);
}

function must(command, ...args) {
  const done = spawnSync(command, args, {stdio: 'inherit'});
  if (done.status !== 0) throw new Error(`${command} ${args.join(' ')} failed`);
}
mkdirSync(folder, {recursive: true});
must(program, join(folder, 'scenes'));
must(process.execPath, join(bindings, 'shaders', 'generate.mjs'), join(folder, 'shaders.js'));

const roots = {
  'three': three,
  'sightline': join(bindings, 'js'),
  'test': here,
  'made': folder,
};
const types = {'.js': 'text/javascript', '.html': 'text/html', '.json': 'application/json'};

function body(request) {
  return new Promise((resolve) => {
    const pieces = [];
    request.on('data', (piece) => pieces.push(piece)).on('end', () => resolve(Buffer.concat(pieces)));
  });
}

let finish;
const finished = new Promise((resolve) => finish = resolve);
const server = createServer(async (request, response) => {
  const path = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
  const [, root, ...rest] = path.split('/');
  if (request.method === 'POST') {
    const content = await body(request);
    if (root === 'log') console.log(content.toString());
    if (root === 'image') writeFileSync(join(folder, `${rest[0]}.png`), content);
    response.end();
    if (root === 'result') finish(JSON.parse(content));
    return;
  }
  // shaders.js lies beside primitives.js in the package.
  const file = path === '/sightline/shaders.js' ? join(folder, 'shaders.js') : join(roots[root] ?? '/nowhere', ...rest);
  if (!existsSync(file)) {
    response.writeHead(404).end();
    return;
  }
  response.writeHead(200, {'Content-Type': types[extname(file)] ?? 'application/octet-stream'});
  response.end(readFileSync(file));
});
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));

const profile = mkdtempSync(join(tmpdir(), 'chromium-'));
const images = process.env.SIGHTLINE_IMAGES ? '?images' : '';
const browser = spawn(chromium, [
  '--headless', '--no-sandbox', '--no-first-run', '--disable-quic', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  `--user-data-dir=${profile}`, `http://127.0.0.1:${server.address().port}/test/page.html${images}`,
], {stdio: 'ignore', detached: true});  // a group, whose processes end together
browser.on('exit', (code) => finish({failed: 1, summary: `the browser ended with ${code}`}));
const late = setTimeout(() => finish({failed: 1, summary: 'the browser did not answer within 9 minutes'}), 540000);
const result = await finished;
clearTimeout(late);
browser.removeAllListeners('exit');
const ended = new Promise((resolve) => browser.exitCode === null && browser.signalCode === null ? browser.on('exit', resolve) : resolve());
try {
  process.kill(-browser.pid, 'SIGKILL');
} catch {
  // It has ended.
}
await ended;
try {
  rmSync(profile, {recursive: true, force: true, maxRetries: 10, retryDelay: 200});
} catch (error) {
  console.log(`${profile} is left: ${error.message}`);
}
server.close();
console.log(result.summary);
process.exit(result.failed > 0 ? 1 : 0);
