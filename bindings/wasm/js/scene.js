// Scenes of plants: nodes with names and attributes, items (analytic primitives and meshes), what a view shows of them,
// and what a ray hits. See core/scene.h, importers/import.h and raytrace/tracer.h of the C++ library, whose promises
// hold here.

import { NativeObject, SightlineError, sizeOf } from './objects.js';

/** @typedef {import('./culling.js').Numbers} Numbers */
/** @typedef {import('./culling.js').View} View */

/** Programs of primitives.js, in the order of the module. */
const kPrograms = ['cylinder', 'snout', 'circular_torus', 'sphere_cap', 'rectangular_torus', 'pyramid', 'box'];

const kNone = 0xffffffff;
const kIdentity = Object.freeze([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
const kHitNumbers = 11;
const kOccluderPixels = 1024;

/**
 * A primitive in its own coordinates: its kind, and lengths and angles in the order of core/primitive.h.
 * @typedef {object} Primitive
 * @property {string} kind 'cylinder', 'snout', 'circular_torus', 'box', …: Scene.kinds
 * @property {ArrayLike<number>} parameters of a cylinder radius and height; of a snout the radii, height, offsets and
 *     the four shears; of a circular torus the major and the tube's radius and the angle; of a box its three sizes
 */

/**
 * @typedef {object} ImportReport
 * @property {string[]} warnings what was noticed and did not stop the import
 * @property {Record<string, number>} items by kind, as the file has them
 * @property {number} metresPerUnit
 * @property {number} degenerate items without volume
 * @property {number} attributed nodes that got attributes
 */

/**
 * @typedef {object} Hit
 * @property {number} item
 * @property {number} node that the item hangs on
 * @property {number} distance in units of the ray's direction
 * @property {[number, number, number]} point
 * @property {[number, number, number]} normal of unit length, out of the solid
 * @property {number} triangle of a mesh, -1 for analytic primitives
 * @property {string} face 'side', 'top', 'triangle', …
 */

/**
 * @typedef {object} MeshInstance
 * @property {number} item
 * @property {number} mesh
 * @property {[number, number, number, number]} colour sRGB and alpha, 0 to 1
 * @property {Float64Array} matrix world from mesh, sixteen numbers in columns
 */

/** @param {string} text ended by NULs */
function split(text) {
  const parts = text.split('\0');
  parts.pop();
  return parts;
}

/**
 * A scene. Nodes and items are numbers; node 0 is the root. Coordinates are metres with z up. Edits show after
 * commit(). Arrays that methods return are copies unless they say otherwise.
 */
export class Scene extends NativeObject {
  /** @type {string[]} */ #kinds;
  /** @type {string[]} */ #faces;

  /**
   * @internal
   * @param {import('./objects.js').Bridge} bridge
   */
  constructor(bridge) {
    super(bridge, bridge.checked(bridge.exports.sl_scene_create()), 'sl_scene_destroy');
    bridge.exports.sl_scene_kind_names(this.address);
    this.#kinds = split(bridge.answerText());
    bridge.exports.sl_scene_face_names(this.address);
    this.#faces = split(bridge.answerText());
  }

  /** Names of kinds, by the numbers of itemKinds(). */
  get kinds() {
    return this.#kinds;
  }

  // --- reading and building

  /**
   * Reads a file's bytes: a plant model (.rvm, .rev), its attributes (.txt, .att), a scene cache (.slc). A file that
   * cannot be read changes nothing and throws.
   * @param {ArrayBuffer | Uint8Array} bytes
   * @param {string} name whose extension tells the format
   * @param {{ lenient?: boolean }} [options] lenient: imports what it can of a damaged file
   * @returns {ImportReport}
   */
  read(bytes, name, { lenient = false } = {}) {
    const content = bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes);
    const title = new TextEncoder().encode(name);
    const { bridge } = this;
    bridge.withScratch(sizeOf([Uint8Array, content], [Uint8Array, title]), () => {
      const file = bridge.lend(Uint8Array, content);
      const at = bridge.lend(Uint8Array, title);
      const { sl_scene_read } = bridge.exports;
      bridge.checked(sl_scene_read(this.address, file, content.length, at, title.length, lenient));
    });
    bridge.freeScratch();
    bridge.exports.sl_scene_warnings(this.address);
    const warnings = split(bridge.answerText());
    bridge.exports.sl_scene_report(this.address);
    const [metresPerUnit, degenerate, attributed, ...counts] = bridge.answer(Float64Array);
    const items = Object.fromEntries(this.#kinds.map((kind, i) => [kind, counts[i]]));
    return { warnings, items, metresPerUnit, degenerate, attributed };
  }

  /**
   * Adds a node and returns its number.
   * @param {number} parent
   * @param {string} [name]
   * @param {ArrayLike<number>} [parentFromNode] sixteen numbers in columns
   */
  addNode(parent, name = '', parentFromNode = kIdentity) {
    const text = new TextEncoder().encode(name);
    const { bridge } = this;
    return this.#added(sizeOf([Uint8Array, text]) + 128, () => {
      const matrix = bridge.lend(Float64Array, parentFromNode);
      const at = bridge.lend(Uint8Array, text);
      return bridge.exports.sl_scene_add_node(this.address, parent, at, text.length, matrix);
    });
  }
  /**
   * Adds a mesh that items may share, and returns its number for addInstance().
   * @param {{ positions: Numbers, indices: Numbers, normals?: Numbers }} mesh three numbers a vertex, three indices a
   *     triangle, counter-clockwise from outside
   */
  addMesh({ positions, indices, normals }) {
    if (normals && normals.length !== positions.length)
      throw new TypeError('normals: expected as many as positions');
    const { bridge } = this;
    const size = sizeOf([Float32Array, positions], [Float32Array, normals ?? []], [Uint32Array, indices]);
    return this.#added(size, () => {
      const points = bridge.lend(Float32Array, positions);
      const directions = normals ? bridge.lend(Float32Array, normals) : 0;
      const corners = bridge.lend(Uint32Array, indices);
      const { sl_scene_add_mesh } = bridge.exports;
      return sl_scene_add_mesh(this.address, points, positions.length / 3, directions, corners, indices.length);
    });
  }
  /**
   * Adds a material and returns its number.
   * @param {number} red sRGB, 0 to 1, as the others
   * @param {number} green
   * @param {number} blue
   * @param {number} [alpha]
   */
  addMaterial(red, green, blue, alpha = 1) {
    return this.#added(0, () => this.bridge.exports.sl_scene_add_material(this.address, red, green, blue, alpha));
  }
  /**
   * Adds an analytic primitive and returns its item.
   * @param {number} node
   * @param {Primitive} primitive
   * @param {{ matrix?: ArrayLike<number>, material?: number }} [options] matrix: node from primitive
   */
  addPrimitive(node, { kind, parameters }, { matrix = kIdentity, material = kNone } = {}) {
    const number = this.#kinds.indexOf(kind);
    if (number < 0) throw new TypeError(`kind: expected one of ${this.#kinds.join(', ')}`);
    const { bridge } = this;
    return this.#added(sizeOf([Float32Array, parameters]) + 128, () => {
      const placement = bridge.lend(Float64Array, matrix);
      const values = bridge.lend(Float32Array, parameters);
      const { sl_scene_add_primitive } = bridge.exports;
      return sl_scene_add_primitive(this.address, node, number, values, parameters.length, placement, material);
    });
  }
  /**
   * Adds an item that shows a mesh, and returns it.
   * @param {number} node
   * @param {number} mesh
   * @param {{ matrix?: ArrayLike<number>, material?: number }} [options] matrix: node from mesh
   */
  addInstance(node, mesh, { matrix = kIdentity, material = kNone } = {}) {
    return this.#added(128, () =>
      this.bridge.exports.sl_scene_add_instance(
        this.address,
        node,
        mesh,
        this.bridge.lend(Float64Array, matrix),
        material,
      ),
    );
  }
  /** @param {number} item */
  removeItem(item) {
    this.bridge.checked(this.bridge.exports.sl_scene_remove_item(this.address, item));
  }
  /**
   * @param {number} item
   * @param {ArrayLike<number>} matrix node from item
   */
  setPlacement(item, matrix) {
    this.#withMatrix(matrix, (at) => this.bridge.exports.sl_scene_set_placement(this.address, item, at));
  }
  /**
   * @param {number} node
   * @param {ArrayLike<number>} matrix parent from node
   */
  setTransform(node, matrix) {
    this.#withMatrix(matrix, (at) => this.bridge.exports.sl_scene_set_transform(this.address, node, at));
  }
  /**
   * @param {number} item
   * @param {boolean} visible
   */
  setItemVisible(item, visible) {
    this.bridge.checked(this.bridge.exports.sl_scene_set_item_visible(this.address, item, visible));
  }
  /**
   * Hides or shows all that hangs below a node.
   * @param {number} node
   * @param {boolean} visible
   */
  setNodeVisible(node, visible) {
    this.bridge.checked(this.bridge.exports.sl_scene_set_node_visible(this.address, node, visible));
  }
  /** Publishes all edits, or throws where one cannot be, with none published. */
  commit() {
    this.bridge.checked(this.bridge.exports.sl_scene_commit(this.address));
    return this;
  }

  // --- what is in it

  /** Parents of all nodes; 0xffffffff of the root. */
  parents() {
    this.bridge.checked(this.bridge.exports.sl_scene_parents(this.address));
    return this.bridge.answer(Uint32Array).slice();
  }
  /** Names of all nodes. */
  names() {
    this.bridge.checked(this.bridge.exports.sl_scene_names(this.address));
    return split(this.bridge.answerText());
  }
  /**
   * Nodes that a text names, parents first, by the first step that finds any: a path or its end, a name, the value of an
   * attribute (`KEY=TEXT`: of one), whole words. `*`, `?` and `re:` make a pattern of it. See core/find_nodes.h.
   * @param {string} text
   * @returns {Uint32Array}
   */
  find(text) {
    const name = new TextEncoder().encode(text);
    const { bridge } = this;
    bridge.withScratch(sizeOf([Uint8Array, name]), () => {
      const at = bridge.lend(Uint8Array, name);
      bridge.checked(bridge.exports.sl_scene_find(this.address, at, name.length));
    });
    return bridge.answer(Uint32Array).slice();
  }
  /**
   * @param {number} node
   * @returns {[string, string][]} keys and values, in the order of the file
   */
  attributes(node) {
    this.bridge.checked(this.bridge.exports.sl_scene_attributes(this.address, node));
    const parts = split(this.bridge.answerText());
    return Array.from({ length: parts.length / 2 }, (_, i) => [parts[2 * i], parts[2 * i + 1]]);
  }
  /** Nodes of all items; 0xffffffff of those that were removed. */
  itemNodes() {
    this.bridge.checked(this.bridge.exports.sl_scene_item_nodes(this.address));
    return this.bridge.answer(Uint32Array).slice();
  }
  /** Kinds of all items, as places in `kinds`; 255 of those that were removed. */
  itemKinds() {
    this.bridge.checked(this.bridge.exports.sl_scene_item_kinds(this.address));
    return this.bridge.answer(Uint8Array).slice();
  }
  /** Boxes of all items, six numbers each: Infinity to -Infinity of those that are not shown. */
  boxes() {
    this.bridge.checked(this.bridge.exports.sl_scene_boxes(this.address));
    return this.bridge.answer(Float64Array).slice();
  }

  // --- what is drawn

  /**
   * Analytic primitives for primitives.js.
   * @returns {import('./primitives.js').PackedPrimitives & { items: Record<string, Uint32Array> }}
   */
  packed() {
    const { bridge, address } = this;
    /** @type {Record<string, Uint32Array>} */ const records = {};
    /** @type {Record<string, Uint32Array>} */ const items = {};
    kPrograms.forEach((program, i) => {
      bridge.checked(bridge.exports.sl_scene_records(address, i));
      const words = bridge.answer(Uint32Array);
      if (words.length === 0) return;
      records[program] = words.slice();
      bridge.checked(bridge.exports.sl_scene_record_items(address, i));
      items[program] = bridge.answer(Uint32Array).slice();
    });
    bridge.exports.sl_scene_chunk_origins(address);
    const chunkOrigins = bridge.answer(Float64Array).slice();
    bridge.checked(bridge.exports.sl_scene_materials(address));
    return { records, items, chunkOrigins, materials: bridge.answer(Float32Array).slice() };
  }
  /** @returns {MeshInstance[]} items that are meshes */
  instances() {
    const { bridge, address } = this;
    bridge.checked(bridge.exports.sl_scene_instances(address));
    const words = bridge.answer(Uint32Array).slice();
    bridge.checked(bridge.exports.sl_scene_instance_matrices(address));
    const matrices = bridge.answer(Float64Array).slice();
    bridge.checked(bridge.exports.sl_scene_materials(address));
    const rows = bridge.answer(Float32Array).slice();
    return Array.from({ length: words.length / 3 }, (_, i) => {
      const [item, mesh, row] = words.subarray(3 * i, 3 * i + 3);
      const [red, green, blue, alpha] = rows.subarray(4 * row, 4 * row + 4);
      return { item, mesh, colour: [red, green, blue, alpha], matrix: matrices.subarray(16 * i, 16 * i + 16) };
    });
  }
  /**
   * A mesh's arrays; `normals` are empty where it is flat.
   * @param {number} mesh as instances() has it
   */
  mesh(mesh) {
    const { bridge, address } = this;
    /** @type {<T extends import('./objects.js').ArrayType>(Type: T, part: number) => InstanceType<T>} */
    const part = (Type, number) => {
      bridge.checked(bridge.exports.sl_scene_mesh(address, mesh, number));
      return /** @type {any} */ (bridge.answer(Type).slice());
    };
    return { positions: part(Float32Array, 0), normals: part(Float32Array, 1), indices: part(Uint32Array, 2) };
  }

  // --- what a view shows, what a ray hits

  /**
   * The items that a view shows, as of the last commit. A view of the module's memory, valid until the next call.
   * @param {View} view
   * @param {import('./culling.js').Limits} [limits]
   * @returns {Uint32Array}
   */
  visible(view, { behind, leastArea = 0 } = {}) {
    const { bridge } = this;
    bridge.checked(bridge.exports.sl_scene_visible(this.address, view.address, behind?.address ?? 0, leastArea));
    return bridge.answer(Uint32Array);
  }
  /**
   * Makes a pyramid the depth of the view's opaque primitives, by occluders within them: for visible().
   * @param {View} view
   * @param {import('./culling.js').DepthPyramid} pyramid
   * @param {{ leastArea?: number }} [options] pixels that an occluder must be expected to cover: small ones cost more
   *     than they hide
   */
  occlude(view, pyramid, { leastArea = kOccluderPixels } = {}) {
    const { sl_scene_occluders } = this.bridge.exports;
    this.bridge.checked(sl_scene_occluders(this.address, view.address, pyramid.address, leastArea));
    return pyramid;
  }
  /**
   * The first hit of a ray, or null. The first call builds the tracer.
   * @param {ArrayLike<number>} origin
   * @param {ArrayLike<number>} direction
   * @param {{ from?: number, to?: number, view?: View }} [options] range in units of the direction; the view whose
   *     sections cut
   * @returns {Hit | null}
   */
  pick(origin, direction, options = {}) {
    return this.#hits(origin, direction, options, false)[0] ?? null;
  }
  /**
   * Every crossing with a surface, in order.
   * @param {ArrayLike<number>} origin
   * @param {ArrayLike<number>} direction
   * @param {{ from?: number, to?: number, view?: View }} [options]
   */
  pickAll(origin, direction, options = {}) {
    return this.#hits(origin, direction, options, true);
  }

  /**
   * @param {ArrayLike<number>} origin
   * @param {ArrayLike<number>} direction
   * @param {{ from?: number, to?: number, view?: View }} options
   * @param {boolean} all
   * @returns {Hit[]}
   */
  #hits(origin, direction, { from = 0, to = Infinity, view }, all) {
    if (origin.length !== 3 || direction.length !== 3) throw new TypeError('ray: expected three numbers each');
    const { bridge } = this;
    const ray = [...Array.from(origin), ...Array.from(direction), from, to];
    return bridge.withScratch(sizeOf([Float64Array, ray]), () => {
      const at = bridge.lend(Float64Array, ray);
      bridge.checked(bridge.exports.sl_scene_hits(this.address, at, view?.address ?? 0, all));
      const numbers = bridge.answer(Float64Array);
      return Array.from({ length: numbers.length / kHitNumbers }, (_, i) => {
        const [item, distance, x, y, z, nx, ny, nz, triangle, face, node] = numbers.subarray(kHitNumbers * i);
        return { item, node, distance, point: [x, y, z], normal: [nx, ny, nz], triangle, face: this.#faces[face] };
      });
    });
  }
  /**
   * @param {number} size
   * @param {() => number} add
   */
  #added(size, add) {
    const number = this.bridge.withScratch(size, add) >>> 0;
    return number === kNone ? this.bridge.fail() : number;
  }
  /**
   * @param {ArrayLike<number>} matrix
   * @param {(address: number) => number} set
   */
  #withMatrix(matrix, set) {
    if (matrix.length !== 16) throw new SightlineError('matrix: expected sixteen numbers in columns');
    this.bridge.withScratch(128, () => this.bridge.checked(set(this.bridge.lend(Float64Array, matrix))));
  }
}
