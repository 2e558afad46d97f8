// Occlusion: which boxes are hidden behind what is already drawn.
//
// Promise: conservative at the sample positions of one depth image. A box is hidden only when, at every pixel centre
// that its projection may contain, the image holds a distance that is less than that of any point of the box there.
// Whatever lies in the box then fails the depth test at each of these pixels. Boxes that reach behind the eye are never
// hidden.
//
// Two steps: first all pixels of the rectangle around the projection against the box's least distance, in the pyramid;
// then, for boxes that this leaves open, the ray of each pixel against the box itself (internal/pixel_rays.h): of boxes
// of at most 64 pixels, a pixel of each of sixteen boxes at a time (internal/small_boxes.h); of larger ones, sixteen
// pixels of the box at a time, whole blocks first. Most boxes are decided sooner, sixteen of them at a time: one look
// at 2 x 2 blocks of the pyramid hides them, or the ray of one pixel meets them in front of what it holds.
//
// Where the distances come from does not matter: a picture's own depth after a first pass, a raster of chosen
// occluders, or the application. They must be those of surfaces that are drawn, or larger. Section planes and
// transparency need no rule then: what is cut away or left out by a dither has left no distance. Distances may be
// rounded; kDistanceMargin is more than a float depth buffer and a shader's ray lose.
//
// The pyramid: after N. Greene, M. Kass, G. Miller, "Hierarchical Z-buffer visibility", 1993.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/cull_threads.h"
#include "sightline/culling/hierarchy.h"
#include "sightline/culling/internal/pixel_rays.h"
#include "sightline/culling/internal/screen_view.h"
#include "sightline/culling/sample_test.h"

namespace sightline::culling {

/// Farthest distances of blocks of 1, 2 x 2, 4 x 4, … pixels, of any picture size. Blocks at the right and upper edge
/// hold fewer pixels.
class SIGHTLINE_API DepthPyramid {
 public:
  /// `distances`: along the viewing direction from the eye, in metres, row by row from the bottom up; infinity where
  /// nothing is. A NaN counts as infinity. width * height of them, both positive. Keeps its memory.
  void build(std::span<const float> distances, int width, int height);

  /// As build() from distances that all are infinity: nothing is drawn yet.
  void clear(int width, int height);

  /// In place: distances for the caller to write, as build() takes them, but without NaN. Then finish(). Or, on several
  /// threads, write a band of kBandRows rows and call finish_band(), for all of them; then finish_above() once.
  std::span<float> begin(int width, int height);
  void finish();
  static constexpr int kBandRows = 32;
  int band_count() const { return (height() + kBandRows - 1) / kBandRows; }
  void finish_band(int band);
  void finish_above();

  int width() const { return levels_.empty() ? 0 : levels_[0].width; }
  int height() const { return levels_.empty() ? 0 : levels_[0].height; }
  /// True only if the pixels x0 … x1, y0 … y1, at least one and all within the picture, hold less than `distance`. It
  /// may be false because of a pixel beside them: at most 9 x 9 blocks that contain them are looked at,
  /// single pixels where they are no more.
  bool all_nearer(int x0, int y0, int x1, int y1, float distance) const;

  /// Blocks of a level, and the number of those of the levels before.
  struct Level {
    std::int32_t width, height, first;
    std::size_t end() const { return std::size_t(first) + std::size_t(width) * std::size_t(height); }
  };
  /// All levels of a pyramid of so many pixels, both positive: down to 3 x 3 blocks or fewer.
  static std::vector<Level> levels_of(int width, int height);
  int level_count() const { return int(levels_.size()); }
  /// Farthest distances of a row of blocks of 2^level x 2^level pixels. Sixteen floats from any of them on may be read.
  const float* row(int level, int y) const {
    const Level& l = levels_[std::size_t(level)];
    return texels_.data() + l.first + std::size_t(y) * std::size_t(l.width);
  }
  PyramidBlocks blocks() const { return {texels_.data(), widths_.data(), firsts_.data(), level_count()}; }
  std::size_t memory_bytes() const { return texels_.capacity() * sizeof(float); }

 private:
  void resize(int width, int height);
  void finish_rows(int level, int first, int end);

  std::vector<Level> levels_;
  std::array<std::int32_t, PyramidBlocks::kMostLevels> widths_{}, firsts_{};  // of these
  std::vector<float> texels_;
};

struct BlockTile;
struct FrontLayer;
struct PixelEntries;
struct SmallBoxes;
struct TileShape;

class SIGHTLINE_API OcclusionTest {
 public:
  /// A box is hidden when it is farther than the occluder by this share of the distance.
  static constexpr float kDistanceMargin = 0x1p-16f;

  /// `origin`: of the bounds whose boxes will be tested. Borrows the pyramid, which may be built anew between tests: of
  /// the distances of `view` in a picture of width x height pixels, drawn by a rasteriser of that `snap`
  /// (rasteriser_snap). While it is of another size, or not built at all, nothing is hidden. They may also be off by
  /// `error` metres, as in orthographic views, whose depth is linear.
  OcclusionTest(const core::View& view, const core::dvec3& origin, int width, int height, const DepthPyramid& pyramid,
                double error = 0.0, float snap = kCoarsestSnap);

  /// Also true of boxes that cover no pixel centre.
  bool hidden(const core::Aabb& box) const;
  /// The least distance of a box along the viewing direction, but for rounding.
  float distance(const core::Aabb& box) const;

  /// Replaces `open` by the slots of `in` whose boxes are not hidden, or whose bit is set in `exempt`. Vacant slots are
  /// left out. Large sets are shared out among `threads`, if there are any. filter_leaves() comes first where there is
  /// a `hierarchy`.
  void filter(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& open, SlotBits exempt = {},
              CullThreads* threads = nullptr, const Hierarchy* hierarchy = nullptr) const;
  /// A first, coarse step for large sets: leaves out those leaves of the hierarchy that lie within ranges of `in` and
  /// whose boxes, or those of nodes above, are hidden. `hierarchy`: over the bounds that `in` belongs to.
  void filter_leaves(const Hierarchy& hierarchy, const core::VisibleSet& in, core::VisibleSet& open,
                     SlotBits exempt = {}) const;

  /// Distributes the slots of `in` that are not hidden: `front` gets the box that the ray of each pixel enters first,
  /// and boxes too large to look at each of their pixels, or not judged. What is drawn next hides most if it is that.
  /// Where boxes are entered at the same distance, the one with the lower slot is first. `hierarchy`: as for
  /// filter_leaves(), or null. `threads`: as for filter().
  void split_front(const core::ItemBounds& bounds, const Hierarchy* hierarchy, const core::VisibleSet& in,
                   core::VisibleSet& front, core::VisibleSet& behind, CullThreads* threads = nullptr) const;

 private:
  bool fits() const { return pyramid_->width() == width_ && pyramid_->height() == height_; }
  enum class Found { kHidden, kEntered, kNotJudged };
  struct Judgement;
  Found enter(core::Slot slot, const BoxCoordinates& box, const PixelRectangle& pixels, float nearest,
              FrontLayer& layer) const;
  const core::VisibleSet& open_leaves(const Hierarchy* hierarchy, const core::VisibleSet& in, SlotBits exempt) const;
  void filter_boxes(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& open,
                    SlotBits exempt) const;
  void enter_all(const core::ItemBounds& bounds, const core::VisibleSet& in, core::VisibleSet& open,
                 FrontLayer& layer) const;
  bool hide_all(const PixelRectangle& pixels, float nearest) const;
  unsigned maybe_open(const float* const (&coordinates)[6], BoxRectangles& r) const;
  unsigned undecided(const float* const (&coordinates)[6], const BoxRectangles& r, unsigned open) const;
  unsigned open_nodes(const float* const (&coordinates)[6]) const;
  unsigned hidden_of(const float* const (&coordinates)[6]) const;
  bool waits(const PixelRectangle& pixels) const;
  unsigned open_boxes(const SmallBoxes& boxes, PixelEntries* entries = nullptr) const;
  bool hides(const BoxCoordinates& box, const PixelRectangle& pixels, float nearest) const;
  BlockTile tile_of(const TileShape& shape, int level) const;
  void move(BlockTile& tile, int level, int x, int y, int last) const;
  bool all_hidden(const BoxSpan& box, const PixelRectangle& pixels, int level, int& rows) const;

  ScreenView view_;
  PixelRays rays_;
  RayField ray_field_;
  const DepthPyramid* pyramid_;
  int width_, height_;
  float error_;
};

}  // namespace sightline::culling
