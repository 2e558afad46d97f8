// A scene that need not fit into memory: what is always there, and pages of items that are read when a view needs them.
//
// A leaf is 32 slots of a snapshot, a page is a run of leaves. Boxes of all leaves stay in memory, less than a byte an
// item, and culling starts from them. A page holds what a snapshot holds, for its slots alone, to the bit: so what is
// drawn from pages is what the whole would show.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"

namespace sightline::core {

/// How far a surface may lie from another one that it stands for: each point of one has a point of the other within so
/// many metres, as far as their triangles lie in the box. Both in the mesh's own coordinates.
struct MeshDeviation {
  Aabb box;
  float error = 0.0f;
};

/// Items of a page. Stays at its address.
struct SIGHTLINE_API Page {
  Page() = default;
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  Scene meshes;  ///< those that the items use, and nothing else
  /// Slot s of the page is slot 32 * first_leaf + s of all leaves. Items have ids that are unique among all pages, but
  /// slot() knows none of them.
  Snapshot snapshot{meshes};
  /// Ends hidden at joints (gpuprims/internal/joints.h): two bits per slot.
  std::vector<std::uint64_t> internal_end_caps;

  /// Deviations of a page of PagedScene::coarse, of all meshes one after the other, and for each mesh where its own
  /// end. A mesh without is the one that it stands for.
  std::vector<MeshDeviation> deviations;
  std::vector<std::uint32_t> deviation_ends;
  std::span<const MeshDeviation> deviations_of(std::uint32_t mesh) const;

  /// Gives back what only uploading needs: placements and parameters of primitives.
  void drop_records();
};

/// Where pages come from. Whoever fills it in keeps leaves, colours and pages in step.
struct PagedScene {
  struct PageInfo {
    std::uint32_t first_leaf = 0;
    std::uint32_t slot_count = 0;                        ///< of 32 each a leaf; the last leaf may have fewer
    std::uint32_t material_rows = 0;                     ///< of the table that its items name
    std::array<std::uint32_t, kKindCount> of_kind{};     ///< slots of each kind
    std::uint64_t mesh_positions = 0, mesh_indices = 0;  ///< of all its meshes
    std::uint64_t level_indices = 0;                     ///< of levels of detail that these come with
    std::size_t memory_bytes = 0;                        ///< of a Page, before drop_records()
  };

  ItemBounds leaves;                   ///< a box for each leaf; empty where a leaf shows nothing
  std::vector<std::uint32_t> colours;  ///< of leaves: mean sRGB, red lowest; kHasLines
  static constexpr std::uint32_t kHasLines = 1u << 24;
  std::vector<PageInfo> pages;  ///< in the order of their leaves
  FittedBounds fitted;          ///< of all items
  std::uint64_t items = 0;
  /// Reads a page, verified; `page` must be one of pages. Any thread may call it, several at once. Fails where the file
  /// cannot be read, is damaged, or the page does not fit into memory.
  std::function<Expected<std::unique_ptr<Page>>(std::uint32_t page)> load;
  /// Coarse forms of the same pages, with the coarsest level of detail of each mesh. Pages that this does not halve
  /// have no slots. Only `pages` and `load` are of use. Null: there are none.
  std::shared_ptr<const PagedScene> coarse;

  std::uint32_t leaf_end(std::uint32_t page) const {
    return pages[page].first_leaf + (pages[page].slot_count + kBlockSlots - 1) / kBlockSlots;
  }
  /// Bytes of what is always in memory.
  std::size_t memory_bytes() const {
    return leaves.memory_bytes() + colours.capacity() * sizeof(colours[0]) + pages.capacity() * sizeof(PageInfo) +
           (coarse ? coarse->memory_bytes() : 0);
  }
};

}  // namespace sightline::core
