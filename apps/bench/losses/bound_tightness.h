// How far the proven errors of levels of detail lie above the errors that samples find. Internal to sightline-bench
// contribution and lod.
#pragma once

#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/core/visible_set.h"
#include "sightline/gpuscene/internal/mesh_pool.h"
#include "sightline/lod/internal/cut.h"

namespace sightline::bench {

/// For some of the groups of triangles (lod/mesh_levels.h) that an image shows simplified, evenly
/// chosen among all of `visible`: the proven error over the largest distance of samples of them from the original
/// surface.
std::vector<double> bound_tightness(const lod::ImageError& image, const core::Snapshot& snapshot,
                                    const core::VisibleSet& visible, const gpuscene::MeshPool& meshes);

}  // namespace sightline::bench
