import { replay } from './replay.js';
import { load } from '/package/js/index.js';
import { load as loadCulling } from '/package/js/culling-only.js';

onmessage = async ({ data: { what, options, file } }) => {
  try {
    const sightline = await (what === 'scenes' ? load : loadCulling)(options);
    postMessage({ answers: replay(sightline, file).answers });
    sightline.close();
  } catch (error) {
    postMessage({ error: error.message ?? String(error) });
  }
};
