#include "sightline/culling/occlusion/detail/depth_test.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "sightline/culling/occlusion/depth_pyramid.h"
#include "sightline/culling/occlusion/internal/filter_boxes.h"
#include "sightline/culling/occlusion/internal/front_layer.h"
#include "sightline/culling/occlusion/internal/kernels.h"
#include "sightline/culling/occlusion/internal/tile_shape.h"
#include "sightline/culling/occlusion/occlusion_test.h"

namespace sightline::culling {
namespace {

constexpr float kCentre[1][2] = {{0.0f, 0.0f}};  // the one sample of a pixel
constexpr int kLevels = 4;     // of which the coarse one's blocks hold kLanes x kLanes of the fine one's
constexpr int kMostRows = 64;  // of blocks to look at; boxes that need more are open
constexpr float kDistanceMargin = OcclusionTest::kDistanceMargin;

}  // namespace

DepthTest::DepthTest(const core::View& view, const core::dvec3& origin, int width, int height,
                     const DepthPyramid& pyramid, double error, float snap)
    : view_(make_screen_view(view, origin, width, height, snap)),
      rays_(view, origin, width, height),
      ray_field_(rays_.field()),
      pyramid_(&pyramid),
      width_(width),
      height_(height),
      error_(float(error)) {
  view_.samples = kCentre;
  view_.sample_count = 1;
}

bool DepthTest::fits() const {
  return pyramid_->width() == width_ && pyramid_->height() == height_;
}

/// Whether these pixels hide whatever is no nearer than that.
bool DepthTest::hide_all(const PixelRectangle& pixels, float nearest) const {
  return pyramid_->all_nearer(pixels.x0, pixels.y0, pixels.x1, pixels.y1,
                              nearest - (kDistanceMargin * std::abs(nearest) + error_));
}

bool DepthTest::hides(const BoxCoordinates& box, const PixelRectangle& pixels, float nearest) const {
  if (waits(pixels)) return unoccluded_boxes(RayQueues::only(box, pixels)) == 0;
  if (hide_all(pixels, nearest)) return true;
  BoxSpan span;
  if (!rays_.span(box, span)) return false;
  const unsigned size = unsigned(std::max(pixels.x1 - pixels.x0, pixels.y1 - pixels.y0));
  int level = 0;
  while (size >> level >= unsigned(kLanes) - 1) level += kLevels;
  int rows = 0;
  return all_occluded(span, pixels, std::min(level, pyramid_->level_count() - 1), rows);
}

PixelRectangle DepthTest::pixels(const BoxRectangles& r, int i) const {
  return pixels_of(view_, r, i);
}

bool DepthTest::waits(const PixelRectangle& pixels) const {
  return rays_.usable() && RayQueues::takes(pixels);
}

unsigned DepthTest::unoccluded_boxes(const SmallBoxes& boxes, PixelEntries* entries) const {
  return occlusion_kernels().unoccluded_boxes(ray_field_, boxes, view_.snap, pyramid_->blocks(),
                                              {kDistanceMargin, error_}, entries);
}

/// The tile for looks at blocks of a level, without its place.
BlockTile DepthTest::tile_of(const TileShape& shape, int level) const {
  const float step = float(1 << level);
  BlockTile tile{};
  tile.columns_log2 = shape.columns_log2;
  tile.step = step;
  tile.half_extent = 0.5f * (step - 1.0f) + view_.snap;
  tile.pitch = pyramid_->row(level, 1) - pyramid_->row(level, 0);
  tile.margin = {kDistanceMargin, error_};
  tile.parallel = rays_.parallel();
  return tile;
}

/// Moves a tile to the block x, y. Rows of blocks to look at go up to the row `last`.
void DepthTest::move(BlockTile& tile, int level, int x, int y, int last) const {
  tile.x = (float(x) + 0.5f) * tile.step - 0.5f;
  tile.y = (float(y) + 0.5f) * tile.step - 0.5f;
  tile.farthest = pyramid_->row(level, y) + x;
  tile.rows = last - y + 1;
}

/// Whether no ray of these pixels meets the box in front of what the pixel holds. Looks at blocks of a level, and into
/// those that do not answer for all of their pixels.
bool DepthTest::all_occluded(const BoxSpan& box, const PixelRectangle& pixels, int level, int& rows) const {
  const PixelRectangle blocks{pixels.x0 >> level, pixels.y0 >> level, pixels.x1 >> level, pixels.y1 >> level};
  const TileShape shape(blocks.x1 - blocks.x0 + 1);
  BlockTile tile = tile_of(shape, level);
  alignas(64) float entries[kLanes];
  for (int y = blocks.y0; y <= blocks.y1; y += shape.rows()) {
    rows += std::min(shape.rows(), blocks.y1 - y + 1);
    if (rows > kMostRows) return false;
    move(tile, level, blocks.x0, y, blocks.y1);
    unsigned unoccluded = occlusion_kernels().unoccluded_blocks(box, tile, entries) &
                          shape.lanes(blocks.x1 - blocks.x0 + 1, blocks.y1 - y + 1);
    if (unoccluded != 0 && level == 0) return false;
    for (; unoccluded != 0; unoccluded &= unoccluded - 1) {
      const int lane = std::countr_zero(unoccluded), at_x = blocks.x0 + shape.x(lane), at_y = y + shape.y(lane);
      const PixelRectangle inside{std::max(pixels.x0, at_x << level), std::max(pixels.y0, at_y << level),
                                  std::min(pixels.x1, ((at_x + 1) << level) - 1),
                                  std::min(pixels.y1, ((at_y + 1) << level) - 1)};
      if (!all_occluded(box, inside, std::max(0, level - kLevels), rows)) return false;
    }
  }
  return true;
}

float DepthTest::distance(const core::Aabb& box) const {
  const LinearForm& t = view_.t;
  return t.x * (t.x > 0.0f ? box.min.x : box.max.x) + t.y * (t.y > 0.0f ? box.min.y : box.max.y) +
         t.z * (t.z > 0.0f ? box.min.z : box.max.z) + t.d;
}

unsigned DepthTest::maybe_unoccluded(const float* const (&coordinates)[6], BoxRectangles& r) const {
  occlusion_kernels().rectangles(view_, coordinates, r);
  const unsigned judged = r.covering & r.projects;
  if (judged == 0) return r.covering;
  return r.covering & ~(judged & occlusion_kernels().behind(view_, r, pyramid_->blocks(), {kDistanceMargin, error_}));
}

unsigned DepthTest::undecided(const float* const (&coordinates)[6], const BoxRectangles& r, unsigned unoccluded) const {
  unsigned judged = unoccluded & r.projects;
  if (judged != 0 && rays_.usable())
    judged &= ~occlusion_kernels().seen(view_, ray_field_, coordinates, r, judged, pyramid_->blocks());
  return judged;
}

unsigned DepthTest::unoccluded_nodes(const float* const (&coordinates)[6]) const {
  BoxRectangles r;
  unsigned unoccluded = maybe_unoccluded(coordinates, r);
  for (unsigned bits = undecided(coordinates, r, unoccluded); bits != 0; bits &= bits - 1) {
    const int i = std::countr_zero(bits);
    if (hide_all(pixels(r, i), r.nearest[i])) unoccluded &= ~(1u << i);
  }
  return unoccluded;
}

unsigned DepthTest::occluded(const float* const (&coordinates)[6]) const {
  return ~unoccluded_of(*this, coordinates);
}

DepthTest::Found DepthTest::enter(core::Slot slot, const BoxCoordinates& box, const PixelRectangle& pixels,
                                  float nearest, FrontLayer& layer) const {
  if (hide_all(pixels, nearest)) return Found::kOccluded;
  BoxSpan span;
  const int columns = (pixels.x1 - pixels.x0) / kLanes + 1;
  if (columns * (pixels.y1 - pixels.y0 + 1) > kMostRows || !rays_.span(box, span))
    return hides(box, pixels, nearest) ? Found::kOccluded : Found::kNotJudged;
  const TileShape shape(pixels.x1 - pixels.x0 + 1);
  BlockTile tile = tile_of(shape, 0);
  alignas(64) float entries[kLanes];
  Found found = Found::kOccluded;
  for (int y = pixels.y0; y <= pixels.y1; y += shape.rows())
    for (int x = pixels.x0; x <= pixels.x1; x += shape.columns()) {
      move(tile, 0, x, y, pixels.y1);
      const unsigned lanes = shape.lanes(pixels.x1 - x + 1, pixels.y1 - y + 1);
      for (unsigned unoccluded = occlusion_kernels().unoccluded_blocks(span, tile, entries) & lanes; unoccluded != 0;
           unoccluded &= unoccluded - 1) {
        const int lane = std::countr_zero(unoccluded);
        const std::size_t row = std::size_t(y + shape.y(lane)) * std::size_t(pyramid_->width());
        layer.enter(row + std::size_t(x + shape.x(lane)), entries[lane], slot);
        found = Found::kEntered;
      }
    }
  return found;
}

}  // namespace sightline::culling
