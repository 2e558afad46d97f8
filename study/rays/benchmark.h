// All traversals on the rays of a picture: times, visits, and how rays share out among lanes and devices.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sightline/study/rays/traversals.h"

namespace sightline::study::rays {

struct Picture {
  int width = 1408, height = 768;
};

/// Kinds of rays: from the eye; mirrored where those hit, with a mirror's coherence; and from there to a light, where
/// any hit counts.
enum class RayKind : std::uint8_t { kPrimary, kReflected, kShadow };
inline constexpr std::size_t kRayKinds = 3;
const char* name_of(RayKind kind);

struct TraversalRun {
  const Traversal* traversal = nullptr;
  std::array<double, kRayKinds> ns{};   ///< processor time a ray, least of the passes
  double nodes = 0.0, triangles = 0.0;  ///< a primary ray, mean
  /// Share of lanes at work when 32 neighbouring primary rays go in step, one node visit a step, as a warp's threads
  /// do. Groups are 32 x 1 (rows) or 8 x 4 pixels (tiles).
  double lanes_rows = 0.0, lanes_tiles = 0.0;
  /// Mean load of four devices over the largest, in node visits of primary rays: the picture is dealt out by rows or by
  /// tiles of 32 x 32 pixels.
  double balance_rows = 0.0, balance_tiles = 0.0;
  std::size_t disagreements = 0;  ///< primary rays whose hit differs from the first traversal's
};

struct StructureRun {
  Structure structure{};
  std::size_t bytes = 0;
  double build_seconds = 0.0;
};

struct Benchmark {
  std::string model;
  std::size_t triangles = 0;
  std::array<std::size_t, kRayKinds> rays{};
  double hits = 0.0;            ///< share of the primary rays
  double brute_force_ns = 0.0;  ///< a primary ray, of a few
  std::vector<TraversalRun> traversals;
  std::vector<StructureRun> structures;

  const TraversalRun* find(const std::string& traversal) const;
};

/// The eye looks at the middle of the triangles from outside. Traversals take turns, `passes` times (>= 1) each; `step`
/// is told what comes next.
Benchmark run_benchmark(const std::string& model, const TriangleSet& triangles, const Picture& picture, int passes,
                        const std::function<void(const std::string&)>& step);

}  // namespace sightline::study::rays
