// "sightline/three": leaves out of a three.js scene what a camera does not show, picks exactly, and draws plants.
//
//   const sightline = await load();
//   const culler = new SceneCuller(sightline).add(scene);
//   renderer.setAnimationLoop(() => {
//     culler.update(camera, renderer);
//     renderer.render(scene, camera);
//   });

import { Vector3 } from 'three';

import { Plant } from './plant.js';
import { AnalyticPrimitives } from './primitives.js';
import { cameraOf } from './three_camera.js';
import { Holders } from './three_holders.js';
import { Occluder } from './three_occluder.js';

export { AnalyticPrimitives, Plant };

/** @typedef {import('three').Object3D} Object3D */
/** @typedef {import('three').Mesh} Mesh */
/** @typedef {import('three').Camera} Camera */
/** @typedef {import('./three_camera.js').Renderer} Renderer */
/** @typedef {import('./three_camera.js').CullerOptions} CullerOptions */

/**
 * @typedef {object} Pick
 * @property {Object3D} object
 * @property {number} instanceId of instanced and batched meshes, else -1
 * @property {Vector3} point in the world
 * @property {Vector3} normal of unit length, in the world
 * @property {number} distance from the ray's origin
 * @property {number} triangle of the geometry, as Raycaster's faceIndex
 */

/**
 * Calls `visit` for an object and all below it, but not within objects that cull themselves.
 * @param {any} object
 * @param {(object: any) => void} visit
 */
function traverse(object, visit) {
  if (object instanceof Plant || object instanceof AnalyticPrimitives) return;
  visit(object);
  for (const child of object.children) traverse(child, visit);
}

/**
 * Decides for meshes, and for each instance of instanced and batched meshes, whether a camera shows it. Conservative:
 * what has a part in the view volume, and in front of the occluders, is drawn.
 *
 * Meshes that are left out have no layers meanwhile; their children are not affected. Instances of an InstancedMesh are
 * drawn from the front of its arrays (and of instanced attributes of its geometry, which must be its own) in another
 * order: `instanceIds()` tells which they are. To change layers, instances or geometries, remove() the mesh, and add()
 * it again. Skinned and morphed meshes are left alone, as are lines, points, sprites and Plants.
 *
 * Always drawn are meshes that were added with `frustumCulled` false, those whose geometry has vertices that are no
 * numbers, and, while the renderer draws shadows, those that cast one: it falls into the image from outside of it, too.
 */
export class SceneCuller {
  #sightline;
  #holders = new Holders();
  /** @type {Map<Mesh, Occluder>} */ #occluders = new Map();
  /** @type {any} */ #culler = null;
  /** @type {any} */ #view = null;
  /** @type {any} */ #raster = null;
  /** @type {any} */ #pyramid = null;
  /** @type {any} */ #scene = null;
  #stale = true;

  /**
   * May be changed from frame to frame.
   * @type {Required<CullerOptions>}
   */
  options;

  /** How the last update() went. */
  stats = { tested: 0, visible: 0, milliseconds: 0 };

  /**
   * @param {import('./load.js').Culling} sightline for picks a module of "sightline", else "sightline/culling" will do
   * @param {CullerOptions} [options]
   */
  constructor(sightline, options = {}) {
    this.#sightline = sightline;
    this.options = { leastArea: 0, occlusionWidth: 0, ...options };
  }

  /**
   * Culls an object and all below it from now on. World matrices must be up to date (updateWorldMatrix).
   * @param {Object3D} root
   */
  add(root) {
    root.updateWorldMatrix(true, true);
    traverse(root, (object) => this.#holders.add(object));
    this.#stale = true;
    return this;
  }
  /**
   * Shows an object and all below it again, and culls it no more.
   * @param {Object3D} root
   */
  remove(root) {
    traverse(root, (object) => {
      this.#holders.remove(object);
      this.#occluders.delete(object);
    });
    this.#stale = true;
    return this;
  }

  /**
   * What is hidden behind this mesh is left out. It must be opaque, drawn, and not move in the vertex shader; three to
   * three hundred large ones are best. Sides that its material does not draw hide nothing.
   * @param {Mesh} mesh
   */
  addOccluder(mesh) {
    this.#occluders.set(mesh, new Occluder(mesh));
    return this;
  }

  /**
   * Says that an object and what is below it moved.
   * @param {Object3D} root
   */
  moved(root) {
    root.updateWorldMatrix(true, true);
    if (this.#stale || !this.#culler) return;
    /** @type {number[]} */ const indices = [];
    traverse(root, (object) => {
      for (const place of this.#holders.placesOf(object)) indices.push(place);
    });
    if (indices.length > 0) this.#culler.update(indices, this.#holders.boxes(indices));
    this.#scene?.dispose();
    this.#scene = null;
  }

  /**
   * Shows what the camera shows, and nothing else of what was added.
   * @param {Camera} camera
   * @param {Renderer} renderer
   */
  update(camera, renderer) {
    const start = performance.now();
    if (this.#stale) this.#rebuild();
    camera.updateWorldMatrix(true, false); // with what it is attached to, as render() will
    const occludes = this.#occluders.size > 0;
    const seen = cameraOf(camera, renderer, occludes ? this.options.occlusionWidth : 0);
    const view = (this.#view = this.#view ? this.#view.set(seen) : this.#sightline.createView(seen));
    const behind = occludes ? this.#occlude(view, camera) : undefined;
    const visible = this.#culler.visible(view, { behind, leastArea: this.options.leastArea * seen.pixels });
    this.#holders.show(visible, renderer.shadowMap?.enabled !== false);
    this.stats = {
      tested: this.#culler.size,
      visible: visible.length,
      milliseconds: performance.now() - start,
    };
  }

  /**
   * The first triangle that a ray hits, of all that was added, watertight and in double; null for none. The first pick
   * builds a tracer, as does the first after a change.
   * @param {{ origin: Vector3, direction: Vector3 }} ray such as Raycaster.ray
   * @returns {Pick | null}
   */
  pick({ origin, direction }) {
    if (!('createScene' in this.#sightline)) throw new TypeError('pick: expected a module of "sightline"');
    if (this.#stale) this.#rebuild();
    this.#scene ??= this.#holders.traced(/** @type {any} */ (this.#sightline));
    const hit = this.#scene.pick([origin.x, origin.y, origin.z], [direction.x, direction.y, direction.z]);
    if (!hit) return null;
    const { object, instanceId, firstTriangle } = this.#holders.at(hit.item);
    const distance = hit.distance * direction.length();
    return {
      object,
      instanceId,
      point: new Vector3(...hit.point),
      normal: new Vector3(...hit.normal),
      distance,
      triangle: firstTriangle + hit.triangle,
    };
  }

  /**
   * Which instances of an InstancedMesh its arrays hold at the front, in their order.
   * @param {import('three').InstancedMesh} mesh
   * @returns {Uint32Array}
   */
  instanceIds(mesh) {
    return this.#holders.instanceIds(mesh);
  }

  /** Shows all again, and frees what the module holds. */
  dispose() {
    this.#holders.clear();
    for (const object of [this.#culler, this.#view, this.#raster, this.#pyramid, this.#scene]) object?.dispose();
    this.#culler = this.#view = this.#raster = this.#pyramid = this.#scene = null;
    this.#stale = true;
  }

  #rebuild() {
    this.#culler?.dispose();
    this.#scene?.dispose();
    this.#scene = null;
    this.#holders.number();
    this.#culler = this.#sightline.createBoxCuller(this.#holders.boxes());
    this.#stale = false;
  }
  /**
   * @param {import('./culling.js').View} view
   * @param {Camera} camera
   */
  #occlude(view, camera) {
    this.#raster ??= this.#sightline.createOccluderRaster();
    this.#pyramid ??= this.#sightline.createDepthPyramid();
    this.#raster.begin(view);
    for (const occluder of this.#occluders.values()) occluder.draw(this.#raster, camera);
    return this.#raster.build(this.#pyramid);
  }
}
