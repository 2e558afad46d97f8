// Each scene exists twice: a SceneCuller culls one, the other is drawn as it is. Images must be equal in every pixel,
// whatever the camera, the depth buffer and the occluders. three.js itself is the slow twin of sets and picks.
import * as THREE from 'three';
import { load } from 'sightline';
import { SceneCuller } from 'sightline/three';

import { check, keepImage, log, randomNumbers, report } from '../checks.js';
import { makeCamera, makeScene } from './scenes.js';

const width = 160;
const height = 120;
const kCameras = 60;
const stats = { images: 0, saved: 0, savedBehind: 0, instances: 0, picks: 0, hits: 0, missedByThree: 0 };
let keptImages = 0;

const sightline = await load();

class Canvas {
  constructor(name, options) {
    this.name = name;
    this.renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true, ...options });
    this.renderer.setSize(width, height);
    this.renderer.setClearColor(0x102030);
    // In float, so that hardly any two surfaces have the same depth: of those, the order of drawing would decide.
    this.target = new THREE.WebGLRenderTarget(width, height);
    this.target.depthTexture = new THREE.DepthTexture(width, height, THREE.FloatType);
  }
  draw(root, camera) {
    const pixels = new Uint8Array(4 * width * height);
    this.renderer.setRenderTarget(this.target);
    this.renderer.render(root, camera);
    this.renderer.readRenderTargetPixels(this.target, 0, 0, width, height, pixels);
    this.renderer.setRenderTarget(null);
    return new Uint32Array(pixels.buffer);
  }
  async keep(root, camera, name) {
    this.renderer.render(root, camera);
    await keepImage(this.renderer.domElement, name);
  }
}

function differences(a, b) {
  let count = 0;
  for (let i = 0; i < a.length; ++i) count += a[i] !== b[i] ? 1 : 0;
  return count;
}

/** Boxes as three.js has them, and whether the culler draws what is in them. */
function* boxesOf({ root, batch }, culler) {
  const instance = new THREE.Matrix4();
  const objects = [];
  root.traverse((object) => object.isMesh && objects.push(object));
  for (const object of objects) {
    const { geometry } = object;
    if (object === batch) {
      for (let i = 0; i < 140; ++i) {
        try {
          object.getVisibleAt(i);
        } catch {
          continue;
        }
        const box = object.getBoundingBoxAt(object.getGeometryIdAt(i), new THREE.Box3());
        object.getMatrixAt(i, instance).premultiply(object.matrixWorld);
        yield { box: box.applyMatrix4(instance), drawn: object.getVisibleAt(i) };
      }
      continue;
    }
    geometry.computeBoundingBox();
    if (object.isInstancedMesh) {
      const ids = new Set(culler.instanceIds(object));
      check(ids.size === object.count, 'instanceIds() are not as many as are drawn');
      for (let i = 0; i < object.userData.matrices.length / 16; ++i) {
        instance.fromArray(object.userData.matrices, 16 * i).premultiply(object.matrixWorld);
        yield { box: geometry.boundingBox.clone().applyMatrix4(instance), drawn: ids.has(i) };
      }
    } else {
      yield { box: geometry.boundingBox.clone().applyMatrix4(object.matrixWorld), drawn: object.layers.mask !== 0 };
    }
  }
}

const frustum = new THREE.Frustum();
const clip = new THREE.Matrix4();

function checkSet(scene, culler, camera, name, hiddenIds) {
  clip.multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  frustum.setFromProjectionMatrix(clip, camera.coordinateSystem, camera.reversedDepth);
  let lost = 0;
  let extra = 0;
  for (const { box, drawn } of boxesOf(scene, culler)) {
    const inside = frustum.intersectsBox(box.clone().expandByScalar(-1e-9));
    const outside = !frustum.intersectsBox(box.clone().expandByScalar(1e-4));
    lost += inside && !drawn ? 1 : 0;
    extra += outside && drawn ? 1 : 0;
    ++stats.instances;
    stats.saved += drawn ? 0 : 1;
  }
  check(lost <= hiddenIds && extra === 0, `${name}: ${lost} boxes are lost, ${extra} too many`);
}

/** What a culler may change of objects. */
function snapshot(root) {
  const state = [];
  root.traverse((object) => {
    state.push([object.layers.mask, object.frustumCulled, object.count, object.perObjectFrustumCulled]);
    for (const attribute of [object.instanceMatrix, object.instanceColor]) if (attribute) state.push([...attribute.array]);
    if (!object.isBatchedMesh) return;
    for (let i = 0; i < object.maxInstanceCount; ++i) {
      try {
        state.push(object.getVisibleAt(i));
      } catch {
        state.push(null);
      }
    }
  });
  return JSON.stringify(state);
}

async function compare(canvas, scene, twin, culler, camera, name) {
  culler.update(camera, canvas.renderer);
  const culled = canvas.draw(scene.root, camera);
  const all = canvas.draw(twin.root, camera);
  ++stats.images;
  const off = differences(culled, all);
  if (!check(off === 0, `${name}: ${off} pixels differ`) && keptImages++ < 3) {
    await canvas.keep(scene.root, camera, `${keptImages}_culled`);
    await canvas.keep(twin.root, camera, `${keptImages}_all`);
  }
}

/** Ends three.js' own culling: its spheres are too small where parents shear, and lose what they should not. */
function drawAll(scene) {
  scene.root.traverse((object) => (object.frustumCulled = object.perObjectFrustumCulled = false));
  return scene;
}

async function compareImages(canvas, seed) {
  const scene = makeScene(seed);
  const twin = drawAll(makeScene(seed));
  scene.instanced.forEach((mesh) => (mesh.userData.matrices = mesh.instanceMatrix.array.slice()));
  const before = snapshot(scene.root);
  const hiddenInBatch = [...Array(140).keys()].filter((i) => {
    try {
      return !scene.batch.getVisibleAt(i);
    } catch {
      return false;
    }
  }).length;
  const culler = new SceneCuller(sightline).add(scene.root);
  const random = randomNumbers(seed + 1);
  const cameras = Array.from({ length: kCameras }, () => makeCamera(random));
  for (const [i, camera] of cameras.entries()) {
    const name = `${canvas.name}, scene ${seed}, camera ${i}`;
    if (i % 6 === 0 && i > 0) {
      const which = random.below(scene.singles.length);
      const where = [random.between(-12, 12), random.between(-12, 12), random.between(-12, 12)];
      for (const { singles } of [scene, twin]) singles[which].position.set(...where);
      culler.moved(scene.singles[which]);
      const group = random.below(4);
      for (const { instanced } of [scene, twin]) instanced[group].position.set(...where);
      culler.moved(scene.instanced[group]);
      twin.root.updateMatrixWorld(true);
    }
    await compare(canvas, scene, twin, culler, camera, name);
    checkSet(scene, culler, camera, name, hiddenInBatch);
  }
  // Occluders. Each is culled, too, but where the eye is inside it must not hide anything that is drawn.
  for (const wall of scene.walls) culler.addOccluder(wall);
  for (const [i, camera] of cameras.entries()) {
    await compare(canvas, scene, twin, culler, camera, `${canvas.name}, scene ${seed}, camera ${i} with occluders`);
    stats.savedBehind += culler.stats.tested - culler.stats.visible;
  }
  // Without some, with these again, and without any.
  culler.remove(scene.instanced[0]).remove(scene.singles[0]);
  await compare(canvas, scene, twin, culler, cameras[0], `${canvas.name}, scene ${seed} after remove()`);
  culler.add(scene.root);
  await compare(canvas, scene, twin, culler, cameras[1], `${canvas.name}, scene ${seed} after add()`);
  culler.update(cameras[2], canvas.renderer);
  culler.dispose();
  check(snapshot(scene.root) === before, `${canvas.name}, scene ${seed}: dispose() does not restore all`);
  drawAll(scene);
  const off = differences(canvas.draw(scene.root, cameras[3]), canvas.draw(twin.root, cameras[3]));
  check(off === 0, `${canvas.name}, scene ${seed}: ${off} pixels differ after dispose()`);
}

/** Minimum projected area is approximate: says what it costs. */
function leastArea(canvas, seed) {
  const scene = makeScene(seed);
  const twin = drawAll(makeScene(seed));
  const culler = new SceneCuller(sightline, { leastArea: 4 }).add(scene.root);
  const random = randomNumbers(seed + 1);
  let lost = 0;
  let drawn = 0;
  let tested = 0;
  for (let i = 0; i < 20; ++i) {
    const camera = makeCamera(random);
    const all = canvas.draw(twin.root, camera);
    culler.update(camera, canvas.renderer);
    lost += differences(canvas.draw(scene.root, camera), all);
    drawn += culler.stats.visible;
    tested += culler.stats.tested;
  }
  log(`least area of 4 pixels: ${drawn} of ${tested} drawn, ${((100 * lost) / (20 * width * height)).toFixed(3)} % of pixels differ`);
  check(lost < 0.01 * 20 * width * height, 'least area: more than one pixel of a hundred differs');
}

function comparePicks(seed) {
  const scene = makeScene(seed, THREE.DoubleSide);
  const twin = makeScene(seed, THREE.DoubleSide);
  const numbers = new Map();
  const partners = [];
  twin.root.traverse((object) => partners.push(object));
  let next = 0;
  scene.root.traverse((object) => numbers.set(object, partners[next++]));
  const culler = new SceneCuller(sightline).add(scene.root);
  const raycaster = new THREE.Raycaster();
  const random = randomNumbers(seed + 7);
  const canvasOf = { getDrawingBufferSize: (size) => size.set(width, height) };
  for (let i = 0; i < 400; ++i) {
    const camera = makeCamera(random);
    culler.update(camera, canvasOf);
    raycaster.setFromCamera(new THREE.Vector2(random.between(-1, 1), random.between(-1, 1)), camera);
    raycaster.near = 0;
    raycaster.far = Infinity;
    const hits = raycaster.intersectObject(twin.root, true);
    const pick = culler.pick(raycaster.ray);
    ++stats.picks;
    if (hits.length === 0) {
      // A ray between two triangles may miss both, three.js says, which is not watertight.
      stats.missedByThree += pick ? 1 : 0;
      continue;
    }
    ++stats.hits;
    const [first] = hits;
    const name = `scene ${seed}, ray ${i}`;
    if (!check(pick, `${name}: nothing is picked`)) continue;
    const slack = 1e-5 * Math.max(1, first.distance);
    if (pick.distance < first.distance - slack) {
      ++stats.missedByThree;
      continue;
    }
    check(Math.abs(pick.distance - first.distance) <= slack, `${name}: distance ${pick.distance}, not ${first.distance}`);
    check(pick.point.distanceTo(first.point) <= 2 * slack, `${name}: point`);
    const close = hits.filter(({ distance }) => distance <= first.distance + slack);
    check(
      close.some(
        (hit) =>
          numbers.get(pick.object) === hit.object &&
          pick.instanceId === (hit.batchId ?? hit.instanceId ?? -1) &&
          pick.triangle === hit.faceIndex,
      ),
      `${name}: ${pick.object.type} ${pick.instanceId} triangle ${pick.triangle}, not ${first.object.type} ` +
        `${first.batchId ?? first.instanceId} triangle ${first.faceIndex}`,
    );
  }
  culler.dispose();
}

function refuse() {
  const scene = makeScene(5);
  const culler = new SceneCuller(sightline);
  const throws = (work, text) => {
    try {
      work();
      check(false, `no error says ${text}`);
    } catch (error) {
      check(error.message.includes(text), `an error says ${error.message}, not ${text}`);
    }
  };
  throws(() => culler.addOccluder(scene.instanced[0]), 'expected a Mesh');
  throws(() => culler.instanceIds(scene.singles[0]), 'expected an InstancedMesh');
  culler.update(new THREE.PerspectiveCamera(), { getDrawingBufferSize: (size) => size.set(width, height) }); // of nothing
  check(culler.pick(new THREE.Ray()) === null, 'something is picked of nothing');
}

/** Objects that must be drawn though their boxes lie outside of what the camera sees, and a camera that is carried. */
function drawWhatCountsOutside() {
  const cube = (x, y, z) => {
    const mesh = new THREE.Mesh(new THREE.BoxGeometry());
    mesh.position.set(x, y, z);
    return mesh;
  };
  const [root, rig, camera] = [new THREE.Scene(), new THREE.Group(), new THREE.PerspectiveCamera()];
  camera.position.set(0, 0, 10);
  root.add(rig.add(camera));
  const [behind, displaced, caster, broken, far] = [0, 1, 2, 0, 200].map((x, i) => cube(x, 0, i === 3 ? 0 : 20));
  const many = new THREE.InstancedMesh(new THREE.BoxGeometry(), undefined, 2);
  many.setMatrixAt(0, new THREE.Matrix4().makeTranslation(0, 0, 30));
  many.setMatrixAt(1, new THREE.Matrix4().makeTranslation(NaN, 0, 0));
  far.position.z = 0;
  displaced.frustumCulled = false;
  caster.castShadow = many.castShadow = true;
  broken.geometry.attributes.position.setX(3, NaN);
  root.add(behind, displaced, caster, broken, far, many);
  const said = console.error;
  console.error = () => {}; // three.js tells of vertices that are no numbers
  const culler = new SceneCuller(sightline).add(root);
  const drawn = (shadows) => {
    culler.update(camera, { getDrawingBufferSize: (size) => size.set(width, height), shadowMap: { enabled: shadows } });
    return [behind, displaced, caster, broken, far].map((mesh) => Number(mesh.layers.mask !== 0)).join('') + many.count;
  };
  check(drawn(true) === '011102', `with shadows: ${drawn(true)} are drawn`);
  check(drawn(false) === '010100', `without shadows: ${drawn(false)} are drawn`);
  rig.position.x = 200; // render() updates world matrices after this
  check(drawn(false) === '010110', `from a rig that moved: ${drawn(false)} are drawn`);
  culler.dispose();
  console.error = said;
  check(many.count === 2 && behind.layers.mask === 1 && !displaced.frustumCulled && caster.frustumCulled, 'not restored');
}

await report(
  async () => {
    const canvases = [
      new Canvas('standard', {}),
      new Canvas('reversed', { reversedDepthBuffer: true }),
      new Canvas('logarithmic', { logarithmicDepthBuffer: true }),
    ];
    check(canvases[1].renderer.state.buffers.depth.getReversed(), 'no reversed depth buffer');
    refuse();
    drawWhatCountsOutside();
    for (const [i, canvas] of canvases.entries())
      for (const seed of [10 * i + 1, 10 * i + 2]) {
        await compareImages(canvas, seed);
        log(`${canvas.name}, scene ${seed}: ${JSON.stringify(stats)}`);
      }
    leastArea(canvases[0], 3);
    for (const seed of [51, 52]) comparePicks(seed);
    check(stats.missedByThree < 0.02 * stats.picks, 'picks that three.js does not have are more than two of a hundred');
    check(stats.saved > 0.5 * stats.instances, 'less than half of what could be left out is');
    check(stats.savedBehind > stats.saved, 'occluders hide nothing');
  },
  () => JSON.stringify(stats),
);
