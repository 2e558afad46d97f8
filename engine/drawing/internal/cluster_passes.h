// Which clusters of large meshes a pass of a frame draws. Internal to engine.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "sightline/core/item_bounds.h"
#include "sightline/core/thread_pool.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/lod/internal/cut.h"

namespace sightline::engine {

/// What OcclusionPasses does with items, done with the clusters of items that have many: first what the frame before
/// has found open, then, in later passes, what the depth of the passes before does not hide. So nothing pops.
class ClusterPasses {
 public:
  /// Begins a frame. `test`: against the depth of all passes so far; borrowed until the frame is remembered.
  void begin(const culling::OcclusionTest& test, const core::dvec3& origin, core::ThreadPool& threads);
  /// Leaves out clusters of an item that the present pass does not draw. `clusters` rise. Returns whether these are the
  /// first that are drawn of the item in this frame. Threads may call it at once for different items.
  bool filter(core::Slot slot, const lod::MeshLevels& levels, const core::Affine& world_from_mesh,
              std::vector<std::uint32_t>& clusters);
  /// Ends the first pass. Returns the items of which clusters were left out, which later passes must draw again, in
  /// rising order.
  const std::vector<core::Slot>& begin_later_passes();
  /// Ends the frame: what the next one draws first is what was drawn and what the depth of all passes does not hide.
  void remember();

  /// Forgets the frame before.
  void reset() { items_.clear(); }

 private:
  struct Item {
    const lod::MeshLevels* levels;
    core::Affine world_from_mesh;
    std::vector<std::uint64_t> open, drawn;  // a bit per cluster: of the frame before, and of this one
    std::uint64_t frame = 0;                 // that last considered it
  };
  Item* find(core::Slot slot, std::size_t clusters);
  void leave_out_hidden(const Item& item, std::vector<std::uint32_t>& clusters) const;

  const culling::OcclusionTest* test_ = nullptr;
  core::ThreadPool* threads_ = nullptr;
  // Guards the map, not its items, and again_.
  std::unique_ptr<std::mutex> mutex_ = std::make_unique<std::mutex>();
  std::unordered_map<core::Slot, Item> items_;
  std::vector<core::Slot> again_;
  std::uint64_t frame_ = 0;
  bool first_ = false;  // pass
  core::dvec3 origin_{0.0};
  std::vector<std::uint32_t> kept_;
};

}  // namespace sightline::engine
