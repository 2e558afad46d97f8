// Constants that C++ and the shaders of culling/gpu share, valid in both languages: gpu_bounds.h includes this file.

const int kMaxPlanes = 14;            // kMaxCullPlanes
const int kMaxSections = 8;           // core::kMaxSectionPlanes
const uint kItemsPerCluster = 64u;    // consecutive records
const uint kClustersPerBlock = 32u;   // that a work group of the compute variant handles at a time
const int kMaxSamples = 32;           // of a pixel
const int kMaxLevels = 16;            // of a depth pyramid
const uint kPyramidGroup = 8u;        // a work group makes so many blocks of it along each axis
const uint kRejected = 0xffffffffu;   // in place of the index of what is culled
const uint kInsideBit = 0x80000000u;  // set in the index of a cluster that no plane cuts
const uint kPartClusterTexels = 36u;  // of kItemsPerCluster parts of meshes
const float kVertexRounding = 4e-6f;  // of what a GPU draws, relative to the sizes of what enters a coordinate
