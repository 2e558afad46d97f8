// What C++ and shaders of culling/gpu must agree on, in the language that both speak: gpu_bounds.h includes this file.

const int kMaxPlanes = 14;            // kMaxCullPlanes
const uint kItemsPerCluster = 64u;    // consecutive records
const uint kClustersPerBlock = 32u;   // what a work group of the compute form takes at a time
const uint kRejected = 0xffffffffu;   // in place of the number of what is culled
const uint kInside = 0x80000000u;     // set in the number of a cluster that no plane cuts
