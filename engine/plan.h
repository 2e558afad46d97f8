// Decides from the content of a scene which features it needs. All others cost no memory, no shader compile and no
// frame time.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/snapshot.h"
#include "sightline/culling/gpu/gpu_culler_config.h"

namespace sightline::engine {

/// A part of a scene: of `count` parts that hold about the same number of items, each of items that lie near one
/// another, and that together are the scene. Parts are the same in all processes that have read the same scene.
struct ScenePart {
  int index = 0, count = 1;  ///< 0 ≤ index < count

  bool operator==(const ScenePart&) const = default;
};

/// The culler that an application requests.
enum class CullerChoice : std::uint8_t {
  kAutomatic,  ///< linear for small scenes, the hierarchy for all others
  kLinear,     ///< test every box
  kCpu,        ///< CPU hierarchy
  kGpu,        ///< culls on the GPU, and the result stays there; needs GL
  kHybrid,     ///< kCpu or kGpu, whichever costs the frame less by measured times; needs GL
};

constexpr std::string_view name_of(CullerChoice choice) {
  constexpr std::string_view kNames[] = {"auto", "linear", "cpu", "gpu", "hybrid"};
  return kNames[std::size_t(choice)];
}

/// "1 item", "7 items".
inline std::string count_text(std::size_t items) {
  return std::to_string(items) + (items == 1 ? " item" : " items");
}

enum class OcclusionChoice : std::uint8_t {
  kOff,
  kOn,
  kAutomatic,  ///< on while it pays
};
constexpr std::string_view name_of(OcclusionChoice choice) {
  return choice == OcclusionChoice::kOff ? "off" : choice == OcclusionChoice::kOn ? "on" : "auto";
}

/// How transparent items are drawn.
enum class Transparency : std::uint8_t {
  kDither,  ///< by a pattern of opaque pixels: exact on average over 4 x 4 pixels, and ids and depth show the items
  /// Blended without sorting, with an error (docs/guide/transparency.md). Ids and depth are those of what lies behind.
  kBlended,
};
constexpr std::string_view name_of(Transparency mode) {
  return mode == Transparency::kDither ? "dither" : "blended";
}

/// How items below EngineConfig::losses.min_projected_area are drawn.
enum class ContributionMode : std::uint8_t {
  kDrop,    ///< not at all
  kPoints,  ///< each as one splat of the area that it has on average over all directions
  /// R. Cook, J. Halstead, M. Planck, D. Ryu, "Stochastic simplification of aggregate detail", 2007: a share of them,
  /// each as one splat that is as much larger. An item is in the share or not by its id, so none flickers.
  kStochastic,
};
constexpr std::string_view name_of(ContributionMode mode) {
  return mode == ContributionMode::kDrop ? "drop" : mode == ContributionMode::kPoints ? "points" : "stochastic";
}

struct PlanEntry {
  std::string feature;
  bool used = false;
  std::string why;
};

struct Plan {
  CullerChoice culler = CullerChoice::kLinear;  ///< never kAutomatic
  std::vector<PlanEntry> entries;               ///< every feature the build knows, used or left out, with the reason

  bool has_tree() const { return culler == CullerChoice::kCpu || culler == CullerChoice::kHybrid; }
  bool gpu_culls() const { return culler == CullerChoice::kGpu || culler == CullerChoice::kHybrid; }
};

/// Below this many items, testing all boxes costs less than traversing the hierarchy.
inline constexpr std::size_t kSmallScene = 128;
/// Below this many items, the CPU culls in a microsecond or two and a GPU culler can gain nothing: none is made.
inline constexpr std::size_t kSmallHybridScene = 10'000;
/// Below this many items that may cover a sample, occlusion is not tested unless asked for. Above, measured times
/// decide (OcclusionTrial). Clusters of large meshes are tested, too, but do not count: frames that test them wait for
/// their own depth, which takes more time than the triangles of hidden clusters, most of which cover no sample and are
/// left out anyway (docs/results/levels-of-detail.md). They pay only near a mesh of millions of triangles that hides
/// most of itself, and no part of a frame foretells that as well as a part of the items does.
inline constexpr std::size_t kSmallOcclusionScene = 16'384;
/// Below so many items in a scene that a GPU culls and draws, the occlusion test is off: nothing is measured there. An
/// H200 takes 1.73 ms a frame without the test and 1.79 with it at 100,000 items, 8.2 and 5.9 at a million
/// (docs/results/gpu.md).
inline constexpr std::size_t kGpuOcclusionScene = 100'000;

/// Adds an entry, or replaces the one of the same feature.
SIGHTLINE_API void set_entry(Plan& plan, PlanEntry entry);
/// Adds the variant of the GPU culler, which is known only once there is one.
SIGHTLINE_API void add_gpu_variant(Plan& plan, culling::GpuVariant variant, const std::string& why);
/// Adds which context is used, which is known only once there is one: gl::Context::platform() of the engine's own.
SIGHTLINE_API void add_context(Plan& plan, bool own, const std::string& platform);

SIGHTLINE_API Plan make_plan(const core::Snapshot& snapshot, CullerChoice choice, bool draw, bool ids);

}  // namespace sightline::engine
