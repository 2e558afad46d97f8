// Internal: the inner loops of frustum culling, one form per instruction set, in a table of plain pointers. The files
// that define them are compiled for their instruction set. So they must not call inline functions of other headers: the
// linker might use their copy in code for every processor.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sightline/core/internal/instruction_set.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/frustum_test.h"
#include "sightline/culling/frustum/hierarchy.h"

namespace sightline::culling {

/// What both cullers test items against.
struct ItemTest {
  const float* coordinates[6];
  std::size_t item_count;       // of all items of the bounds
  const std::uint32_t* layers;  // null: not tested
  std::uint32_t view_layers;
  const FloatPlane* planes;
  int union_first, plane_count;
  const CullPlanes* exact;  // decides what the float form leaves open
  /// Returns the visible items of `open` (bit i: item first + i).
  unsigned (*resolve)(const ItemTest& test, std::size_t first, unsigned open, PlaneMask mask);
};

ItemTest make_item_test(const core::ItemBounds& bounds, const CullPlanes& planes, std::uint32_t view_layers);

/// One level of the hierarchy.
struct LevelView {
  const HierarchyNode* nodes;
  const LayerNode* layers;
  std::uint32_t count;
  std::uint32_t last_lanes;  // bit per used lane of the last node
};

/// A node or leaf that several planes cross.
struct Crossing {
  std::uint32_t index;
  PlaneMask mask;
};

struct TraversalInput {
  ItemTest test;
  PlaneMask all_planes;
  const LevelView* levels;  // [0]: the nodes above the leaves
  int level_count;
  std::uint32_t slot_count;

  // Work queues, with `stride` or `leaf_stride` entries for each plane. Those of nodes alternate from level to level.
  std::uint32_t* node_queues[2];
  Crossing* crossings[2];
  std::uint32_t* leaf_queue;
  Crossing* leaf_crossings;
  std::size_t stride, leaf_stride;

  // Answers. `inside` and `partial` have a bit per leaf for each node of level 0. `toggles` has a bit where nodes of
  // level 0 change between wholly inside and not. These three are zero at the start. leaf_masks is set for leaves whose
  // bit in `partial` is set.
  std::uint16_t *inside, *partial, *toggles;
  std::uint32_t* leaf_masks;
  std::uint64_t nodes_tested, boxes_tested;
};

/// Where a kernel writes what it finds: single slots, and edges, at which ranges begin and end in turn. Edges are
/// leaves or slots; the last end in leaves may lie behind the tree. Both arrays have room for everything, and sixteen
/// more. The kernel advances the pointers to the ends.
struct FoundSlots {
  core::Slot *items, *edges;
};

/// Items whose answers fit on the stack.
inline constexpr std::size_t kItemsAtOnce = 4096;

struct FrustumKernels {
  // --- a hierarchy ---
  /// Fills the answers of `input`.
  void (*traverse)(TraversalInput& input);
  /// Turns the answers of traverse() into slots.
  void (*extract)(const TraversalInput& input, FoundSlots& found);
  /// Sets `box` to the union of kLeafSize boxes without vacant ones; false, with anything in it, if one holds a NaN.
  bool (*leaf_box)(const float* const (&coordinates)[6], std::size_t first, float (&box)[6]);

  // --- items one after the other ---
  /// Finds the visible items of first … end - 1, of which there are 1 to kItemsAtOnce. May read kPadding boxes beyond.
  void (*cull_items)(const ItemTest& test, PlaneMask mask, std::size_t first, std::size_t end, FoundSlots& found);
  /// Sets out[i] = first + i for i < count.
  void (*count_up)(core::Slot* out, core::Slot first, std::uint32_t count);
};

const FrustumKernels& scalar_frustum_kernels();
const FrustumKernels& avx2_frustum_kernels();
const FrustumKernels& avx512_frustum_kernels();
const FrustumKernels& simd128_frustum_kernels();  ///< NEON and SIMD128
/// The table for instruction_set(); in builds for WebAssembly its own, since a module holds one form alone.
const FrustumKernels& frustum_kernels();

}  // namespace sightline::culling
