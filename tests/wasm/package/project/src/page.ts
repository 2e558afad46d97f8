import { BoxGeometry, InstancedMesh, Matrix4, MeshBasicMaterial, PerspectiveCamera, Scene, WebGLRenderer } from 'three';
import { hasThreads, load } from 'sightline';
import { Plant, SceneCuller, type Pick } from 'sightline/three';

async function run(): Promise<string> {
  const threads: number = hasThreads() && location.hash !== '#alone' ? 2 : 1;
  const sightline = await load({ threads });
  const root = new Scene();
  const boxes = new InstancedMesh(new BoxGeometry(), new MeshBasicMaterial(), 100);
  for (let i = 0; i < 100; ++i) boxes.setMatrixAt(i, new Matrix4().makeTranslation(3 * i, 0, 0));
  root.add(boxes);
  const culler = new SceneCuller(sightline, { leastArea: 0 }).add(root);
  const renderer = new WebGLRenderer();
  renderer.setSize(320, 240);
  const camera = new PerspectiveCamera(50, 320 / 240, 0.1, 100);
  camera.position.set(0, 0, 10);
  culler.update(camera, renderer);
  renderer.render(root, camera);
  const pick: Pick | null = culler.pick({ origin: camera.position, direction: camera.position.clone().negate() });
  if (pick?.instanceId !== 0) throw new Error(`the first box is picked, not ${pick?.instanceId}`);
  if (!(culler.stats.visible > 0 && culler.stats.visible < 10)) throw new Error(`${culler.stats.visible} of 100 are visible`);

  const scene = sightline.createScene();
  scene.addPrimitive(0, { kind: 'cylinder', parameters: [0.5, 4] });
  const plant = new Plant(sightline, scene.commit());
  root.add(plant);
  plant.update(camera, renderer);
  renderer.render(root, camera);
  if (plant.stats.visible !== 1) throw new Error('the cylinder is not visible');
  return `page: ${culler.stats.visible} of 100 boxes are visible, ${sightline.threads} threads`;
}

let result: { failed: number; summary: string };
try {
  result = { failed: 0, summary: await run() };
} catch (error) {
  result = { failed: 1, summary: `FAILED: ${error instanceof Error ? error.stack : error}` };
}
await fetch('/result', { method: 'POST', body: JSON.stringify(result) });
