// The tracer's twin: loops over all items and triangles, gpuprims' intersectors for solids, Moeller and Trumbore in
// double for triangles.
#pragma once

#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::raytrace {

/// A crossing that brute force finds. `error`: in t. A doubtful one lies so near an edge of its triangle, or of the
/// ray's part, that either answer is right.
struct Crossing {
  core::Slot slot;
  double t, error;
  bool sure;
};

/// All crossings that the ray's part may hold.
std::vector<Crossing> brute_force(const core::Snapshot& snapshot, const core::Ray& ray, const RayFilter& filter);

}  // namespace sightline::raytrace
