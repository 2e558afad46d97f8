// "sightline/culling": boxes, occluders and questions about boxes alone, in a third of the bytes.
export { BoxCuller, DepthPyramid, OccluderRaster, View } from './culling.js';
export { hasSimd, hasThreads } from './instance.js';
export { Culling, loadCulling as load } from './load.js';
export { NativeArray, SightlineError } from './objects.js';
