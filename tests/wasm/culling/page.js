// Replays the library's answers in a page and in a worker of it, in each form that the page can run.
import { replay } from './replay.js';
import { hasSimd, hasThreads, load } from '/package/js/index.js';
import { load as loadCulling } from '/package/js/culling-only.js';

const fetched = async (path) => (await fetch(path)).arrayBuffer();

async function results() {
  const lines = [], failures = [];
  const attempt = async (name, work) => {
    try {
      lines.push(`${name}: ${await work()}`);
    } catch (error) {
      failures.push(`${name}: ${error.message ?? error}`);
    }
  };
  const boxes = await fetched('/made/boxes'), scenes = await fetched('/made/scenes');
  const forms = { simd: { simd: true }, scalar: { simd: false } };
  if (hasThreads()) forms.threads = { threads: 2 };
  for (const [form, options] of Object.entries(forms)) {
    for (const [what, loaded, file] of [['culling alone', loadCulling, boxes], ['scenes', load, scenes]]) {
      await attempt(`${what}, ${form}`, async () => {
        const sightline = await loaded(options);
        const { answers } = replay(sightline, file);
        sightline.close();
        return `${answers} answers`;
      });
      await attempt(`${what}, ${form}, in a worker`, async () => {
        const worker = new Worker(new URL('./page_worker.js', import.meta.url), { type: 'module' });
        const answer = new Promise((resolve, reject) => {
          worker.onmessage = ({ data }) => (data.error ? reject(new Error(data.error)) : resolve(data.answers));
          worker.onerror = (event) => reject(new Error(event.message));
        });
        worker.postMessage({ what, options, file });
        const answers = await answer;
        worker.terminate();
        return `${answers} answers`;
      });
    }
  }
  if (!hasThreads()) {
    await attempt('threads without isolation are refused', async () => {
      try {
        await load({ threads: 2 });
      } catch (error) {
        return error.message;
      }
      throw new Error('they are not');
    });
  }
  return { lines, failures, isolated: globalThis.crossOriginIsolated, simd: hasSimd(), threads: hasThreads() };
}

results()
  .catch((error) => ({ lines: [], failures: [String(error)] }))
  .then((result) => fetch('/result', { method: 'POST', body: JSON.stringify(result) }));
