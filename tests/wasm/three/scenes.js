// Scenes at random of all that SceneCuller culls, made twice the same from a seed.
import * as THREE from 'three';

import { randomNumbers } from '../checks.js';

function placed(object, random, spread) {
  object.position.set(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)).multiplyScalar(spread);
  object.rotation.set(random.between(-3, 3), random.between(-3, 3), random.between(-3, 3));
  object.scale.set(random.between(0.3, 2), random.between(0.3, 2), random.between(0.3, 2));
  if (random.next() < 0.1) object.scale.x *= -1;
  return object;
}

function colour(random) {
  return new THREE.Color(random.next(), random.next(), random.next());
}

function geometries() {
  const interleaved = new THREE.BufferGeometry();
  const corners = new THREE.InterleavedBuffer(
    new Float32Array([0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0, 9, 0, 0, 0, 9, 0, 1, 0, 9, 0, 0, 1, 9]),
    4,
  );
  interleaved.setAttribute('position', new THREE.InterleavedBufferAttribute(corners, 3, 0));
  const ranged = new THREE.TorusGeometry(1, 0.3, 6, 12);
  ranged.setDrawRange(36, 150);
  return [
    new THREE.BoxGeometry(1, 2, 0.5),
    new THREE.SphereGeometry(0.7, 8, 6),
    new THREE.ConeGeometry(0.6, 1.5, 7).toNonIndexed(),
    new THREE.PlaneGeometry(2, 1),
    interleaved,
    ranged,
  ];
}

/** `side` of all materials; else each has one at random. */
export function makeScene(seed, side) {
  const random = randomNumbers(seed);
  const shapes = geometries();
  const material = () =>
    new THREE.MeshBasicMaterial({
      color: colour(random),
      side: side ?? [THREE.FrontSide, THREE.DoubleSide, THREE.BackSide][random.below(3)],
    });
  const root = new THREE.Scene();
  const parents = [root];
  for (let i = 0; i < 10; ++i) {
    const group = placed(new THREE.Group(), random, 4);
    parents[random.below(parents.length)].add(group);
    parents.push(group);
  }
  const parent = () => parents[random.below(parents.length)];
  const singles = [];
  for (let i = 0; i < 150; ++i) {
    const mesh = placed(new THREE.Mesh(shapes[random.below(shapes.length)], material()), random, 12);
    (random.next() < 0.2 && singles.length > 0 ? singles[random.below(singles.length)] : parent()).add(mesh);
    singles.push(mesh);
  }
  const several = [];
  const place = new THREE.Object3D();
  for (let k = 0; k < 4; ++k) {
    const count = [120, 80, 1, 60][k];
    const mesh = placed(new THREE.InstancedMesh(shapes[k].clone(), material(), count), random, 3);
    for (let i = 0; i < count; ++i) {
      placed(place, random, 10).updateMatrix();
      mesh.setMatrixAt(i, place.matrix);
      if (k !== 1) mesh.setColorAt(i, colour(random));
    }
    parent().add(mesh);
    several.push(mesh);
  }
  const batch = placed(new THREE.BatchedMesh(140, 2000, 4000, material()), random, 3);
  const ids = [shapes[0], shapes[1], new THREE.TorusGeometry(1, 0.3, 6, 12)].map((shape) => batch.addGeometry(shape));
  for (let i = 0; i < 140; ++i) {
    const id = batch.addInstance(ids[random.below(3)]);
    batch.setMatrixAt(id, (placed(place, random, 10).updateMatrix(), place.matrix));
    batch.setColorAt(id, colour(random));
    if (random.next() < 0.1) batch.setVisibleAt(id, false);
    else if (random.next() < 0.1) batch.deleteInstance(id);
  }
  parent().add(batch);
  const walls = [];
  for (let i = 0; i < 6; ++i) {
    const shape = [new THREE.BoxGeometry(9, 6, 1), new THREE.SphereGeometry(4, 12, 9), new THREE.PlaneGeometry(12, 9)][i % 3];
    const wall = placed(new THREE.Mesh(shape, material()), random, 8);
    parent().add(wall);
    walls.push(wall);
  }
  root.updateMatrixWorld(true);
  return { root, singles, instanced: several, batch, walls };
}

export function makeCamera(random) {
  let camera;
  const aspect = random.between(0.5, 2);
  const near = 10 ** random.between(-2, 0.5);
  const far = near + 10 ** random.between(0.5, 2.5);
  if (random.next() < 0.35) {
    const high = 10 ** random.between(-0.5, 1.5);
    camera = new THREE.OrthographicCamera(-high * aspect, high * aspect, high, -high, near, far);
  } else {
    camera = new THREE.PerspectiveCamera(random.between(10, 110), aspect, near, far);
    if (random.next() < 0.2) camera.setViewOffset(400, 300, random.between(0, 200), random.between(0, 150), 200, 150);
  }
  const at = random.next() < 0.3 ? 3 : 25;
  camera.position.set(random.between(-at, at), random.between(-at, at), random.between(-at, at));
  camera.lookAt(random.between(-9, 9), random.between(-9, 9), random.between(-9, 9));
  camera.updateMatrixWorld();
  camera.updateProjectionMatrix();
  return camera;
}
