// Answers equal to those of the library in a process of its own, to the bit; hits of rays within rounding.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';

import { bufferOf, imported, inFolder, kForms, lacking, native } from './native.mjs';
import { replay } from './replay.js';

test('every form answers as the library does', { skip: lacking }, (t) =>
  inFolder(async (folder) => {
    const [boxes, scenes] = ['boxes', 'scenes'].map((what) => {
      const file = join(folder, what);
      native([what, file]);
      return bufferOf(file);
    });
    const whole = await imported('index.js'), culling = await imported('culling-only.js');
    for (const [form, options] of Object.entries(kForms)) {
      for (const [name, load, file, least] of [
        ['culling alone', culling.load, boxes, 2000],
        ['culling in the whole', whole.load, boxes, 2000],
        ['scenes', whole.load, scenes, 2000],
      ]) {
        await t.test(`${name}, ${form}`, async (t) => {
          const sightline = await load(options);
          assert.equal(sightline.simd, form !== 'scalar');
          assert.equal(sightline.threads, options.threads ?? 1);
          try {
            const { answers, hits, roundedHits } = replay(sightline, file);
            assert.ok(answers > least, `${answers} answers are too few`);
            t.diagnostic(`${answers} answers, ${hits} hits of which ${roundedHits} differ within the tolerance`);
          } finally {
            sightline.close();
          }
        });
      }
    }
  }),
);
