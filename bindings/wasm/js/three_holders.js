// Objects of three.js that hold what can be left out: a mesh itself, or instances of one. Each has places, numbered
// through all of them, one for each box of a culler.

import { Box3, Matrix4 } from 'three';

/** @typedef {import('three').Object3D} Object3D */

const box = new Box3();
const matrix = new Matrix4();

/** Boxes grow by more than their corners are off by, as sums of four products in double. */
const kRounding = 2 ** -50;

/**
 * Writes the world box of a geometry's box.
 * @param {Float64Array} out
 * @param {number} at
 * @param {Box3} local
 * @param {ArrayLike<number>} m world from the geometry
 */
function writeBox(out, at, local, m) {
  const nothing = () => out.fill(Infinity, at, at + 3).fill(-Infinity, at + 3, at + 6);
  if (local.isEmpty()) return void nothing();
  const low = [local.min.x, local.min.y, local.min.z];
  const high = [local.max.x, local.max.y, local.max.z];
  for (let row = 0; row < 3; ++row) {
    let least = m[12 + row];
    let most = least;
    let terms = Math.abs(least);
    for (let column = 0; column < 3; ++column) {
      const a = m[4 * column + row] * low[column];
      const b = m[4 * column + row] * high[column];
      least += Math.min(a, b);
      most += Math.max(a, b);
      terms += Math.max(Math.abs(a), Math.abs(b));
    }
    out[at + row] = least - kRounding * terms;
    out[at + 3 + row] = most + kRounding * terms;
    if (!Number.isFinite(terms)) return void nothing();
  }
}

/**
 * @param {Box3} local
 */
function isOfNumbers({ min, max }) {
  return ![min.x, min.y, min.z, max.x, max.y, max.z].some(Number.isNaN);
}

/**
 * @param {any} geometry
 * @returns {Box3}
 */
function boxOf(geometry) {
  if (!geometry.boundingBox) geometry.computeBoundingBox();
  return geometry.boundingBox;
}

/** One mesh. It has no layers while it is left out. */
class Single {
  /** @param {any} mesh */
  constructor(mesh) {
    this.object = mesh;
    this.count = 1;
    this.first = 0;
    this.mask = mesh.layers.mask;
    this.frustumCulled = mesh.frustumCulled;
    mesh.frustumCulled = mesh.frustumCulled && mesh.castShadow; // casters are drawn always: three.js tests them itself
  }
  /** @param {number} _ */
  matrix(_) {
    return this.object.matrixWorld;
  }
  /** @param {number} _ */
  box(_) {
    return boxOf(this.object.geometry);
  }
  /** @param {number} _ */
  geometry(_) {
    return { key: this.object.geometry, geometry: this.object.geometry, first: 0, count: Infinity };
  }
  hide() {
    this.object.layers.mask = 0;
  }
  /** @param {number} _ */
  show(_) {
    this.object.layers.mask = this.mask;
  }
  restore() {
    this.show(0);
    this.object.frustumCulled = this.frustumCulled;
  }
}

/** An InstancedMesh. Visible instances are copied to the front of its arrays. */
export class Instances {
  /** @param {any} mesh */
  constructor(mesh) {
    this.object = mesh;
    this.count = mesh.count;
    this.first = 0;
    this.arrays = instancedAttributes(mesh).map((attribute) => ({ attribute, values: attribute.array.slice() }));
    this.ids = Uint32Array.from({ length: mesh.count }, (_, i) => i);
    this.wanted = new Uint8Array(mesh.count);
    this.shown = mesh.count;
    if (mesh.boundingSphere === null) mesh.computeBoundingSphere(); // of all, which three.js keeps from then on
    this.frustumCulled = mesh.frustumCulled;
    mesh.frustumCulled = false;
  }
  /** @param {number} i */
  matrix(i) {
    return matrix.fromArray(this.arrays[0].values, 16 * i).premultiply(this.object.matrixWorld);
  }
  /** @param {number} _ */
  box(_) {
    return boxOf(this.object.geometry);
  }
  /** @param {number} _ */
  geometry(_) {
    return { key: this.object.geometry, geometry: this.object.geometry, first: 0, count: Infinity };
  }
  hide() {
    this.wanted.fill(0);
  }
  /** @param {number} i */
  show(i) {
    this.wanted[i] = 1;
  }
  /** Copies instance i to a place of the arrays. */
  #put(/** @type {number} */ i, /** @type {number} */ at) {
    this.ids[at] = i;
    for (const { attribute, values } of this.arrays) {
      const numbers = attribute.itemSize;
      const to = attribute.array;
      for (let k = 0, out = numbers * at, from = numbers * i; k < numbers; ++k) to[out++] = values[from++];
    }
  }
  /** Draws what is wanted, in the order of instances: where surfaces coincide, the same one shows as without culling. */
  finish() {
    let [shown, changedFrom, changedTo] = [0, Infinity, 0];
    for (let i = 0; i < this.count; ++i) {
      if (this.wanted[i] === 0) continue;
      const at = shown++;
      if (this.ids[at] === i) continue;
      if (changedTo === 0) changedFrom = at;
      changedTo = at + 1;
      this.#put(i, at);
    }
    this.shown = this.object.count = shown;
    if (changedTo === 0) return;
    for (const { attribute } of this.arrays) {
      let from = attribute.itemSize * changedFrom;
      let to = attribute.itemSize * changedTo;
      // What has not been uploaded yet, since nothing was drawn.
      for (const { start, count } of attribute.updateRanges) {
        from = Math.min(from, start);
        to = Math.max(to, start + count);
      }
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(from, to - from);
      attribute.needsUpdate = true;
    }
  }
  showAll() {
    this.wanted.fill(1);
    this.finish();
  }
  restore() {
    this.showAll();
    this.object.frustumCulled = this.frustumCulled;
  }
}

/**
 * All that differs from instance to instance; matrices are the first.
 * @param {any} mesh
 */
function instancedAttributes(mesh) {
  const others = Object.values(mesh.geometry.attributes).filter((attribute) => attribute.isInstancedBufferAttribute);
  return [mesh.instanceMatrix, mesh.instanceColor, ...others].filter((attribute) => attribute !== null);
}

/** A BatchedMesh: instances that are visible when it is added. */
class Batch {
  /** @param {any} mesh */
  constructor(mesh) {
    this.object = mesh;
    this.first = 0;
    /** @type {number[]} */ this.ids = [];
    for (let id = 0, found = 0; found < mesh.instanceCount && id < mesh.maxInstanceCount; ++id) {
      try {
        const visible = mesh.getVisibleAt(id); // throws for an instance that was deleted
        ++found;
        if (visible) this.ids.push(id);
      } catch {
        continue;
      }
    }
    this.count = this.ids.length;
    this.isShown = new Uint8Array(this.count).fill(1);
    this.wanted = new Uint8Array(this.count);
    this.perObjectFrustumCulled = mesh.perObjectFrustumCulled;
    this.frustumCulled = mesh.frustumCulled;
    mesh.perObjectFrustumCulled = mesh.frustumCulled = false;
  }
  /** @param {number} i */
  matrix(i) {
    return this.object.getMatrixAt(this.ids[i], matrix).premultiply(this.object.matrixWorld);
  }
  /** @param {number} i */
  box(i) {
    return this.object.getBoundingBoxAt(this.object.getGeometryIdAt(this.ids[i]), box);
  }
  /** @param {number} i */
  geometry(i) {
    const id = this.object.getGeometryIdAt(this.ids[i]);
    const { start, count } = this.object.getGeometryRangeAt(id);
    return { key: `${this.object.uuid} ${id}`, geometry: this.object.geometry, first: start, count };
  }
  hide() {
    this.wanted.fill(0);
  }
  /** @param {number} i */
  show(i) {
    this.wanted[i] = 1;
  }
  finish() {
    for (let i = 0; i < this.count; ++i) {
      if (this.wanted[i] === this.isShown[i]) continue;
      this.object.setVisibleAt(this.ids[i], this.wanted[i] === 1);
      this.isShown[i] = this.wanted[i];
    }
  }
  restore() {
    this.wanted.fill(1);
    this.finish();
    this.object.perObjectFrustumCulled = this.perObjectFrustumCulled;
    this.object.frustumCulled = this.frustumCulled;
  }
}

/** @typedef {Single | Instances | Batch} Holder */

/**
 * @param {any} object
 * @returns {Holder | null}
 */
function holderOf(object) {
  if (!object.isMesh || object.isSkinnedMesh || object.geometry.morphAttributes.position) return null;
  if (object.isBatchedMesh) return new Batch(object);
  return object.isInstancedMesh ? new Instances(object) : new Single(object);
}

/** All holders of a culler, and their places. */
export class Holders {
  /** @type {Map<Object3D, Holder>} */ #of = new Map();
  /** @type {Holder[]} */ #several = []; // those with finish()
  /** @type {Holder[]} */ #owner = []; // by place
  /** @type {number[]} */ #shownSingles = []; // places
  /** @type {number[]} */ #always = []; // places that are drawn whatever the camera sees
  /** @type {number[]} */ #casters = []; // places that cast shadows
  #isSingle = new Uint8Array(0); // by place
  #shownIn = new Uint32Array(0); // the last frame that showed it
  #frame = 1;

  /** @param {Object3D} object */
  add(object) {
    if (this.#of.has(object)) return;
    const holder = holderOf(object);
    if (holder) this.#of.set(object, holder);
  }
  /** @param {Object3D} object */
  remove(object) {
    this.#of.get(object)?.restore();
    this.#of.delete(object);
  }
  clear() {
    for (const holder of this.#of.values()) holder.restore();
    this.#of.clear();
  }

  /** Gives each place its number, and notes which are drawn whatever the camera sees. */
  number() {
    this.#owner = [];
    this.#several = [];
    this.#shownSingles = [];
    this.#always = [];
    this.#casters = [];
    for (const holder of this.#of.values()) {
      holder.first = this.#owner.length;
      for (let i = 0; i < holder.count; ++i) {
        const place = this.#owner.push(holder) - 1;
        if (!holder.frustumCulled || !isOfNumbers(holder.box(i))) this.#always.push(place);
        else if (holder.object.castShadow) this.#casters.push(place);
      }
      if (holder instanceof Single) {
        holder.show(0);
        this.#shownSingles.push(holder.first);
      } else {
        this.#several.push(holder);
      }
    }
    this.#isSingle = Uint8Array.from(this.#owner, (holder) => (holder instanceof Single ? 1 : 0));
    this.#shownIn = new Uint32Array(this.#owner.length).fill(this.#frame);
  }
  /**
   * @param {Object3D} object
   * @returns {number[]}
   */
  placesOf(object) {
    const holder = this.#of.get(object);
    return holder ? Array.from({ length: holder.count }, (_, i) => holder.first + i) : [];
  }
  /**
   * @param {number} place
   */
  at(place) {
    const holder = this.#owner[place];
    const i = place - holder.first;
    const instanceId = holder instanceof Single ? -1 : holder instanceof Batch ? holder.ids[i] : i;
    return { object: holder.object, instanceId, firstTriangle: rangeOf(holder.geometry(i)).start / 3 };
  }
  /** @param {Object3D} mesh */
  instanceIds(mesh) {
    const holder = this.#of.get(mesh);
    if (!(holder instanceof Instances)) throw new TypeError('instanceIds: expected an InstancedMesh that was added');
    return holder.ids.subarray(0, holder.shown);
  }

  /**
   * World boxes of places, or of all.
   * @param {number[]} [places]
   */
  boxes(places) {
    const count = places?.length ?? this.#owner.length;
    const out = new Float64Array(6 * count);
    for (let i = 0; i < count; ++i) {
      const place = places ? places[i] : i;
      const holder = this.#owner[place];
      const index = place - holder.first;
      writeBox(out, 6 * i, holder.box(index), holder.matrix(index).elements);
    }
    return out;
  }

  /**
   * Shows these places, those that are always shown, and no others. Of meshes only those are touched that come or go.
   * @param {Uint32Array} places
   * @param {boolean} shadows whether they are drawn
   */
  show(places, shadows) {
    const before = this.#shownSingles;
    const last = this.#frame++;
    this.#shownSingles = [];
    for (const holder of this.#several) holder.hide();
    for (const some of [places, this.#always, shadows ? this.#casters : []])
      for (let i = 0; i < some.length; ++i) {
        const place = some[i];
        if (this.#isSingle[place] === 0) {
          const holder = this.#owner[place];
          holder.show(place - holder.first);
          continue;
        }
        if (this.#shownIn[place] === this.#frame) continue;
        if (this.#shownIn[place] !== last) this.#owner[place].show(0);
        this.#shownIn[place] = this.#frame;
        this.#shownSingles.push(place);
      }
    for (const place of before) if (this.#shownIn[place] !== this.#frame) this.#owner[place].hide();
    for (const holder of this.#several) /** @type {Instances | Batch} */ (holder).finish();
  }

  /**
   * A scene whose items are the places, for rays.
   * @param {import('./load.js').Sightline} sightline
   */
  traced(sightline) {
    const scene = sightline.createScene();
    /** @type {Map<any, number>} */ const meshes = new Map();
    for (let place = 0; place < this.#owner.length; ++place) {
      const holder = this.#owner[place];
      const index = place - holder.first;
      const part = holder.geometry(index);
      let mesh = meshes.get(part.key);
      if (mesh === undefined) {
        mesh = scene.addMesh(trianglesOf(part));
        meshes.set(part.key, mesh);
      }
      scene.addInstance(0, mesh, { matrix: holder.matrix(index).elements });
    }
    return scene.commit();
  }
}

/** @typedef {{ geometry: any, first: number, count: number }} Part some of a geometry's indices */

/**
 * Those indices that are drawn.
 * @param {Part} part
 */
function rangeOf({ geometry, first, count }) {
  const { drawRange } = geometry;
  const all = geometry.index?.count ?? geometry.getAttribute('position').count;
  const start = Math.max(first, drawRange.start);
  const end = Math.min(first + count, drawRange.start + drawRange.count, all);
  return { start, end: start + 3 * Math.floor(Math.max(0, end - start) / 3) };
}

/**
 * The triangles that are drawn, and of the vertices those from their first to their last.
 * @param {Part} part
 */
export function trianglesOf(part) {
  const { start, end } = rangeOf(part);
  const { index } = part.geometry;
  const attribute = part.geometry.getAttribute('position');
  const indices = Uint32Array.from({ length: end - start }, (_, i) => (index ? index.getX(start + i) : start + i));
  let least = attribute.count;
  let most = -1;
  for (const vertex of indices) {
    if (vertex < least) least = vertex;
    if (vertex > most) most = vertex;
  }
  const positions = new Float32Array(3 * Math.max(0, most - least + 1));
  for (let vertex = least, at = 0; vertex <= most; ++vertex) {
    positions[at++] = attribute.getX(vertex);
    positions[at++] = attribute.getY(vertex);
    positions[at++] = attribute.getZ(vertex);
  }
  return { positions, indices: indices.map((vertex) => vertex - least) };
}
