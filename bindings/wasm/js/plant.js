// A scene of the library as an object of three.js: its primitives are ray-cast, its meshes instanced, and what the
// camera does not show is left out.

import {
  BufferAttribute,
  BufferGeometry,
  Group,
  InstancedBufferAttribute,
  InstancedMesh,
  Matrix3,
  Matrix4,
  Vector3,
} from 'three';

import { followCamera, plantMaterial } from './plant_material.js';
import { AnalyticPrimitives } from './primitives.js';
import { cameraOf } from './three_camera.js';
import { Instances } from './three_holders.js';

const matrix = new Matrix4();
const origin = new Vector3();
const direction = new Vector3();
const linear = new Matrix3();

/**
 * @typedef {import('./three_camera.js').CullerOptions & { occlusion?: boolean }} PlantOptions occlusion: whether items
 *     are left out that the plant's own solids hide; true unless told
 */

/**
 * Shows a scene, whose coordinates are the object's own: metres with z up. (Rotate it by -90° about x where y is up.)
 * The scene must be committed, and stays the caller's; after another commit() make another Plant. Lit from the eye and
 * from camera.up, not by lights. Lines of a plant are not drawn.
 */
export class Plant extends Group {
  #sightline;
  #scene;
  /** @type {import('./culling.js').View | null} */ #view = null;
  #pyramid;
  /** @type {AnalyticPrimitives} */ #primitives;
  #materials = [plantMaterial(false), plantMaterial(true)];
  /** @type {Instances[]} */ #meshes = [];
  #holderOf = new Int32Array(0); // by item
  #placeOf = new Int32Array(0);

  /**
   * May be changed from frame to frame.
   * @type {Required<PlantOptions>}
   */
  options;

  /**
   * Half-spaces of the world that are kept, as Material.clippingPlanes, at most eight together with the renderer's own;
   * null for none. Meshes are cut where the renderer's `localClippingEnabled` is set.
   * @type {import('three').Plane[] | null}
   */
  clippingPlanes = null;
  /** As Material.clipIntersection: what any of the planes keeps is drawn. */
  clipIntersection = false;

  /** How the last update() went. */
  stats = { items: 0, visible: 0, milliseconds: 0 };

  /**
   * @param {import('./load.js').Sightline} sightline
   * @param {import('./scene.js').Scene} scene
   * @param {PlantOptions} [options]
   */
  constructor(sightline, scene, options = {}) {
    super();
    this.#sightline = sightline;
    this.#scene = scene;
    this.options = { occlusion: true, leastArea: 0, occlusionWidth: 0, ...options };
    this.#pyramid = sightline.createDepthPyramid();
    this.#primitives = new AnalyticPrimitives(scene.packed());
    this.add(this.#primitives);
    this.stats.items = scene.itemNodes().length;
    this.#addMeshes();
  }

  #addMeshes() {
    this.#holderOf = new Int32Array(this.stats.items).fill(-1);
    this.#placeOf = new Int32Array(this.stats.items);
    /** @type {Map<number, import('./scene.js').MeshInstance[]>} */ const byMesh = new Map();
    for (const instance of this.#scene.instances()) {
      const list = byMesh.get(instance.mesh);
      if (list) list.push(instance);
      else byMesh.set(instance.mesh, [instance]);
    }
    for (const [mesh, instances] of byMesh) this.#addMesh(mesh, instances);
  }
  /**
   * Matrices are floats, so they are relative to the first instance's place.
   * @param {number} mesh
   * @param {import('./scene.js').MeshInstance[]} instances
   */
  #addMesh(mesh, instances) {
    const { positions, normals, indices } = this.#scene.mesh(mesh);
    if (indices.length === 0) return;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(positions, 3));
    if (normals.length > 0) geometry.setAttribute('normal', new BufferAttribute(normals, 3));
    geometry.setIndex(new BufferAttribute(indices, 1));
    const colours = new InstancedBufferAttribute(new Float32Array(4 * instances.length), 4);
    const patterns = new InstancedBufferAttribute(new Float32Array(instances.length), 1);
    geometry.setAttribute('colour', colours);
    geometry.setAttribute('pattern', patterns);
    const object = new InstancedMesh(geometry, this.#materials[normals.length > 0 ? 0 : 1], instances.length);
    object.onBeforeRender = followCamera;
    object.position.fromArray(instances[0].matrix, 12);
    instances.forEach((instance, i) => {
      matrix.fromArray(instance.matrix);
      for (let axis = 0; axis < 3; ++axis) matrix.elements[12 + axis] -= object.position.getComponent(axis);
      object.setMatrixAt(i, matrix);
      colours.array.set(instance.colour, 4 * i);
      patterns.array[i] = instance.item % 4;
      this.#holderOf[instance.item] = this.#meshes.length;
      this.#placeOf[instance.item] = i;
    });
    this.#meshes.push(new Instances(object));
    this.add(object);
  }

  /**
   * Shows what the camera shows, and no more.
   * @param {import('three').Camera} camera
   * @param {import('./three_camera.js').Renderer} renderer
   */
  update(camera, renderer) {
    const start = performance.now();
    const { occlusion, leastArea, occlusionWidth } = this.options;
    this.updateWorldMatrix(true, false);
    if (!camera.parent) camera.updateMatrixWorld();
    for (const cut of [this.#primitives, ...this.#materials]) {
      cut.clippingPlanes = this.clippingPlanes;
      cut.clipIntersection = this.clipIntersection;
    }
    const seen = cameraOf(camera, renderer, occlusion ? occlusionWidth : 0, this);
    const view = (this.#view = this.#view ? this.#view.set(seen) : this.#sightline.createView(seen));
    const behind = occlusion ? this.#scene.occlude(view, this.#pyramid) : undefined;
    const visible = this.#scene.visible(view, { behind, leastArea: leastArea * seen.pixels });
    this.#primitives.setVisible(visible);
    for (const mesh of this.#meshes) mesh.hide();
    for (let i = 0; i < visible.length; ++i) {
      const holder = this.#holderOf[visible[i]];
      if (holder >= 0) this.#meshes[holder].show(this.#placeOf[visible[i]]);
    }
    for (const mesh of this.#meshes) mesh.finish();
    this.stats.visible = visible.length;
    this.stats.milliseconds = performance.now() - start;
  }

  /** Shows all until the next update(). */
  showAll() {
    this.#primitives.showAll();
    for (const mesh of this.#meshes) mesh.showAll();
  }

  /**
   * The first surface that a ray hits, of all items: exact on primitives, watertight on meshes. What the clipping planes
   * of the last update() cut off is not hit. In world coordinates.
   * @param {{ origin: Vector3, direction: Vector3 }} ray such as Raycaster.ray
   * @returns {(import('./scene.js').Hit & { worldPoint: Vector3, worldNormal: Vector3 }) | null}
   */
  pick(ray) {
    this.updateWorldMatrix(true, false);
    matrix.copy(this.matrixWorld).invert();
    origin.copy(ray.origin).applyMatrix4(matrix);
    direction.copy(ray.direction).applyMatrix3(linear.setFromMatrix4(matrix));
    const hit = this.#scene.pick(origin.toArray(), direction.toArray(), { view: this.#view ?? undefined });
    if (!hit) return null;
    const worldPoint = new Vector3(...hit.point).applyMatrix4(this.matrixWorld);
    const worldNormal = new Vector3(...hit.normal).applyNormalMatrix(linear.getNormalMatrix(this.matrixWorld));
    return { ...hit, worldPoint, worldNormal };
  }

  /** Frees what this object made: not the scene. */
  dispose() {
    this.#primitives.dispose();
    for (const { object } of this.#meshes) {
      object.geometry.dispose();
      object.dispose();
    }
    for (const material of this.#materials) material.dispose();
    this.#pyramid.dispose();
    this.#view?.dispose();
  }
}
