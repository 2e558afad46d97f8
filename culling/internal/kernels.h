// Internal: the inner loops of the cullers, one form per instruction set, behind plain pointers. The files that define
// them are compiled for their instruction set. So they must not call inline functions of other headers: the linker
// might use their copy in code for every processor.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sightline/core/internal/instruction_set.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum_test.h"
#include "sightline/culling/hierarchy.h"
#include "sightline/culling/internal/occluder_area.h"
#include "sightline/culling/internal/screen_view.h"

namespace sightline::culling {

struct OccluderImage;

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
  int levels_walked;
};

/// Where a kernel writes what it finds: single slots, and edges, at which ranges begin and end in turn. Edges are
/// leaves or slots; the last end in leaves may lie behind the tree. Both arrays have room for everything, and sixteen
/// more. The kernel advances the pointers to the ends.
struct FoundSlots {
  core::Slot *items, *edges;
};

/// Of sixteen boxes: rectangles in the picture, pixel centres at integers, and the least distance from the eye. Errors
/// make rectangles larger and distances smaller, never the other way. They hold for boxes with their bit in `projects`.
struct BoxRectangles {
  alignas(64) float left[kLanes], right[kLanes], bottom[kLanes], top[kLanes], nearest[kLanes];
  unsigned projects;
  unsigned covering;  // bit i: box i may cover a sample of the picture
};

/// A box is behind a distance by more than this share of its own, and by metres.
struct DistanceMargin {
  float share, metres;
};

/// Squares in place of sixteen boxes: where the centres are in the picture, pixel centres at integers, how far they are
/// along the viewing direction, and the squares' areas in pixels. Means nothing without a bit in `showing`.
struct BoxSquares {
  alignas(64) float x[kLanes], y[kLanes], distance[kLanes], area[kLanes];
  unsigned showing;  // bit i: square i may cover a pixel centre of the picture; or, if that is asked for, its centre is
                     // in the picture
};

/// Sixteen blocks of pixels, and how what they hold is compared.
struct BlockTile {
  int columns_log2;       // blocks of a row: 1, 2, 4, 8 or 16
  float x, y, step;       // middle of the first block, and the way to the next ones'
  float reach;            // from a block's middle to the last place that belongs to it, along both axes
  const float* farthest;  // distances that the blocks of the first row hold
  std::ptrdiff_t pitch;   // from these to the next row's
  int rows;               // that may be read, at least one; lanes of rows beyond mean nothing
  DistanceMargin margin;
  bool parallel;  // keys are -t, not 1 / t
};

/// Up to sixteen boxes, and the pixels of their rectangles: whole numbers, from left to right and from bottom to top,
/// all in the picture.
struct SmallBoxes {
  static constexpr int kMostPixels = 64;  // of each
  alignas(64) float coordinates[6][kLanes];
  alignas(64) float left[kLanes], right[kLanes], bottom[kLanes], top[kLanes];
  int count;  // the arrays hold valid boxes behind them, too
};

/// Where rays enter boxes of SmallBoxes.
struct PixelEntries {
  struct Entry {
    int box, x, y;
    float distance;  // at least
  };
  unsigned judged;  // bit i: something is known of box i
  int count;        // of entries
  Entry of[SmallBoxes::kMostPixels * kLanes];
};

ScreenView make_screen_view(const core::View& view, const core::dvec3& origin, int width, int height, float snap);

/// Items whose answers fit on the stack.
inline constexpr std::size_t kItemsAtOnce = 4096;

struct Kernels {
  /// Fills the answers of `input`.
  void (*traverse)(TraversalInput& input);
  /// Turns these answers into slots.
  void (*extract)(const TraversalInput& input, FoundSlots& found);
  /// Finds the visible items of first … end - 1, of which there are 1 to kItemsAtOnce. Writes groups of kLanes that are
  /// wholly visible as ranges of slots, others as single slots. `edges` has room for one more than there are groups.
  /// May read kPadding boxes beyond.
  void (*cull_items)(const ItemTest& test, PlaneMask mask, std::size_t first, std::size_t end, FoundSlots& found);
  /// out[i] = first + i for i < count.
  void (*count_up)(core::Slot* out, core::Slot first, std::uint32_t count);
  /// Union of the boxes of kLeafSize items, in the order of the coordinates. Vacant slots do not count. Returns false,
  /// with anything in `box`, when one of the boxes holds a NaN.
  bool (*leaf_box)(const float* const (&coordinates)[6], std::size_t first, float (&box)[6]);
  void (*rectangles)(const ScreenView& view, const float* const (&coordinates)[6], BoxRectangles& out);
  /// Bit i: box i, which must cover a sample and project, lies behind what the pixels of its rectangle hold. One look
  /// at 2 x 2 blocks of the pyramid, so it may be 0 for boxes that are behind.
  unsigned (*behind)(const ScreenView& view, const BoxRectangles& boxes, const PyramidBlocks& pyramid,
                     const DistanceMargin& margin);
  /// Bit i: the ray of a pixel in box i's rectangle meets the box in front of what the pixel holds, but for rounding.
  /// So most boxes that are not hidden are known without a look at all of their pixels. Looks at three pixels along the
  /// rectangle's longer side, at the middle one alone where that answers for all boxes in `asked`.
  unsigned (*seen)(const ScreenView& view, const RayField& rays, const float* const (&coordinates)[6],
                   const BoxRectangles& boxes, unsigned asked, const PyramidBlocks& pyramid);
  /// Areas of the boxes' outlines in the picture, sixteen floats: infinite for boxes that do not project, 0 for empty
  /// ones. `solids`: null, or of each box an area in square metres; where that faces the eye at the box's centre and
  /// takes fewer pixels, these.
  void (*areas)(const ScreenView& view, const float* const (&coordinates)[6], const float* solids, float* out);
  /// `solids` as above. `least_area`: that squares will have, pixels. `all`: also those between pixel
  /// centres.
  void (*squares)(const ScreenView& view, const float* const (&coordinates)[6], const float* solids, float least_area,
                  bool all, BoxSquares& out);
  /// Bit i: at some place of block i a ray may meet the box, no farther than the block's distance. Writes at what
  /// distance it enters the box, at least: sixteen floats, which mean something where the bit is set.
  unsigned (*open_blocks)(const BoxSpan& box, const BlockTile& tile, float* entries);
  /// Bit i: at some of its pixels a ray may meet box i, no farther than what the pixel holds, or nothing is known of
  /// box i. `snap`: as in ScreenView. `entries`: null, or filled with the pixels and distances at which rays enter the
  /// boxes of which something is known.
  unsigned (*open_boxes)(const RayField& rays, const SmallBoxes& boxes, float snap, const PyramidBlocks& pyramid,
                         const DistanceMargin& margin, PixelEntries* entries);
  /// Whether all of `height` rows of `width` floats, both at most kLanes, are less than a limit. The first floats of
  /// rows are `pitch` apart, and kLanes of each row may be read.
  bool (*all_less)(const float* first, std::ptrdiff_t pitch, int width, int height, float limit);
  /// Raises the nearness that the pixels of an area hold to that of the area. `stride`: a multiple of kLanes.
  void (*fill_area)(const OccluderArea& area, float* image, int stride);
  /// Raises the nearness that an image's pixels hold to that of polygons in front of its near plane. Bit i: polygon i
  /// covers a pixel, but for its inset.
  unsigned (*cover_quads)(const OccluderImage& image, const PolygonBatch<4>& polygons, float* pixels);
  unsigned (*cover_octagons)(const OccluderImage& image, const PolygonBatch<8>& polygons, float* pixels);
  /// Bit i: some pixel that may lie within quad i holds nothing nearer than the quad there, or nothing is known of the
  /// quad. `image`: of the picture of which the pyramid is, without pixels.
  unsigned (*seen_quads)(const OccluderImage& image, const PolygonBatch<4>& quads, const PyramidBlocks& pyramid,
                         const DistanceMargin& margin);
  /// Distances of `count` pixels of a row, from the greatest nearness that one of the images holds: its reciprocal,
  /// rounded up, or its negative where the view is not perspective.
  void (*distances)(const float* const* nearness, int images, bool perspective, int count, float* out);
  /// The greatest of each 2 x 2 floats of two rows of `width`. Of an odd width the last ones stand alone.
  void (*coarser_row)(const float* low, const float* high, int width, float* out);
};

const Kernels& scalar_kernels();
const Kernels& avx2_kernels();
const Kernels& avx512_kernels();
/// The kernels of instruction_set().
const Kernels& kernels();

}  // namespace sightline::culling
