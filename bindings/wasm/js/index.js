// "sightline": culling, and scenes of plants with what a ray hits.
export { BoxCuller, DepthPyramid, OccluderRaster, View } from './culling.js';
export { hasSimd, hasThreads } from './instance.js';
export { Culling, load, Sightline } from './load.js';
export { NativeArray, SightlineError } from './objects.js';
export { Scene } from './scene.js';
