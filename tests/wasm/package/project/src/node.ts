import { load, SightlineError } from 'sightline';
import { load as loadCulling, type BoxCuller } from 'sightline/culling';

function boxesInGrid(side: number): Float64Array {
  const boxes = new Float64Array(6 * side ** 3);
  let at = 0;
  for (let x = 0; x < side; ++x)
    for (let y = 0; y < side; ++y)
      for (let z = 0; z < side; ++z, at += 6) boxes.set([x, y, z, x + 0.5, y + 0.5, z + 0.5], at);
  return boxes;
}

function expect(good: boolean, what: string): void {
  if (!good) throw new Error(what);
}

// Looks along -z at the first layers of x and y: 2 x 2 columns.
const view = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -20, 1];
const projection = [0.8, 0, 0, 0, 0, 0.8, 0, 0, 0, 0, -2 / 40, 0, 0, 0, -1, 1];

const culling = await loadCulling();
const culler: BoxCuller = culling.createBoxCuller(boxesInGrid(10));
const seen: Uint32Array = culler.visible(culling.createView({ view, projection, depth: 'minusOneToOne' }));
expect(seen.length === 40, `40 boxes are visible, not ${seen.length}`);
culler.dispose();

const sightline = await load({ threads: 1 });
const scene = sightline.createScene();
const node: number = scene.addNode(0, 'PIPE-1');
const item: number = scene.addPrimitive(node, { kind: 'cylinder', parameters: [0.5, 4] });
scene.commit();
const hit = scene.pick([5, 0, 0], [-1, 0, 0]);
expect(hit?.item === item && Math.abs(hit.distance - 4.5) < 1e-6, `a cylinder is hit at 4.5 m, not ${hit?.distance}`);
let message = '';
try {
  scene.read(new Uint8Array([1, 2, 3]), 'broken.rvm');
} catch (error) {
  if (error instanceof SightlineError) message = error.message;
}
expect(message.includes('broken.rvm'), `an error names its file: ${message}`);
console.log(`node: ${seen.length} of 1000 boxes are visible; ${message}`);
