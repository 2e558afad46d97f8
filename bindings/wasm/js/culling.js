// What a view shows of boxes. See culling/box_culler.h, culling/occlusion and culling/queries of the C++ library, whose
// promises hold here: the same answers to the bit.

import { NativeObject, sizeOf } from './objects.js';

/** @typedef {import('./objects.js').Bridge} Bridge */
/** @typedef {import('./objects.js').NativeArray} NativeArray */
/** @typedef {ArrayLike<number> | NativeArray} Numbers numbers, or an array that lies in the module's memory */

/**
 * Range of depths that a projection maps near and far to: -1 and 1 (WebGL), 0 and 1 (WebGPU), or 1 and 0 (reversed).
 * @typedef {'minusOneToOne' | 'zeroToOne' | 'reversed'} Depth
 */

/**
 * A camera. Matrices are sixteen numbers in columns, as three.js has them in `Matrix4.elements`.
 * @typedef {object} Camera
 * @property {ArrayLike<number>} view eye from world: affine, looking along -z
 * @property {ArrayLike<number>} projection clip from eye
 * @property {Depth} [depth] of the projection; 'minusOneToOne' unless told
 * @property {number} [width] of the image in pixels, for occlusion and sizes; 1 unless told
 * @property {number} [height]
 * @property {ArrayLike<number>[]} [sections] half-spaces that are kept, at most eight: normal and offset, of those
 *     points whose dot(normal, point) + offset is at least 0
 * @property {boolean} [anySection] points are kept that lie in any of them, not in all
 */

/** @type {Record<Depth, number>} */
const kDepths = { reversed: 0, minusOneToOne: 1, zeroToOne: 2 };

/**
 * @param {ArrayLike<number>} matrix
 * @param {string} what
 */
function checkMatrix(matrix, what) {
  if (matrix?.length !== 16) throw new TypeError(`${what}: expected sixteen numbers in columns`);
}

/** @param {Depth} depth */
function depthNumber(depth) {
  if (!(depth in kDepths)) throw new TypeError(`depth: expected one of ${Object.keys(kDepths).join(', ')}`);
  return kDepths[depth];
}

/**
 * Inverses that three.js computes have a last number that may be off by rounding.
 * @param {ArrayLike<number>} view
 */
function asAffine(view) {
  if (view[15] === 1 || !(Math.abs(view[15] - 1) < 1e-12)) return view;
  const affine = Float64Array.from(view);
  affine[15] = 1;
  return affine;
}

/** A camera in the module's memory. Reuse one from frame to frame. */
export class View extends NativeObject {
  /**
   * @internal
   * @param {Bridge} bridge
   * @param {Camera} camera
   */
  constructor(bridge, camera) {
    super(bridge, View.#give(bridge, camera, []), 'sl_view_destroy');
    this.#sections(camera);
  }

  /**
   * @param {Bridge} bridge
   * @param {Camera} camera
   * @param {number[]} to
   */
  static #give(bridge, camera, to) {
    const { view, projection, depth = 'minusOneToOne', width = 1, height = 1 } = camera;
    checkMatrix(view, 'view');
    checkMatrix(projection, 'projection');
    const range = depthNumber(depth);
    return bridge.withScratch(2 * 16 * 8, () => {
      const eye = bridge.lend(Float64Array, asAffine(view));
      const clip = bridge.lend(Float64Array, projection);
      const { sl_view_create, sl_view_set } = bridge.exports;
      const set = to.length === 0 ? sl_view_create : sl_view_set;
      return bridge.checked(set(...to, eye, clip, range, width, height));
    });
  }

  /**
   * Moves the camera; sections stay unless `camera` has some.
   * @param {Camera} camera
   */
  set(camera) {
    View.#give(this.bridge, camera, [this.address]);
    this.#sections(camera);
    return this;
  }

  /** @param {Camera} camera */
  #sections({ sections, anySection = false }) {
    if (!sections) return;
    const planes = Float64Array.from(sections.flatMap((plane) => Array.from(plane)));
    if (planes.length !== 4 * sections.length) throw new TypeError('sections: expected four numbers each');
    this.bridge.withScratch(sizeOf([Float64Array, planes]), () => {
      const address = this.bridge.lend(Float64Array, planes);
      this.bridge.checked(this.bridge.exports.sl_view_sections(this.address, address, sections.length, anySection));
    });
  }
}

/**
 * What else may be left out than what lies beyond the view volume.
 * @typedef {object} Limits
 * @property {DepthPyramid} [behind] leaves out what is hidden behind this depth, of the same view and its size
 * @property {number} [leastArea] leaves out what is expected to cover fewer pixels: this one is approximate
 */

/**
 * @typedef {object} RayHits
 * @property {Uint32Array} indices of boxes
 * @property {Float64Array} distances where the ray enters them, in units of its direction; of nearest(), in metres
 */

/**
 * Finds the boxes that a view shows. Boxes are six numbers each: the least corner, then the greatest. Box i is the i-th
 * of those given. Promise: conservative; a box with any point in the view volume is found.
 *
 * Arrays that methods return are views of the module's memory: valid until the next call of anything. Copy what must
 * last (`slice()`).
 */
export class BoxCuller extends NativeObject {
  #size;

  /**
   * @internal
   * @param {Bridge} bridge
   * @param {Numbers} boxes
   */
  constructor(bridge, boxes) {
    if (boxes.length % 6 !== 0) throw new TypeError(`boxes: expected six numbers each, got ${boxes.length} in all`);
    const count = boxes.length / 6;
    super(
      bridge,
      bridge.withScratch(sizeOf([Float64Array, boxes]), () =>
        bridge.checked(bridge.exports.sl_boxes_create(bridge.lend(Float64Array, boxes), count)),
      ),
      'sl_boxes_destroy',
    );
    this.#size = count;
  }

  /** How many boxes there are. */
  get size() {
    return this.#size;
  }

  /**
   * The indices of the visible boxes, in an order that is the same for the same boxes.
   * @param {View} view
   * @param {Limits} [limits]
   * @returns {Uint32Array}
   */
  visible(view, { behind, leastArea = 0 } = {}) {
    const { bridge } = this;
    bridge.checked(bridge.exports.sl_boxes_visible(this.address, view.address, behind?.address ?? 0, leastArea));
    return bridge.answer(Uint32Array);
  }

  /**
   * Visible boxes for projection * view, sixteen numbers in columns.
   * @param {ArrayLike<number>} clipFromWorld
   * @param {Depth} [depth]
   * @returns {Uint32Array}
   */
  visibleIn(clipFromWorld, depth = 'minusOneToOne') {
    checkMatrix(clipFromWorld, 'clipFromWorld');
    const range = depthNumber(depth);
    const { bridge } = this;
    return bridge.withScratch(16 * 8, () => {
      const matrix = bridge.lend(Float64Array, clipFromWorld);
      bridge.checked(bridge.exports.sl_boxes_visible_in(this.address, matrix, range));
      return bridge.answer(Uint32Array);
    });
  }

  /**
   * Replaces the boxes of these indices. Boxes that move far make culling slower, not wrong.
   * @param {Numbers} indices
   * @param {Numbers} boxes
   */
  update(indices, boxes) {
    if (boxes.length !== 6 * indices.length) throw new TypeError('update: expected six numbers for each index');
    const { bridge } = this;
    bridge.withScratch(sizeOf([Uint32Array, indices], [Float64Array, boxes]), () => {
      const at = bridge.lend(Uint32Array, indices);
      const values = bridge.lend(Float64Array, boxes);
      bridge.checked(bridge.exports.sl_boxes_update(this.address, at, values, indices.length));
    });
  }

  /**
   * Replaces all boxes, where they move every frame.
   * @param {Numbers} boxes
   */
  refit(boxes) {
    const { bridge } = this;
    bridge.withScratch(sizeOf([Float64Array, boxes]), () => {
      const values = bridge.lend(Float64Array, boxes);
      bridge.checked(bridge.exports.sl_boxes_refit(this.address, values, boxes.length / 6));
    });
  }

  /**
   * Boxes that share a point with a box, or with `inside` lie within it; in rising order.
   * @param {ArrayLike<number>} box
   * @param {{ inside?: boolean }} [rule]
   * @returns {Uint32Array}
   */
  inBox(box, { inside = false } = {}) {
    return this.#ask([Float64Array, box, 6], (address) =>
      this.bridge.exports.sl_boxes_in_box(this.address, address, inside ? 1 : 0),
    );
  }
  /**
   * Boxes within `radius` of a point, in rising order.
   * @param {ArrayLike<number>} point
   * @param {number} radius
   * @returns {Uint32Array}
   */
  around(point, radius) {
    return this.#ask([Float64Array, point, 3], (address) =>
      this.bridge.exports.sl_boxes_around(this.address, address, radius),
    );
  }
  /**
   * Boxes that a ray enters, front to back: all, or the first `most`.
   * @param {ArrayLike<number>} origin
   * @param {ArrayLike<number>} direction
   * @param {{ from?: number, to?: number, most?: number }} [range] of the ray, in units of its direction
   * @returns {RayHits}
   */
  along(origin, direction, { from = 0, to = Infinity, most = 0 } = {}) {
    const ray = [...Array.from(origin), ...Array.from(direction), from, to];
    const indices = this.#ask([Float64Array, ray, 8], (address) =>
      this.bridge.exports.sl_boxes_along(this.address, address, most),
    );
    return { indices, distances: this.#distances() };
  }
  /**
   * The `count` boxes nearest to a point, nearest first.
   * @param {ArrayLike<number>} point
   * @param {number} count
   * @returns {RayHits}
   */
  nearest(point, count) {
    const indices = this.#ask([Float64Array, point, 3], (address) =>
      this.bridge.exports.sl_boxes_nearest(this.address, address, count),
    );
    return { indices, distances: this.#distances() };
  }

  #distances() {
    this.bridge.exports.sl_boxes_distances(this.address);
    return this.bridge.answer(Float64Array);
  }
  /**
   * @param {[Float64ArrayConstructor, ArrayLike<number>, number]} numbers
   * @param {(address: number) => number} call
   */
  #ask([Type, values, count], call) {
    if (values.length !== count) throw new TypeError(`expected ${count} numbers, got ${values.length}`);
    return this.bridge.withScratch(sizeOf([Type, values]), () => {
      this.bridge.checked(call(this.bridge.lend(Type, values)));
      return this.bridge.answer(Uint32Array);
    });
  }
}

/** How far what is drawn lies, by blocks of pixels: what boxes are tested against. Keeps its memory. */
export class DepthPyramid extends NativeObject {
  /**
   * @internal
   * @param {Bridge} bridge
   */
  constructor(bridge) {
    super(bridge, bridge.checked(bridge.exports.sl_pyramid_create()), 'sl_pyramid_destroy');
  }

  /**
   * From an application's own depth of a view: distances along the viewing direction from the eye, row by row from the
   * bottom up, Infinity where nothing is.
   * @param {Numbers} distances
   * @param {number} width
   * @param {number} height
   */
  build(distances, width, height) {
    if (!(width > 0 && height > 0) || distances.length !== width * height)
      throw new TypeError(`distances: expected ${width} x ${height} of them, got ${distances.length}`);
    const { bridge } = this;
    bridge.withScratch(sizeOf([Float32Array, distances]), () => {
      const address = bridge.lend(Float32Array, distances);
      bridge.checked(bridge.exports.sl_pyramid_build(this.address, address, width, height));
    });
    return this;
  }

  /**
   * For each box 1 where it is hidden, or covers no pixel centre, else 0. `view` is the one that the depth is of. A
   * BoxCuller tests thousands faster.
   * @param {View} view
   * @param {Numbers} boxes
   * @returns {Uint8Array}
   */
  hides(view, boxes) {
    const { bridge } = this;
    const count = boxes.length / 6;
    return bridge.withScratch(sizeOf([Float64Array, boxes]) + count, () => {
      const values = bridge.lend(Float64Array, boxes);
      const hidden = bridge.scratch.address + bridge.scratch.used;
      bridge.checked(bridge.exports.sl_pyramid_hides(this.address, view.address, values, count, hidden));
      return bridge.view(Uint8Array, hidden, count).slice();
    });
  }
}

/**
 * A depth image of chosen occluders. Occluders must be solid, opaque and drawn: a wall, a vessel's inscribed cylinder,
 * the triangles of a mesh. The bounding box of a pipe is none. Promise: inner-conservative; a pixel holds a distance
 * only where the line of sight through its centre meets an occluder at that distance or nearer.
 */
export class OccluderRaster extends NativeObject {
  /**
   * @internal
   * @param {Bridge} bridge
   */
  constructor(bridge) {
    super(bridge, bridge.checked(bridge.exports.sl_raster_create()), 'sl_raster_destroy');
  }

  /**
   * Empties the image, for a view and the size of its image.
   * @param {View} view
   */
  begin(view) {
    this.bridge.checked(this.bridge.exports.sl_raster_begin(this.address, view.address));
    return this;
  }

  /**
   * Boxes that are solid. Returns how many may hide anything.
   * @param {Numbers} boxes
   */
  addBoxes(boxes) {
    return this.#addBoxes(boxes, (at, count) => this.bridge.exports.sl_raster_add_boxes(this.address, at, count));
  }
  /**
   * Those `most` of them that look largest.
   * @param {Numbers} boxes
   * @param {number} most
   */
  addLargest(boxes, most) {
    return this.#addBoxes(boxes, (at, count) =>
      this.bridge.exports.sl_raster_add_largest(this.address, at, count, most),
    );
  }
  /**
   * The cube -1 … 1 in a placement: an oriented box. False where it hides nothing.
   * @param {ArrayLike<number>} worldFromCube
   */
  addCube(worldFromCube) {
    return this.#addPlaced(worldFromCube, (at) => this.bridge.exports.sl_raster_add_cube(this.address, at));
  }
  /**
   * The cylinder of radius 1 about z, from -1 to 1, in a placement.
   * @param {ArrayLike<number>} worldFromCylinder
   * @param {number} [sides] 3 to 16 of the prism in it: more hide more and cost more
   */
  addCylinder(worldFromCylinder, sides = 8) {
    return this.#addPlaced(worldFromCylinder, (at) =>
      this.bridge.exports.sl_raster_add_cylinder(this.address, at, sides),
    );
  }
  /**
   * Triangles, seen from both sides.
   * @param {Numbers} positions three numbers each
   * @param {Numbers} indices three of a triangle
   * @param {ArrayLike<number>} worldFromMesh
   */
  addMesh(positions, indices, worldFromMesh) {
    checkMatrix(worldFromMesh, 'worldFromMesh');
    const { bridge } = this;
    const size = sizeOf([Float32Array, positions], [Uint32Array, indices]) + 16 * 8;
    bridge.withScratch(size, () => {
      const matrix = bridge.lend(Float64Array, worldFromMesh);
      const points = bridge.lend(Float32Array, positions);
      const corners = bridge.lend(Uint32Array, indices);
      const { sl_raster_add_mesh } = bridge.exports;
      const vertices = Math.floor(positions.length / 3);
      bridge.checked(sl_raster_add_mesh(this.address, points, vertices, corners, indices.length, matrix));
    });
  }

  /**
   * Hands the image to a pyramid. More occluders may follow.
   * @param {DepthPyramid} pyramid
   */
  build(pyramid) {
    this.bridge.checked(this.bridge.exports.sl_raster_build(this.address, pyramid.address));
    return pyramid;
  }
  /**
   * The image: metres from the eye along the viewing direction, row by row from the bottom up, Infinity where nothing
   * is.
   * @param {number} width
   * @param {number} height
   */
  distances(width, height) {
    const { bridge } = this;
    const count = width * height;
    return bridge.withScratch(4 * count, () => {
      const out = bridge.scratch.address;
      bridge.checked(bridge.exports.sl_raster_distances(this.address, out, count));
      return bridge.view(Float32Array, out, count).slice();
    });
  }

  /**
   * @param {Numbers} boxes
   * @param {(address: number, count: number) => number} add
   */
  #addBoxes(boxes, add) {
    if (boxes.length % 6 !== 0) throw new TypeError(`boxes: expected six numbers each, got ${boxes.length} in all`);
    return this.bridge.withScratch(sizeOf([Float64Array, boxes]), () =>
      add(this.bridge.lend(Float64Array, boxes), boxes.length / 6),
    );
  }
  /**
   * @param {ArrayLike<number>} matrix
   * @param {(address: number) => number} add
   */
  #addPlaced(matrix, add) {
    checkMatrix(matrix, 'placement');
    return this.bridge.withScratch(16 * 8, () => add(this.bridge.lend(Float64Array, matrix)) !== 0);
  }
}
