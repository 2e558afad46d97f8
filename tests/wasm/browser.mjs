// Runs a page of a test in headless Chromium. The page gets files below /NAME/ from the folders that `roots` names, and
// sends text to /log, images to /image/NAME, and at its end {failed, summary} to /result.
//
// SIGHTLINE_CHROMIUM names the browser, SIGHTLINE_NODE_MODULES the folder where three is installed.
import { spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { dirname, extname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

export const sources = join(dirname(fileURLToPath(import.meta.url)), '..', '..');
export const chromium = process.env.SIGHTLINE_CHROMIUM ?? '/usr/bin/chromium';
export const modules =
  process.env.SIGHTLINE_NODE_MODULES ?? join(sources, 'build', 'npm', 'tools', 'node_modules');
export const npmPackage = process.env.SIGHTLINE_PACKAGE ?? join(sources, 'build', 'npm', 'sightline');

/** A package of that folder. */
export const required = createRequire(join(modules, 'of-tests.js'));

/** The path of a program of this build, or null. */
export function programPath(name) {
  const path = join(process.env.SIGHTLINE_BIN ?? join(sources, 'build', 'release', 'bin'), name);
  return existsSync(path) ? path : null;
}

/** The path of a file below SIGHTLINE_DATA, or below ../shared/data beside the sources; null without it. */
export function dataPath(name) {
  const path = join(process.env.SIGHTLINE_DATA ?? join(sources, '..', 'shared', 'data'), name);
  return existsSync(path) ? path : null;
}

/** Ends the test as one that cannot run, unless all of these paths exist. In CI that is a failure. */
export function need(...paths) {
  for (const path of [chromium, ...paths]) {
    if (path && existsSync(path)) continue;
    console.log(`SKIPPED: not found: ${path}`);
    process.exit(process.env.CI ? 1 : 0);
  }
}

const types = {
  '.css': 'text/css',
  '.html': 'text/html',
  '.js': 'text/javascript',
  '.json': 'application/json',
  '.mjs': 'text/javascript',
  '.wasm': 'application/wasm',
};

const kIsolation = { 'Cross-Origin-Embedder-Policy': 'require-corp', 'Cross-Origin-Opener-Policy': 'same-origin' };

/**
 * Serves the files below /NAME/ from the folder roots[NAME]. `post(root, rest, content)` gets what is sent. `isolated`: cross-origin
 * isolated, as threads need it.
 */
export async function serve(roots, post, isolated = true) {
  const server = createServer((request, response) => {
    const path = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
    const [, root, ...rest] = path.split('/');
    if (request.method === 'POST') {
      const pieces = [];
      request.on('data', (piece) => pieces.push(piece));
      request.on('end', () => {
        response.end();
        post(root, rest, Buffer.concat(pieces));
      });
      return;
    }
    let file = join(roots[root] ?? '/nowhere', ...rest);
    if (existsSync(file) && statSync(file).isDirectory()) file = join(file, 'index.html');
    if (rest.includes('..') || !existsSync(file)) return void response.writeHead(404).end();
    response.writeHead(200, {
      'Content-Type': types[extname(file)] ?? 'application/octet-stream',
      ...(isolated ? kIsolation : {}),
    });
    response.end(readFileSync(file));
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { url: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

/** Opens a page until it sends its result. Images are written to `folder`. */
export async function runPage({ page, roots, folder, size = '800,600', minutes = 9, isolated = true }) {
  mkdirSync(folder, { recursive: true });
  let finish;
  const finished = new Promise((resolve) => (finish = resolve));
  const server = await serve(roots, (root, rest, content) => {
    if (root === 'log') console.log(content.toString());
    if (root === 'image') writeFileSync(join(folder, `${rest[0]}.png`), content);
    if (root === 'result') finish(JSON.parse(content));
  }, isolated);
  const profile = mkdtempSync(join(tmpdir(), 'chromium-'));
  const options = [
    ...['--headless', '--no-sandbox', '--no-first-run', '--disable-quic', '--disable-background-networking'],
    ...['--disable-component-update', '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
    ...[`--user-data-dir=${profile}`, `--window-size=${size}`, '--enable-logging=stderr', server.url + page],
  ];
  const browser = spawn(chromium, options, { stdio: ['ignore', 'ignore', 'pipe'], detached: true }); // a group
  browser.stderr.on('data', (text) => {
    for (const line of text.toString().split('\n')) if (line.includes('CONSOLE')) console.log(line);
  });
  const gone = new Promise((resolve) => browser.on('exit', resolve));
  gone.then((code) => finish({ failed: 1, summary: `the browser ended with ${code}` }));
  const late = setTimeout(() => finish({ failed: 1, summary: `no answer within ${minutes} minutes` }), minutes * 6e4);
  const result = await finished;
  clearTimeout(late);
  try {
    process.kill(-browser.pid, 'SIGKILL');
  } catch {
    // It has ended.
  }
  await gone;
  rmSync(profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 200 });
  server.close();
  return result;
}

/** Runs a page, prints what it found, and ends the process. */
export async function runTest(test) {
  const { failed, summary } = await runPage(test);
  console.log(summary);
  process.exit(failed > 0 ? 1 : 0);
}
