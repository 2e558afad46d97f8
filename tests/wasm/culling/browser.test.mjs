// Equal answers in headless Chromium: in pages and workers, with threads where the page is cross-origin isolated.
// SIGHTLINE_CHROMIUM names the browser.
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { chromium, runPage } from '../browser.mjs';
import { inFolder, lacking, native, packageFolder } from './native.mjs';

const missing = lacking || (existsSync(chromium) ? false : `no ${chromium}`);

test('a browser answers as the library does', { skip: missing }, (t) =>
  inFolder(async (made) => {
    for (const what of ['boxes', 'scenes']) native([what, join(made, what)]);
    const roots = { made, package: packageFolder, test: fileURLToPath(new URL('.', import.meta.url)) };
    for (const isolated of [true, false]) {
      await t.test(`a page that is ${isolated ? '' : 'not '}isolated`, async (t) => {
        const result = await runPage({ page: '/test/page.html', roots, folder: made, minutes: 5, isolated });
        assert.equal(result.summary, undefined);
        for (const line of result.lines) t.diagnostic(line);
        assert.deepEqual(result.failures, []);
        assert.equal(result.isolated, isolated);
        assert.equal(result.threads, isolated);
        assert.equal(result.simd, true);
        assert.equal(result.lines.length, isolated ? 12 : 9);
      });
    }
  }),
);
