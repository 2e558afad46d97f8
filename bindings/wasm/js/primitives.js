// @ts-nocheck: comments give the types of what is exported; what is not has none.
// Draws analytic primitives (cylinders, cones, tori, …) in three.js by casting a ray in each pixel, without triangles:
// round at any distance, 64 to 112 bytes each. Needs WebGL2 and three's WebGLRenderer.
import {
  BufferAttribute,
  ColorManagement,
  DataTexture,
  DoubleSide,
  DynamicDrawUsage,
  FloatType,
  GLSL3,
  Group,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  IntType,
  Matrix3,
  Matrix4,
  Mesh,
  RawShaderMaterial,
  RGBAFormat,
  RGBAIntegerFormat,
  SRGBTransfer,
  UnsignedIntType,
  Vector3,
  Vector4,
} from 'three';

import {fragmentShader, vertexShader} from './shaders.js';
import {clippingPlanesOf, MOST_SECTIONS} from './three_camera.js';

/**
 * The kinds that are drawn, each by a program of its own, and the length of their records in 32-bit words. Kinds of RVM
 * that are not named: spheres, elliptical and spherical dishes are `sphere_cap`.
 */
export const RECORD_WORDS = Object.freeze({
  cylinder: 16,
  snout: 28,
  circular_torus: 20,
  sphere_cap: 16,
  rectangular_torus: 20,
  pyramid: 24,
  box: 16,
});

/**
 * Primitives as the desktop's renderer keeps them (gpuprims/internal/packing.h writes the records, and describes them).
 *
 * @typedef {Object} PackedPrimitives
 * @property {Object<string, Uint32Array>} records By kind, RECORD_WORDS[kind] words for each primitive. Words 0 to 8:
 *   linear part of the placement, column by column, and 9 to 11: its origin, relative to the chunk's, as floats. 12:
 *   chunk. 13: item id, which transparent items are dithered by. 14: row of `materials` in the low 24 bits, flags above
 *   (1 << 24: the bottom or the start is open, 1 << 25: the top or the end is). 15 and further: shape, as floats.
 * @property {Float64Array} chunkOrigins Three coordinates for each chunk, in the frame of the object that is made.
 * @property {Float32Array} materials Four numbers for each row: sRGB colour and alpha, 0 to 1.
 * @property {Object<string, Uint32Array>} [items] By kind, the number by which setVisible() knows each record. A number
 *   may not be given twice. Without it, records are numbered from 0 through all kinds, in the order of RECORD_WORDS.
 */

/** Texels of a row of each texture: kTexelRowBits in es.glsl. */
const ROW = 2048;

/** Corners of the two triangles of each visible side of a proxy: gpuscene::kProxyTriangles. */
const PROXY_TRIANGLES = [1, 3, 5, 5, 3, 7, 5, 7, 4, 4, 7, 6, 2, 6, 3, 3, 6, 7];

const NO_RECORD = 0xffffffff;
const RECORD_BITS = 28;  // of a place; the kind is above them

/** Texture of RGBA texels in rows of ROW, with room for `texels` of them. */
function makeTexture(data, texels, integer) {
  const height = Math.max(1, Math.ceil(texels / ROW));
  const padded = new data.constructor(4 * ROW * height);
  padded.set(data);
  const format = integer ? RGBAIntegerFormat : RGBAFormat;
  const texture = new DataTexture(padded, ROW, height, format, integer ? UnsignedIntType : FloatType);
  texture.internalFormat = integer ? 'RGBA32UI' : 'RGBA32F';
  texture.needsUpdate = true;
  return texture;
}

// ---- The view, as gpuprims/view_block.cpp computes it: in double, of which float is only the last step.

const floatOf = new Float32Array(1), bitsOf = new Uint32Array(floatOf.buffer);

/** The leading 12 of a float's 24 bits: leading_bits() in pairs.glsl. */
function leadingBits(x) {
  floatOf[0] = x;
  bitsOf[0] &= 0xfffff000;
  return floatOf[0];
}

/** Matrix (16 numbers by columns) whose third row is reversed zero-to-one depth, of a camera's projection. */
function reversedClip(camera) {
  const clip = [...camera.projectionMatrix.elements];
  if (camera.reversedDepth !== true)
    for (let column = 0; column < 16; column += 4) clip[column + 2] = 0.5 * (clip[column + 3] - clip[column + 2]);
  return clip;
}

/** Whether it is a perspective or orthographic projection along -z that mirrors nothing. */
function isPlain(clip) {
  const zeros = clip[11] !== 0.0 ? [1, 2, 3, 4, 6, 7, 15] : [1, 2, 3, 4, 6, 7];
  return clip[0] > 0.0 && clip[5] > 0.0 && zeros.every((i) => clip[i] === 0.0);
}

/** Eye depth of a reversed zero-to-one depth. */
function eyeDepth(clip, depth) {
  const denominator = clip[10] - depth * clip[11];
  return denominator === 0.0 ? Infinity : (clip[14] - depth * clip[15]) / denominator;
}

/** Uniforms that all kinds of an object share. They follow the camera in use. */
class SharedUniforms {
  /** @param {PackedPrimitives} packed */
  constructor(packed) {
    this.origins = Float64Array.from(packed.chunkOrigins);
    this.sectionCount = 0;
    this.state = [];  // all that the uniforms depend on
    const floats = (count) => new Float32Array(count);
    this.view = {
      eye_from_world: floats(9),
      eye_from_world_parts: floats(18),
      pixel_ray: floats(8),
      pixel_ray_rest: floats(4),
      clip_from_eye: floats(16),
      depth_range: floats(4),
      viewport: floats(4),
      up: floats(4),
      flags: new Int32Array(4),
      sections: floats(4 * MOST_SECTIONS),
      hatching: floats(4),  // none
      hatch_across: floats(8 * MOST_SECTIONS),
      hatch_whole: floats(4 * MOST_SECTIONS),
      lights: floats(8),  // none: a head-light
      sections_rest: floats(4 * MOST_SECTIONS),
    };
    const chunkTexels = 2 * this.origins.length / 3, materialTexels = packed.materials.length / 4;
    this.uniforms = {
      view: {value: this.view},
      chunk_origins: {value: makeTexture(floats(4 * chunkTexels), chunkTexels, false)},
      materials: {value: makeTexture(packed.materials, materialTexels, false)},
      one: {value: 1.0},
      linear_colour: {value: false},
      logarithmic_depth_scale: {value: 1.0},
    };
  }

  /**
   * Sets what depends on the camera, the viewport, the sections and the object's place. Does little if they are those of
   * the last call. Returns whether shaders know such projections.
   */
  update(renderer, camera, object) {
    const clip = reversedClip(camera);
    if (!isPlain(clip)) return false;
    const eyeFromObject = eye.multiplyMatrices(camera.matrixWorldInverse, object.matrixWorld).elements;
    renderer.getCurrentViewport(viewport);
    const {planes, unite} = clippingPlanesOf(renderer, object);
    const state = [...clip, ...eyeFromObject, ...viewport, ...camera.up, ...camera.matrixWorldInverse.elements, unite];
    for (const plane of planes) state.push(...plane.normal, plane.constant);
    const target = renderer.getRenderTarget();
    const space = target === null ? renderer.outputColorSpace :
        target.isXRRenderTarget   ? target.texture.colorSpace :
                                    ColorManagement.workingColorSpace;
    this.uniforms.linear_colour.value = ColorManagement.getTransfer(space) !== SRGBTransfer;
    this.uniforms.logarithmic_depth_scale.value = 1.0 / Math.log2(camera.far + 1.0);
    if (state.length === this.state.length && state.every((value, i) => value === this.state[i])) return true;
    this.state = state;
    this.setLinear(eyeFromObject);
    this.setProjection(clip, viewport);
    this.setOrigins(eyeFromObject);
    this.setSections(planes, unite, camera);
    const up = vector.copy(camera.up).transformDirection(camera.matrixWorldInverse);
    this.view.up.set([up.x, up.y, up.z, 0.0]);
    return true;
  }

  setLinear(eyeFromObject) {
    for (let column = 0; column < 3; ++column) {
      for (let row = 0; row < 3; ++row) {
        const value = eyeFromObject[4 * column + row], leading = leadingBits(value), at = 3 * column + row;
        this.view.eye_from_world[at] = value;
        this.view.eye_from_world_parts[at] = leading;
        this.view.eye_from_world_parts[9 + at] = value - leading;
      }
    }
  }

  /** The projection and the rays of pixels. `corner`: the viewport in pixels of the window. */
  setProjection(clip, corner) {
    const perspective = clip[11] !== 0.0, view = this.view;
    view.clip_from_eye.set(clip);
    view.depth_range.set([eyeDepth(clip, 1.0), Math.min(eyeDepth(clip, 0.0), 3.0e38), 0.0, 0.0]);
    view.viewport.set([corner.z, corner.w, corner.x, corner.y]);
    view.flags[0] = perspective ? 1 : 0;
    const sizes = [corner.z, corner.w];
    for (let axis = 0; axis < 2; ++axis) {
      // Solves clip.x = ndc.x * clip.w at eye depth t, for ndc.x = -1 + 2 p / size.
      const scale = 1.0 / clip[5 * axis], w = perspective ? -clip[11] : 1.0, step = scale * w * 2.0 / sizes[axis];
      const ray = perspective ? [0.0, 0.0, scale * (clip[8 + axis] - w), step] :
                                [-scale * (clip[12 + axis] + w), step, 0.0, 0.0];
      view.pixel_ray.set(ray, 4 * axis);
      for (let i = 0; i < 2; ++i) {
        const exact = ray[perspective ? 2 + i : i];
        view.pixel_ray_rest[2 * axis + i] = exact - Math.fround(exact);
      }
    }
  }

  /**
   * Chunk origins relative to the eye, along the object's axes: a float, and what that leaves. The matrix alone says
   * where the eye is, and it alone is not rounded: an origin is placed by it, and then turned back.
   */
  setOrigins(eyeFromObject) {
    const texture = this.uniforms.chunk_origins.value, texels = texture.image.data;
    const back = linear.setFromMatrix4(eye).invert();
    for (let i = 0; 3 * i < this.origins.length; ++i) {
      vector.fromArray(this.origins, 3 * i).applyMatrix4(eye).applyMatrix3(back);
      for (let axis = 0; axis < 3; ++axis) {
        const exact = vector.getComponent(axis);
        texels[8 * i + axis] = exact;
        texels[8 * i + 4 + axis] = exact - Math.fround(exact);
      }
    }
    texture.needsUpdate = true;
  }

  /** Half-spaces of the world in eye space. */
  setSections(planes, unite, camera) {
    this.sectionCount = planes.length;
    this.view.flags[1] = planes.length;
    this.view.flags[2] = unite ? 1 : 0;
    const worldFromEye = camera.matrixWorld.elements;
    const largest = planes.map((plane) => Math.abs(plane.constant));
    largest.push(Math.abs(worldFromEye[12]) + Math.abs(worldFromEye[13]) + Math.abs(worldFromEye[14]));
    this.view.depth_range[2] = 2 ** -49 * Math.max(...largest);
    planes.forEach(({normal, constant}, i) => {
      const plane = [normal.x, normal.y, normal.z, constant];
      for (let column = 0; column < 4; ++column) {
        let sum = 0.0;
        for (let row = 0; row < 4; ++row) sum += worldFromEye[4 * column + row] * plane[row];
        this.view.sections[4 * i + column] = sum;
        this.view.sections_rest[4 * i + column] = sum - Math.fround(sum);
      }
    });
  }

  dispose() {
    this.uniforms.chunk_origins.value.dispose();
    this.uniforms.materials.value.dispose();
  }
}

const eye = new Matrix4(), linear = new Matrix3(), viewport = new Vector4(), vector = new Vector3();

/** The primitives of one kind: an instance each, of which a list says which are drawn. */
class Batch extends Mesh {
  constructor(kind, records, shared, owner) {
    const words = RECORD_WORDS[kind];
    if (records.length % words !== 0)
      throw new RangeError(`AnalyticPrimitives: records of ${kind} must have ${words} words each, not ${records.length} in all`);
    const count = records.length / words, payload = makeTexture(records, records.length / 4, true);
    const drawn = new InstancedBufferAttribute(new Uint32Array(count), 1);
    drawn.gpuType = IntType;
    drawn.setUsage(DynamicDrawUsage);
    const geometry = new InstancedBufferGeometry();
    geometry.setIndex(new BufferAttribute(new Uint16Array(PROXY_TRIANGLES), 1));
    geometry.setAttribute('drawn_record', drawn);
    const kinds = Object.keys(RECORD_WORDS);
    const defines = {[kind.toUpperCase()]: '', TEXELS_PER_RECORD: words / 4};
    kinds.forEach((name, i) => defines[`${name.toUpperCase()}_KIND`] = `${i}u`);
    const material = new RawShaderMaterial({
      name: kind,
      side: DoubleSide,  // shaders give all triangles one winding, also of mirrored objects
      glslVersion: GLSL3,
      vertexShader,
      fragmentShader,
      defines,
      uniforms: {
        ...shared.uniforms,
        payload: {value: payload},
        batch_kind: {value: kinds.indexOf(kind)},
        texels_per_record: {value: words / 4},
      },
    });
    super(geometry, material);
    this.payload = payload;
    this.name = kind;
    this.frustumCulled = false;  // the list says what is drawn
    this.shared = shared;
    this.owner = owner;
    this.recordCount = count;
    this.wanted = new Uint8Array(count);  // a mark for each record, for drawWanted()
  }

  records() {
    return this.payload.image.data.subarray(0, this.recordCount * RECORD_WORDS[this.name]);
  }

  /** The records that draw() counts: for writing. */
  get list() {
    return this.geometry.attributes.drawn_record.array;
  }

  /**
   * Draws the records that are wanted, and wants none. In their order, whatever the culler's: where surfaces coincide,
   * the same one shows as when all are drawn.
   */
  drawWanted() {
    const list = this.list, wanted = this.wanted;
    let count = 0;
    for (let record = 0; record < wanted.length; ++record)
      if (wanted[record] !== 0) list[count++] = record;
    wanted.fill(0);
    this.draw(count);
  }

  /** Draws the first `count` records of the list. */
  draw(count) {
    const drawn = this.geometry.attributes.drawn_record;
    this.drawnCount = count;
    this.visible = count > 0;
    if (count === 0) return;
    drawn.clearUpdateRanges();
    drawn.addUpdateRange(0, count);
    drawn.needsUpdate = true;
  }

  /** Compiles for what the renderer's depth is and for whether there are sections. */
  choose(define, wanted) {
    const defines = this.material.defines;
    if (wanted === (define in defines)) return;
    if (wanted) defines[define] = '';
    else delete defines[define];
    this.material.needsUpdate = true;
  }

  onBeforeRender(renderer, scene, camera) {
    renderer.extensions.has('EXT_conservative_depth');  // shaders may use what has been asked for
    this.geometry.instanceCount = this.shared.update(renderer, camera, this.owner) ? this.drawnCount : 0;
    this.choose('REVERSED_DEPTH', renderer.state.buffers.depth.getReversed?.() === true);
    this.choose('LOGARITHMIC_DEPTH', renderer.capabilities.logarithmicDepthBuffer);
    this.choose('SECTIONS', this.shared.sectionCount > 0);
    this.material.uniformsNeedUpdate = true;
  }

  raycast() {}  // has no triangles

  dispose() {
    this.geometry.dispose();
    this.payload.dispose();
    this.material.dispose();
  }
}

/**
 * An object of a three.js scene that shows analytic primitives, ray-cast in each pixel. Their depth is that of any mesh
 * at that place, up to the rounding of the depth buffer, so they cover and are covered by meshes. Works in perspective
 * and orthographic views, with the eye inside primitives, with the renderer's reversed and logarithmic depth, in part
 * of the window, and in render targets.
 *
 * Positions stay exact far from the origin: the renderer's matrices, which are in double, meet the chunks' origins in
 * double, and only what is relative to the eye becomes float.
 *
 * Surfaces have the material's colour, lit from the eye and, less, from above (`camera.up`), on both sides. Lights of
 * the scene, fog, tone mapping and shadows have no effect. Alpha below 1 is dithered.
 *
 * Not drawn by cameras with sheared or mirrored projections (CubeCamera, Reflector). Raycaster finds nothing: exact
 * picks are the library's.
 */
export class AnalyticPrimitives extends Group {
  #shared;
  #batches = [];
  #places;  // for each item's number, the batch (high bits) and record

  /**
   * Copies all arrays. A kind may have a million records at least; beyond 2048 rows of 2048 texels, textures may be
   * larger than the device has.
   *
   * @param {PackedPrimitives} packed
   * @throws {RangeError} when records have an unknown kind or not whole length, or an item's number is not unique.
   */
  constructor(packed) {
    super();
    for (const kind in packed.records)
      if (!(kind in RECORD_WORDS)) throw new RangeError(`AnalyticPrimitives: no kind is named '${kind}'`);
    this.#shared = new SharedUniforms(packed);
    /**
     * Half-spaces of the world, as Material.clippingPlanes; null for none. Solids that they cut show a face there. The
     * renderer's own planes count too, unless `clipIntersection` is set. Of all together the first eight count.
     * @type {?Array<import('three').Plane>}
     */
    this.clippingPlanes = null;
    /** As Material.clipIntersection: what any of the planes keeps is drawn. */
    this.clipIntersection = false;
    /** Number of primitives. */
    this.count = 0;
    for (const kind in RECORD_WORDS) {
      const records = packed.records[kind];
      if (!records || records.length === 0) continue;
      const batch = new Batch(kind, records, this.#shared, this);
      this.count += batch.recordCount;
      this.#batches.push(batch);
      this.add(batch);
    }
    this.#places = this.#placeItems(packed.items);
    this.showAll();
  }

  #placeItems(items) {
    const numbers = this.#batches.map((batch) => items?.[batch.name]);
    let end = this.count;
    if (items) {
      end = 0;
      numbers.forEach((list, i) => {
        const batch = this.#batches[i];
        if (list?.length !== batch.recordCount)
          throw new RangeError(`AnalyticPrimitives: items of ${batch.name} must be as many as its records, ${batch.recordCount}`);
        for (const number of list) end = Math.max(end, number + 1);
      });
    }
    const places = new Uint32Array(end).fill(NO_RECORD);
    let next = 0;
    this.#batches.forEach((batch, i) => {
      for (let record = 0; record < batch.recordCount; ++record) {
        const number = items ? numbers[i][record] : next++;
        if (places[number] !== NO_RECORD) throw new RangeError(`AnalyticPrimitives: two records are item ${number}`);
        places[number] = (i << RECORD_BITS | record) >>> 0;
      }
    });
    return places;
  }

  /** Draws all primitives from the next frame on, as at first. */
  showAll() {
    for (const batch of this.#batches) {
      for (let record = 0; record < batch.recordCount; ++record) batch.list[record] = record;
      batch.draw(batch.recordCount);
    }
  }

  /**
   * Draws the primitives with these numbers, and no others, from the next frame on. Numbers that are no primitive's are
   * skipped, so a culler's list may be given that has meshes, too. Uploads four bytes for each primitive that is drawn.
   *
   * @param {ArrayLike<number>} items Numbers as PackedPrimitives.items gives them, in any order.
   * @param {number} [count] How many of the array count; all of them by default.
   */
  setVisible(items, count = items.length) {
    const wanted = this.#batches.map((batch) => batch.wanted);
    const places = this.#places, mask = 2 ** RECORD_BITS - 1;
    for (let i = 0; i < count; ++i) {
      const number = items[i];
      if (number < places.length && places[number] !== NO_RECORD) wanted[places[number] >>> RECORD_BITS][places[number] & mask] = 1;
    }
    for (const batch of this.#batches) batch.drawWanted();
  }

  /**
   * The table of materials, four numbers a row as given, for writing. Call updateMaterials() afterwards. Rows cannot be
   * added.
   * @return {Float32Array}
   */
  get materials() {
    return this.#shared.uniforms.materials.value.image.data;
  }

  /** Makes the next frame show what has been written to `materials`. */
  updateMaterials() {
    this.#shared.uniforms.materials.value.needsUpdate = true;
  }

  /**
   * Records of a kind as given, for writing, such as another material or placement; undefined without any. Call
   * updateRecords() afterwards.
   * @param {string} kind
   * @return {Uint32Array|undefined}
   */
  records(kind) {
    return this.#batch(kind)?.records();
  }

  /**
   * Makes the next frame show what has been written to records(kind). Uploads all records of that kind.
   * @param {string} kind
   */
  updateRecords(kind) {
    const batch = this.#batch(kind);
    if (batch) batch.payload.needsUpdate = true;
  }

  #batch(kind) {
    return this.#batches.find((batch) => batch.name === kind);
  }

  /** Frees what lies in GPU memory. The object must not be drawn afterwards. */
  dispose() {
    for (const batch of this.#batches) batch.dispose();
    this.#shared.dispose();
  }
}
