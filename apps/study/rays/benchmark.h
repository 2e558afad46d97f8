// All traversals on the rays of an image: times, visits, and how rays share out among lanes and devices.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sightline/apps/study/rays/traversals.h"
#include "sightline/core/error.h"

namespace sightline::study::rays {

struct Image {
  int width = 1408, height = 768;
};

/// Kinds of rays: from the eye; mirrored where those hit, with a mirror's coherence; and from there to a light, where
/// any hit counts.
enum class RayKind : std::uint8_t { kPrimary, kReflected, kShadow };
inline constexpr std::size_t kRayKinds = 3;
const char* name_of(RayKind kind);

/// A traversal in GLSL on the same rays: time a ray as seconds_on_gpu() has it (gpu/benchmark.h), least of the passes.
struct GpuRun {
  /// Primary rays, in groups of 32 x 1 pixels, of 8 x 4, and of 8 x 4 by persistent groups; reflected and shadow rays
  /// in groups of 32 as they come.
  double rows_ns = 0.0, tiles_ns = 0.0, persistent_ns = 0.0, reflected_ns = 0.0, shadow_ns = 0.0;
  std::size_t disagreements = 0;  ///< answers to primary rays that differ from the CPU's
};

struct TraversalRun {
  const Traversal* traversal = nullptr;
  std::array<double, kRayKinds> ns{};   ///< processor time a ray, least of the passes
  double nodes = 0.0, triangles = 0.0;  ///< a primary ray, mean
  /// Share of lanes at work when 32 neighbouring primary rays go in step, one node visit a step, as a warp's threads
  /// do. Groups are 32 x 1 (rows) or 8 x 4 pixels (tiles).
  double lanes_rows = 0.0, lanes_tiles = 0.0;
  /// Mean load of four devices over the largest, in node visits of primary rays: the image is dealt out by rows or by
  /// tiles of 32 x 32 pixels.
  double balance_rows = 0.0, balance_tiles = 0.0;
  std::size_t disagreements = 0;  ///< primary rays whose hit differs from the first traversal's
  std::optional<GpuRun> gpu;
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

/// The rays that a benchmark searched for.
struct BenchmarkRays {
  Image image;
  std::array<std::vector<Ray>, kRayKinds> rays;  ///< by RayKind; primary ones row by row
  std::vector<Hit> hits;                         ///< of the primary rays
};

/// From an eye outside that looks at the middle of the triangles, row by row.
std::vector<Ray> primary_rays(const UnitSpace& space, const Image& image);
/// A point above the triangles, `turned` by an angle (radians) about their upright axis.
core::dvec3 light_over(const UnitSpace& space, double turned = 0.0);
/// To the light from where `rays` hit.
std::vector<Ray> shadow_rays(const TriangleSet& triangles, const std::vector<Ray>& rays, const std::vector<Hit>& hits,
                             const core::dvec3& light);

/// Share of lanes at work, when each group of width x height rays takes as long as its slowest. `visits`: of nodes, by
/// primary ray.
double lanes_at_work(const std::vector<std::uint32_t>& visits, const Image& image, int width, int height);

/// May add to a result what it finds out about the same rays. Its error ends the benchmark.
using BenchmarkHook = std::function<core::Expected<void>(const Structures&, const BenchmarkRays&, Benchmark&)>;

/// Traversals take turns, `passes` times (>= 1) each; `step` is told what comes next. `then`, where given, is called at
/// the end.
core::Expected<Benchmark> run_benchmark(const std::string& model, const TriangleSet& triangles, const Image& image,
                                        int passes, const std::function<void(const std::string&)>& step,
                                        const BenchmarkHook& then = {});

}  // namespace sightline::study::rays
