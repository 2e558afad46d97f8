// A mesh of three.js that hides what is behind it.

import { BackSide, DoubleSide, Matrix4, Vector4 } from 'three';

import { trianglesOf } from './three_holders.js';

/** @typedef {import('three').Object3D} Object3D */

const matrix = new Matrix4();
const eye = new Vector4();

/**
 * Which sides of its triangles a mesh draws; null where its materials differ in that, or are cut.
 * @param {any} mesh
 */
function sideOf(mesh) {
  const materials = [mesh.material].flat();
  const { side } = materials[0];
  return materials.every((one) => one.side === side && !one.clippingPlanes?.length) ? side : null;
}

/** @param {Object3D | null} object */
function isVisible(object) {
  for (let above = object; above; above = above.parent) if (!above.visible) return false;
  return true;
}

/**
 * Those triangles that show the eye their front, or their back.
 * @param {Float32Array} positions
 * @param {Uint32Array} indices
 * @param {Vector4} eye in the coordinates of the positions; w is 0 of a direction to it
 * @param {1 | -1} sign
 */
function facing(positions, indices, eye, sign) {
  const out = new Uint32Array(indices.length);
  let count = 0;
  for (let i = 0; i < indices.length; i += 3) {
    const a = 3 * indices[i];
    const b = 3 * indices[i + 1];
    const c = 3 * indices[i + 2];
    const [ax, ay, az] = [positions[a], positions[a + 1], positions[a + 2]];
    const [ux, uy, uz] = [positions[b] - ax, positions[b + 1] - ay, positions[b + 2] - az];
    const [vx, vy, vz] = [positions[c] - ax, positions[c + 1] - ay, positions[c + 2] - az];
    const towards =
      (uy * vz - uz * vy) * (eye.x - eye.w * ax) +
      (uz * vx - ux * vz) * (eye.y - eye.w * ay) +
      (ux * vy - uy * vx) * (eye.z - eye.w * az);
    if (!(sign * towards > 0)) continue;
    out.set([indices[i], indices[i + 1], indices[i + 2]], count);
    count += 3;
  }
  return out.subarray(0, count);
}

export class Occluder {
  /** @param {any} mesh whose triangles are copied */
  constructor(mesh) {
    if (!mesh.isMesh || mesh.isInstancedMesh || mesh.isBatchedMesh || mesh.isSkinnedMesh)
      throw new TypeError('addOccluder: expected a Mesh, and not an instanced, batched or skinned one');
    this.mesh = mesh;
    this.triangles = trianglesOf({ geometry: mesh.geometry, first: 0, count: Infinity });
  }

  /**
   * @param {import('./culling.js').OccluderRaster} raster
   * @param {any} camera
   */
  draw(raster, camera) {
    const side = sideOf(this.mesh);
    if (side === null || !isVisible(this.mesh)) return;
    const { positions } = this.triangles;
    let { indices } = this.triangles;
    if (side !== DoubleSide) {
      eye.set(0, 0, camera.isOrthographicCamera ? 1 : 0, camera.isOrthographicCamera ? 0 : 1);
      eye.applyMatrix4(camera.matrixWorld).applyMatrix4(matrix.copy(this.mesh.matrixWorld).invert());
      indices = facing(positions, indices, eye, side === BackSide ? -1 : 1);
    }
    if (indices.length > 0) raster.addMesh(positions, indices, this.mesh.matrixWorld.elements);
  }
}
