// The same answers in headless Chromium: in pages and workers, with threads where the page is cross-origin isolated.
// SIGHTLINE_CHROMIUM names the browser.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync, readFileSync, rmSync, mkdtempSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { extname, join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { inFolder, lacking, native, packageFolder } from './native.mjs';

const chromium = process.env.SIGHTLINE_CHROMIUM ?? '/usr/bin/chromium';
const kMinutes = 5;
const kTypes = { '.js': 'text/javascript', '.html': 'text/html', '.wasm': 'application/wasm' };
const kIsolating = { 'Cross-Origin-Opener-Policy': 'same-origin', 'Cross-Origin-Embedder-Policy': 'require-corp' };

/** Serves folders by the first part of the path. `finish` gets what the page posts. */
function serve(roots, headers, finish) {
  return createServer((request, response) => {
    if (request.method === 'POST') {
      let text = '';
      request.on('data', (piece) => (text += piece)).on('end', () => {
        response.end();
        finish(JSON.parse(text));
      });
      return;
    }
    const [, root, ...rest] = decodeURIComponent(new URL(request.url, 'http://localhost').pathname).split('/');
    const file = join(roots[root] ?? '/nowhere', ...rest);
    if (!existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, { 'Content-Type': kTypes[extname(file)] ?? 'application/octet-stream', ...headers });
    response.end(readFileSync(file));
  });
}

/** What a page in a new browser posts. */
async function resultOf(roots, headers) {
  let finish, fail;
  const finished = new Promise((resolve, reject) => ((finish = resolve), (fail = reject)));
  const server = serve(roots, headers, finish);
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  const profile = mkdtempSync(join(tmpdir(), 'chromium-'));
  const browser = spawn(chromium, [
    '--headless', '--no-sandbox', '--no-first-run', '--disable-quic', '--disable-gpu', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', `--user-data-dir=${profile}`,
    `http://127.0.0.1:${server.address().port}/test/page.html`,
  ], { stdio: 'ignore', detached: true }); // a group, whose processes end together
  const ended = new Promise((resolve) => browser.on('exit', resolve));
  browser.on('error', fail);
  ended.then((code) => fail(new Error(`the browser ended with ${code}`)));
  const late = setTimeout(() => fail(new Error(`the browser did not answer within ${kMinutes} minutes`)), kMinutes * 60e3);
  try {
    return await finished;
  } finally {
    clearTimeout(late);
    try {
      process.kill(-browser.pid, 'SIGKILL');
    } catch {
      // It has ended.
    }
    await ended;
    server.closeAllConnections();
    server.close();
    rmSync(profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 200 });
  }
}

const missing = lacking || (existsSync(chromium) ? false : `no ${chromium}`);

test('a browser answers as the library does', { skip: missing }, (t) =>
  inFolder(async (made) => {
    for (const what of ['boxes', 'scenes']) native([what, join(made, what)]);
    const roots = { made, package: packageFolder, test: fileURLToPath(new URL('.', import.meta.url)) };
    for (const [name, headers] of [['isolated', kIsolating], ['not isolated', {}]]) {
      await t.test(`a page that is ${name}`, async (t) => {
        const result = await resultOf(roots, headers);
        for (const line of result.lines) t.diagnostic(line);
        assert.deepEqual(result.failures, []);
        assert.equal(result.isolated, name === 'isolated');
        assert.equal(result.threads, name === 'isolated');
        assert.equal(result.simd, true);
        assert.equal(result.lines.length, name === 'isolated' ? 12 : 9);
      });
    }
  }),
);
