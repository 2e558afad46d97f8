// Draws each model with culling and without: images must be equal. Compares images and picks with those of the native
// tools, also of models that are turned, scaled and far from the origin.
import * as THREE from 'three';
import { load } from 'sightline';
import { Plant } from 'sightline/three';

import { check, keepImage, log, randomNumbers, report } from '../checks.js';

const kCameras = 12;
const stats = { images: 0, items: 0, drawn: 0, picks: 0, hits: 0, otherItem: 0 };

const sightline = await load();
const models = await (await fetch('/made/models.json')).json();

class Canvas {
  constructor(width, height, options = {}) {
    this.width = width;
    this.height = height;
    this.renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true, ...options });
    this.renderer.setSize(width, height);
    this.renderer.localClippingEnabled = true;
    this.renderer.debug.onShaderError = (gl, program, vertex, fragment) =>
      check(false, gl.getShaderInfoLog(vertex) + gl.getShaderInfoLog(fragment) + gl.getProgramInfoLog(program));
  }
  draw(root, camera) {
    const pixels = new Uint8Array(4 * this.width * this.height);
    this.renderer.render(root, camera);
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, this.width, this.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return pixels;
  }
}

/** Pixels of which a channel differs by more than `slack`. */
function differences(a, b, slack = 0) {
  let count = 0;
  for (let i = 0; i < a.length; i += 4)
    count += Math.max(Math.abs(a[i] - b[i]), Math.abs(a[i + 1] - b[i + 1]), Math.abs(a[i + 2] - b[i + 2])) > slack;
  return count;
}

/** A plant in a scene, placed anywhere. */
function show(scene, placement, options) {
  const root = new THREE.Scene();
  const plant = new Plant(sightline, scene, options);
  placement.decompose(plant.position, plant.quaternion, plant.scale);
  root.add(plant);
  root.updateMatrixWorld(true);
  return { root, plant };
}

function cameraOf({ eye, target, fovy_deg, ortho_height, near, far }, aspect, placement) {
  const scale = new THREE.Vector3().setFromMatrixScale(placement).x;
  const high = ((ortho_height ?? 0) * scale) / 2;
  const camera = fovy_deg
    ? new THREE.PerspectiveCamera(fovy_deg, aspect, near * scale, far * scale)
    : new THREE.OrthographicCamera(-high * aspect, high * aspect, high, -high, near * scale, far * scale);
  camera.up.set(0, 0, 1).transformDirection(placement);
  camera.position.set(...eye).applyMatrix4(placement);
  camera.lookAt(new THREE.Vector3(...target).applyMatrix4(placement));
  camera.updateMatrixWorld();
  return camera;
}

function planesOf(view, placement) {
  return view.sections?.map(({ n, d }) => new THREE.Plane(new THREE.Vector3(...n), d).applyMatrix4(placement)) ?? null;
}

/** The camera's ray through a pixel's centre; x and y from the upper left corner. */
function rayAt(camera, x, y, width, height) {
  const raycaster = new THREE.Raycaster();
  raycaster.setFromCamera(new THREE.Vector2((2 * (x + 0.5)) / width - 1, 1 - (2 * (y + 0.5)) / height), camera);
  // From the near plane on.
  const cosine = raycaster.ray.direction.dot(camera.getWorldDirection(new THREE.Vector3()));
  if (camera.isPerspectiveCamera) raycaster.ray.recast(camera.near / cosine);
  return raycaster.ray;
}

async function pixelsOf(url) {
  const bitmap = await createImageBitmap(await (await fetch(url)).blob(), { colorSpaceConversion: 'none' });
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const context = canvas.getContext('2d');
  context.drawImage(bitmap, 0, 0);
  return context.getImageData(0, 0, bitmap.width, bitmap.height).data;
}

/** Culling on against off, from random places in and around the model. */
async function compareCulling(canvas, scene, model, placement, name) {
  const culled = show(scene, placement);
  const all = show(scene, placement, { occlusion: false });
  const random = randomNumbers(model.file.length);
  for (let i = 0; i < kCameras; ++i) {
    const spread = i % 2 ? 1 : 2.5;
    const at = () =>
      [0, 1, 2].map((k) => (model.low[k] + model.high[k]) / 2 + (random.between(-spread, spread) * (model.high[k] - model.low[k])) / 2);
    const size = Math.hypot(...[0, 1, 2].map((k) => model.high[k] - model.low[k]));
    const view = { eye: at(), target: at(), near: 1e-3 * size, far: 4 * size };
    if (i % 5 === 4) view.ortho_height = size * random.between(0.05, 1);
    else view.fovy_deg = random.between(15, 90);
    const camera = cameraOf(view, canvas.width / canvas.height, placement);
    const planes =
      i % 2 === 1
        ? [new THREE.Plane(new THREE.Vector3(random.between(-1, 1), random.between(-1, 1), 0.3).normalize(), 0)]
        : null;
    if (planes) {
      // What is cut off lies between the eye and the rest, which it must not hide.
      const [plane] = planes;
      plane.translate(new THREE.Vector3(...at()).lerp(new THREE.Vector3(...view.eye), 0.3));
      if (plane.distanceToPoint(new THREE.Vector3(...view.eye)) > 0) plane.negate();
      plane.applyMatrix4(placement);
    }
    culled.plant.clippingPlanes = all.plant.clippingPlanes = planes;
    all.plant.update(camera, canvas.renderer); // for what it sets beside visibility
    all.plant.showAll();
    culled.plant.update(camera, canvas.renderer);
    const [one, other] = [canvas.draw(culled.root, camera), canvas.draw(all.root, camera)];
    ++stats.images;
    stats.items += culled.plant.stats.items;
    stats.drawn += culled.plant.stats.visible;
    const off = differences(one, other);
    if (!check(off === 0, `${name}, camera ${i}: ${off} pixels differ`)) {
      canvas.draw(culled.root, camera);
      await keepImage(canvas.renderer.domElement, `${model.file}_${i}_culled`);
      canvas.draw(all.root, camera);
      await keepImage(canvas.renderer.domElement, `${model.file}_${i}_all`);
    }
  }
  culled.plant.dispose();
  all.plant.dispose();
}

/** Images and picks against those of the native tools. */
async function compareNative(canvas, scene, model, placement, name) {
  const { root, plant } = show(scene, placement);
  for (const view of model.views) {
    const camera = cameraOf(view, canvas.width / canvas.height, placement);
    plant.clippingPlanes = planesOf(view, placement);
    plant.update(camera, canvas.renderer);
    const drawn = canvas.draw(root, camera);
    await keepImage(canvas.renderer.domElement, `${view.name}${name}`);
    const native = await pixelsOf(`/made/${view.name}_native.png`);
    const background = native.slice(0, 3);
    let compared = 0;
    let wrong = 0;
    for (let y = 0; y < canvas.height; ++y)
      for (let x = 0; x < canvas.width; ++x) {
        const [a, b] = [4 * (y * canvas.width + x), 4 * ((canvas.height - 1 - y) * canvas.width + x)];
        const empty = background.every((value, k) => value === native[a + k]);
        ++compared;
        if (empty) wrong += drawn[b] + drawn[b + 1] + drawn[b + 2] > 0;
        else wrong += [0, 1, 2].some((k) => Math.abs(native[a + k] - drawn[b + k]) > 6);
      }
    log(`${view.name}${name}: ${((100 * wrong) / compared).toFixed(3)} % of pixels differ from the native image`);
    check(wrong < 0.02 * compared, `${view.name}${name}: ${wrong} of ${compared} pixels differ from the native image`);
    const ids = await pixelsOf(`/made/${view.name}_ids.png`);
    const [width, height] = [64, 48];
    for (let y = 0; y < height; ++y)
      for (let x = 0; x < width; ++x) {
        const at = 4 * (y * width + x);
        const expected = ids[at] + 256 * ids[at + 1] + 65536 * ids[at + 2] - 1;
        const pick = plant.pick(rayAt(camera, x, y, width, height));
        ++stats.picks;
        stats.hits += expected >= 0;
        stats.otherItem += (pick?.item ?? -1) !== expected;
      }
  }
  plant.dispose();
}

await report(
  async () => {
    const canvas = new Canvas(640, 480);
    const others = [
      new Canvas(320, 240),
      new Canvas(320, 240, { reversedDepthBuffer: true }),
      new Canvas(320, 240, { logarithmicDepthBuffer: true }),
    ];
    const place = (x, y, z, up, scale) =>
      new THREE.Matrix4()
        .makeRotationX(up ? -Math.PI / 2 : 0)
        .scale(new THREE.Vector3(scale, scale, scale))
        .setPosition(x, y, z);
    for (const [i, model] of models.entries()) {
      const scene = sightline.readScene(await (await fetch(`/made/${model.file}`)).arrayBuffer(), model.file);
      await compareNative(canvas, scene, model, place(0, 0, 0, false, 1), '');
      if (i % 3 === 2) await compareNative(canvas, scene, model, place(1e6, -2e6, 5e5, true, 0.25), '_far');
      if (location.search.includes('views')) continue;
      await compareCulling(others[i % 3], scene, model, place(0, 0, 0, false, 1), model.file);
      await compareCulling(others[(i + 1) % 3], scene, model, place(1e6, 3e5, 100, true, 2), `${model.file} far away`);
      log(`${model.file}: ${JSON.stringify(stats)}`);
      scene.dispose();
    }
    check(stats.otherItem < 0.01 * stats.picks, `${stats.otherItem} picks of ${stats.picks} are of other items`);
    check(stats.drawn < 0.5 * stats.items, 'less than half of what could be left out is');
  },
  () => JSON.stringify(stats),
);
