// Cameras and images of three.js, as the library takes them.

import { Matrix4, Plane, Vector2, WebGPUCoordinateSystem } from 'three';

const matrix = new Matrix4();
const size = new Vector2();

/**
 * @typedef {object} Renderer
 * @property {(size: Vector2) => Vector2} getDrawingBufferSize
 * @property {Plane[]} [clippingPlanes]
 * @property {{ enabled: boolean }} [shadowMap] without one, shadows count as drawn
 */

/**
 * An object whose coordinates are the library's, and the half-spaces of the world that it is cut by.
 * @typedef {{ matrixWorld: Matrix4, clippingPlanes: Plane[] | null, clipIntersection: boolean }} Model
 */

/**
 * What may be left out beside what lies beyond the view volume.
 * @typedef {object} CullerOptions
 * @property {number} [leastArea] pixels that something must be expected to cover to be drawn; 0, as unless told, draws
 *     all. Approximate: it may leave out what would be seen.
 * @property {number} [occlusionWidth] of the image that occluders are drawn into, in pixels. Unless told it is the
 *     renderer's, and nothing is left out that would colour a pixel's centre. A smaller image costs less and is
 *     approximate: what shows between its pixel centres alone may be left out.
 */

/** Section planes that the library and its shaders take at most. */
export const MOST_SECTIONS = 8;

/**
 * Half-spaces of the world that an object is cut by, and whether they unite. three.js counts those of the renderer as
 * well, unless the object's unite. The first eight count.
 * @param {Renderer} renderer
 * @param {Pick<Model, 'clippingPlanes' | 'clipIntersection'>} [object]
 * @returns {{ planes: Plane[], unite: boolean }}
 */
export function clippingPlanesOf(renderer, object) {
  const own = object?.clippingPlanes ?? [];
  const unite = object?.clipIntersection === true && own.length > 0;
  return { planes: [...own, ...(unite ? [] : renderer.clippingPlanes ?? [])].slice(0, MOST_SECTIONS), unite };
}

/**
 * The renderer's section planes in the model's coordinates.
 * @param {Renderer} renderer
 * @param {Model} [model]
 */
function sectionsOf(renderer, model) {
  const { planes, unite } = clippingPlanesOf(renderer, model);
  const modelFromWorld = model ? new Matrix4().copy(model.matrixWorld).invert() : new Matrix4();
  const sections = planes.map((plane) => {
    const { normal, constant } = new Plane().copy(plane).applyMatrix4(modelFromWorld);
    return [normal.x, normal.y, normal.z, constant];
  });
  return { sections, anySection: unite };
}

/**
 * The camera and the size of an image for createView(). World matrices must be up to date.
 * @param {import('three').Camera} camera
 * @param {Renderer} renderer
 * @param {number} width of the image; 0: the renderer's own
 * @param {Model} [model]
 * @returns {Required<import('./culling.js').Camera> & { pixels: number }} pixels: of this image, for one of the renderer's
 */
export function cameraOf(camera, renderer, width, model) {
  matrix.copy(camera.matrixWorldInverse);
  if (model) matrix.multiply(model.matrixWorld);
  // three.js inverts matrices of four rows, which leaves rounding errors in the last one.
  for (const [i, value] of [0, 0, 0, 1].entries()) matrix.elements[4 * i + 3] = value;
  const zeroToOne = camera.coordinateSystem === WebGPUCoordinateSystem;
  const reversed = /** @type {any} */ (camera).reversedDepth === true;
  renderer.getDrawingBufferSize(size);
  const whole = [Math.max(1, size.x), Math.max(1, size.y)];
  const scale = width > 0 ? width / whole[0] : 1;
  const height = Math.max(1, Math.round(whole[1] * scale));
  return {
    view: matrix.elements,
    projection: camera.projectionMatrix.elements,
    depth: reversed ? 'reversed' : zeroToOne ? 'zeroToOne' : 'minusOneToOne',
    width: width > 0 ? width : whole[0],
    height,
    pixels: scale * scale,
    ...sectionsOf(renderer, model),
  };
}
