// The package's way in: a module, and what can be made in it.

import { BoxCuller, DepthPyramid, OccluderRaster, View } from './culling.js';
import { instantiate } from './instance.js';
import { Bridge, NativeArray } from './objects.js';
import { Scene } from './scene.js';

/**
 * @typedef {object} LoadOptions
 * @property {number} [threads] for large queries, the calling one included; 1 unless told. More need a cross-origin
 *     isolated page, and start their workers at once.
 * @property {boolean} [simd] whether to use SIMD128; as the browser has it unless told
 * @property {URL | string} [url] of the .wasm file, where a server keeps it elsewhere
 * @property {WebAssembly.Module} [module] compiled already, such as by another worker
 */

/** A module with boxes, occluders and questions about boxes. Independent of others. */
export class Culling {
  /** @internal */
  bridge;

  /**
   * @internal
   * @param {Bridge} bridge
   */
  constructor(bridge) {
    this.bridge = bridge;
  }

  /** Whether it uses SIMD128. */
  get simd() {
    return this.bridge.instance.simd;
  }
  /** Threads that large queries use, the calling one included. */
  get threads() {
    return this.bridge.instance.threads;
  }
  /** Bytes of the module's memory, which never shrinks. */
  get memoryBytes() {
    return this.bridge.instance.memory.buffer.byteLength;
  }

  /**
   * An array in the module's memory.
   * @param {import('./objects.js').ArrayType} Type
   * @param {number} length
   */
  allocate(Type, length) {
    return new NativeArray(this.bridge, Type, length);
  }
  /** @param {import('./culling.js').Camera} camera */
  createView(camera) {
    return new View(this.bridge, camera);
  }
  /** @param {import('./culling.js').Numbers} boxes six numbers each: the least corner, the greatest */
  createBoxCuller(boxes) {
    return new BoxCuller(this.bridge, boxes);
  }
  createDepthPyramid() {
    return new DepthPyramid(this.bridge);
  }
  createOccluderRaster() {
    return new OccluderRaster(this.bridge);
  }

  /** Ends the module's workers, if it has any. Nothing of it may be used afterwards. */
  close() {
    this.bridge.instance.close();
  }
}

/** A module with all of the package: culling, and scenes. */
export class Sightline extends Culling {
  /** An empty scene. */
  createScene() {
    return new Scene(this.bridge);
  }
  /**
   * A scene of one file's bytes, committed.
   * @param {ArrayBuffer | Uint8Array} bytes
   * @param {string} name
   * @param {{ lenient?: boolean }} [options]
   */
  readScene(bytes, name, options = {}) {
    const scene = this.createScene();
    try {
      scene.read(bytes, name, options);
      return scene.commit();
    } catch (error) {
      scene.dispose();
      throw error;
    }
  }
}

/**
 * A module with all of the package.
 * @param {LoadOptions} [options]
 */
export async function load(options = {}) {
  return new Sightline(new Bridge(await instantiate('scene', options)));
}

/**
 * A module with culling alone.
 * @param {LoadOptions} [options]
 */
export async function loadCulling(options = {}) {
  return new Culling(new Bridge(await instantiate('culling', options)));
}
