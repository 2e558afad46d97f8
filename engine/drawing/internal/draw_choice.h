// Chooses which triangles of a visible set's meshes are drawn, and sets the draw lists. Internal to engine.
#pragma once

#include <algorithm>
#include <cstdint>
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
};

/// Keeps its memory from image to image.
class DrawChoice {
 public:
  /// Sets the lists for a visible set of `snapshot`, which `scene` was made from. Fails as DrawLists::update() does.
  core::Expected<void> update(gpuscene::DrawLists& lists, const gpuscene::GpuScene& scene,
                              const core::Snapshot& snapshot, const core::VisibleSet& visible, const MeshRules& rules);
  /// Counts of the last update().
  const MeshCounts& counts() const { return counts_; }

 private:
  /// An item's mesh: the command that draws it from its first index on, and its indices, if these are to be tested.
  struct ItemMesh {
    core::Slot slot;
    gpuscene::ElementsCommand whole;
    std::span<const std::uint32_t> indices;
  };
  void choose(const core::Snapshot& snapshot, const gpuscene::MeshPool& pool, const MeshRules& rules);
  void choose_mesh(const core::Snapshot& snapshot, ItemMesh mesh, const lod::MeshLevels* levels, std::uint32_t solid,
                   const MeshRules& rules);
  bool choose_cut(const core::Snapshot& snapshot, core::Slot slot, const lod::MeshLevels& levels,
                  const MeshRules& rules);
  void count(std::uint32_t own_indices, double error, bool first);
  void add_triangles(const ItemMesh& mesh, std::uint32_t first, std::uint32_t end, bool fronts_alone);

  gpuscene::VisibleRecords records_;
  lod::CutChooser cuts_;
  std::vector<lod::IndexRange> ranges_;
  std::vector<gpuscene::ElementsCommand> fronts_, both_faces_;
  culling::TriangleStream picked_;
  std::vector<gpuscene::ElementsCommand> of_picked_;  // by tag: what draws the whole mesh
  std::vector<std::span<const std::uint32_t>> picked_runs_;
  MeshCounts counts_;
};

}  // namespace sightline::engine
