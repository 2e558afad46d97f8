// No box is lost: answers of the package against exact arithmetic, which wasm_culling_native does. 10^7 pairs of box and
// view with SIGHTLINE_LONG=1, 10^5 otherwise.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { bufferOf, imported, inFolder, isLong, kForms, lacking, native } from './native.mjs';
import { RecordReader, RecordWriter } from './records.js';

const kBatches = isLong ? 10 : 1;
const kPairsOfBatch = isLong ? 1e6 : 1e5;

/** For each view of each block the indices of the boxes that it shows. */
function answersTo(sightline, pairs) {
  const asked = new RecordReader(pairs), answers = new RecordWriter();
  while (asked.more) {
    asked.text();
    const culler = sightline.createBoxCuller(asked.array());
    const [views] = asked.array();
    for (let i = 0; i < views; ++i) {
      const view = sightline.createView(asked.camera());
      answers.array(culler.visible(view));
      view.dispose();
    }
    culler.dispose();
  }
  return Buffer.concat(answers.take());
}

test('no box is lost', { skip: lacking }, (t) =>
  inFolder(async (folder) => {
    const { load } = await imported('culling-only.js');
    for (const [form, options] of Object.entries(kForms)) {
      await t.test(form, async (t) => {
        const sightline = await load(options);
        try {
          for (let batch = 0; batch < kBatches; ++batch) {
            const pairs = join(folder, 'pairs'), answers = join(folder, 'answers');
            native(['pairs', pairs, String(kPairsOfBatch), String(batch)]);
            writeFileSync(answers, answersTo(sightline, bufferOf(pairs)));
            t.diagnostic(`batch ${batch}: ${native(['check', pairs, answers]).trim()}`);
          }
        } finally {
          sightline.close();
        }
      });
    }
  }),
);
