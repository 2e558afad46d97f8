// Internal: boxes against what the pixels of a depth pyramid hold. What OcclusionTest decides for a set, this decides
// for sixteen boxes, or for one box of a given rectangle of pixels.
//
// Boxes are decided in this order: by their rectangles, sixteen at a time (maybe_unoccluded); by the rays of three
// pixels (undecided); then by the rays of all their pixels (hides, or, sixteen small boxes at a time,
// unoccluded_boxes).
#pragma once

#include "sightline/core/aabb.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/occlusion/detail/ray_spans.h"
#include "sightline/culling/occlusion/detail/screen_view.h"

namespace sightline::culling {

class DepthPyramid;
struct BlockTile;
struct BoxRectangles;
struct FrontLayer;
struct PixelEntries;
struct SmallBoxes;
struct TileShape;

class DepthTest {
 public:
  /// See OcclusionTest. Borrows the pyramid.
  DepthTest(const core::View& view, const core::dvec3& origin, int width, int height, const DepthPyramid& pyramid,
            double error, float snap);

  /// Whether the pyramid has the size of the image. All but distance() need that.
  bool fits() const;
  int width() const { return width_; }
  int height() const { return height_; }
  /// See OcclusionTest::distance().
  float distance(const core::Aabb& box) const;

  /// Finds the rectangles of sixteen boxes. Returns bits of those that may cover a pixel centre, and that one look at
  /// the pyramid does not hide.
  unsigned maybe_unoccluded(const float* const (&coordinates)[6], BoxRectangles& r) const;
  /// Bits of those among `unoccluded` whose rays are worth testing: not seen at one of three pixels.
  unsigned undecided(const float* const (&coordinates)[6], const BoxRectangles& r, unsigned unoccluded) const;
  /// Bits of sixteen nodes that are not hidden by all their pixels alike. Their rays are not tested: nodes are large.
  unsigned unoccluded_nodes(const float* const (&coordinates)[6]) const;
  /// Bit i: box i of sixteen is hidden, or covers no pixel centre.
  unsigned occluded(const float* const (&coordinates)[6]) const;

  /// Pixels of the rectangle of box i.
  PixelRectangle pixels(const BoxRectangles& r, int i) const;
  /// Whether a box of these pixels is tested with others, by unoccluded_boxes().
  bool waits(const PixelRectangle& pixels) const;
  /// See OcclusionKernels::unoccluded_boxes.
  unsigned unoccluded_boxes(const SmallBoxes& boxes, PixelEntries* entries = nullptr) const;
  /// Whether all these pixels hide a box. `nearest`: its least distance.
  bool hides(const BoxCoordinates& box, const PixelRectangle& pixels, float nearest) const;

  enum class Found { kOccluded, kEntered, kNotJudged };
  /// Enters a box into the layer at each of these pixels whose ray meets it in front of what the pixel holds.
  Found enter(core::Slot slot, const BoxCoordinates& box, const PixelRectangle& pixels, float nearest,
              FrontLayer& layer) const;

 private:
  bool hide_all(const PixelRectangle& pixels, float nearest) const;
  BlockTile tile_of(const TileShape& shape, int level) const;
  void move(BlockTile& tile, int level, int x, int y, int last) const;
  bool all_occluded(const BoxSpan& box, const PixelRectangle& pixels, int level, int& rows) const;

  ScreenView view_;
  RaySpans rays_;
  RayField ray_field_;
  const DepthPyramid* pyramid_;
  int width_, height_;
  float error_;
};

}  // namespace sightline::culling
