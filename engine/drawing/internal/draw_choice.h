// Chooses which triangles of a visible set's meshes are drawn, and sets the draw lists. Internal to engine.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sightline/core/view.h"
#include "sightline/culling/occlusion/internal/triangle_stream.h"
#include "sightline/engine/drawing/internal/cluster_passes.h"
#include "sightline/gpuscene/internal/draw_lists.h"
#include "sightline/lod/internal/cut.h"

namespace sightline::engine {

/// What is drawn of items with meshes.
struct MeshCounts {
  std::int64_t items = 0, coarser = 0;             ///< coarser: by fewer triangles than their own
  std::int64_t triangles = 0, full_triangles = 0;  ///< in the detail drawn, whether they show or not; of the same items
  double error = 0.0;                              ///< pixels, the largest: as lod::CutChooser::error() has it

  MeshCounts& operator+=(const MeshCounts& more) {
    items += more.items;
    coarser += more.coarser;
    triangles += more.triangles;
    full_triangles += more.full_triangles;
    error = std::max(error, more.error);
    return *this;
  }
};

/// By which an image draws meshes. Everything is of the same view, and borrowed.
struct MeshRules {
  const core::View& view;
  const lod::ImageError* error = nullptr;            ///< meshes that have levels are drawn by a cut of them
  ClusterPasses* clusters = nullptr;                 ///< leaves out clusters of such cuts
  const culling::TriangleTest* triangles = nullptr;  ///< only triangles are drawn that may colour the image
  core::ThreadPool* threads = nullptr;               ///< share in that test, and in the lists of records
  /// Draws the lists. DrawChoice::update() calls it with those of all but the meshes, and leaves these alone in the
  /// lists, where it will choose among many: so a GPU draws meanwhile. Meshes come last in any case.
  std::function<core::Expected<void>()> draw_others = {};
};

/// Keeps its memory from image to image.
class DrawChoice {
 public:
  using MeshOf = std::function<gpuscene::DrawnMesh(core::Slot)>;

  /// Sets the lists for a visible set of `snapshot`, which `scene` was made from. Fails as DrawLists::update() does.
  core::Expected<void> update(gpuscene::DrawLists& lists, const gpuscene::GpuScene& scene,
                              const core::Snapshot& snapshot, const core::VisibleSet& visible, const MeshRules& rules);
  /// The part of that which needs no GL: what draws the items with meshes. Valid until the next call, and the same for
  /// any number of threads. Any of them may call `mesh_of`.
  gpuscene::MeshDraws choose(const core::Snapshot& snapshot, std::span<const core::Slot> meshes, const MeshOf& mesh_of,
                             const MeshRules& rules);
  /// Counts of the last call of either.
  const MeshCounts& counts() const { return counts_; }

 private:
  struct Item {
    core::Slot slot;
    std::uint32_t place;  // among the meshes
    gpuscene::DrawnMesh mesh;
  };
  /// Some meshes in a row, as they are drawn.
  struct alignas(64) Some {  // a cache line of its own: threads write neighbours at once
    std::vector<gpuscene::ElementsCommand> fronts, both_faces;
    std::vector<culling::TriangleStream::Part> picked;  // tags: places among the meshes
    std::vector<std::uint32_t> large;                   // places of meshes that are left to all threads
    MeshCounts counts;
    void clear();
  };
  class OfMesh;
  core::Expected<void> draw_others(gpuscene::DrawLists& lists, const gpuscene::GpuScene& scene, const MeshRules& rules);
  void pick_triangles(const core::Snapshot& snapshot, std::span<const core::Slot> meshes, const MeshOf& mesh_of,
                      const MeshRules& rules);
  gpuscene::MeshDraws join(bool picked);

  gpuscene::VisibleRecords records_;
  std::vector<Some> some_;  // by job; then of large meshes and picked triangles
  culling::TriangleStream picked_;
  std::vector<std::span<const gpuscene::ElementsCommand>> fronts_, both_faces_;
  std::vector<std::span<const std::uint32_t>> picked_runs_;
  MeshCounts counts_;
};

}  // namespace sightline::engine
