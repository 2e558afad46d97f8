// The ray tracer against the reference in 113 bits: random scenes of extreme solids and meshes, at up to 1e7 m from the
// origin, and random rays at them. Every crossing of every ray is judged, and the nearest.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sightline/core/primitive.h"

namespace sightline::bench {

/// Counts of rays. An answer is right within raytrace::kSolidError and kMeshError, as raytrace/tracer.h defines them.
/// Where the bounds of two answers overlap either is right, and such rays are counted:
struct TracedCounts {
  std::int64_t rays = 0, scenes = 0;
  std::int64_t hits = 0;       ///< rays with a nearest hit
  std::int64_t crossings = 0;  ///< of whole lines with all items
  std::int64_t ties = 0;       ///< another item is nearest, but both are nearer to one another than their bounds
  std::int64_t grazes = 0;     ///< a crossing is there or not: its edge or tangent plane is nearer than the bound
  std::int64_t wrong = 0;      ///< rays with any wrong answer
  double worst = 0.0;          ///< largest error of t as a part of its bound, grazes left out
  std::vector<std::string> examples;  ///< of wrong answers, at most ten

  bool ok() const { return wrong == 0; }
  void add(const TracedCounts& other);
};

/// What scenes are made of: one kind of solid, Kind::kMesh for meshes, or everything mixed.
using TracedKind = std::optional<core::Kind>;

/// Traces `rays` rays, a thousand in each scene. The same seed gives the same scenes and rays.
TracedCounts trace_rays(TracedKind kind, std::int64_t rays, std::uint64_t seed);

}  // namespace sightline::bench
