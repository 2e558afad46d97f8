// Internal: the inner loops of sample, contribution and occlusion tests and of the occluder raster, one form per
// instruction set, in a table of plain pointers. The files that define them are compiled for their instruction set. So
// they must not call inline functions of other headers: the linker might use their copy in code for every processor.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sightline/culling/frustum/hierarchy.h"
#include "sightline/culling/occlusion/detail/screen_view.h"
#include "sightline/culling/occlusion/internal/occluder_area.h"

namespace sightline::culling {

struct OccluderImage;

/// Sixteen boxes: their rectangles in the image, pixel centres at integers, and the least distance from the eye. Errors
/// make rectangles larger and distances smaller, never the other way. They hold for boxes with their bit in `projects`.
struct BoxRectangles {
  alignas(64) float left[kLanes], right[kLanes], bottom[kLanes], top[kLanes], nearest[kLanes];
  unsigned projects;
  unsigned covering;  // bit i: box i may cover a sample of the image
};

/// A box is behind a distance by more than this share of its own, and by metres.
struct DistanceMargin {
  float share, metres;
};

/// Squares in place of sixteen boxes: where the centres are in the image, pixel centres at integers, how far they are
/// along the viewing direction, and the squares' areas in pixels. Means nothing without a bit in `showing`.
struct BoxSplats {
  alignas(64) float x[kLanes], y[kLanes], distance[kLanes], area[kLanes];
  unsigned showing;  // bit i: square i may cover a pixel centre of the image; or, if that is asked for, its centre is
                     // in the image
};

/// Sixteen blocks of pixels, and how what they hold is compared.
struct BlockTile {
  int columns_log2;       // blocks of a row: 1, 2, 4, 8 or 16
  float x, y, step;       // middle of the first block, and the way to the next ones'
  float half_extent;      // from a block's middle to the last place that belongs to it, along both axes
  const float* farthest;  // distances that the blocks of the first row hold
  std::ptrdiff_t pitch;   // from these to the next row's
  int rows;               // that may be read, at least one; lanes of rows beyond mean nothing
  DistanceMargin margin;
  bool parallel;  // keys are -t, not 1 / t
};

/// Up to sixteen boxes, and the pixels of their rectangles: whole numbers, from left to right and from bottom to top,
/// all in the image.
struct SmallBoxes {
  static constexpr int kMostPixels = 64;  // of each
  alignas(64) float coordinates[6][kLanes];
  alignas(64) float left[kLanes], right[kLanes], bottom[kLanes], top[kLanes];
  int count;  // the arrays hold valid boxes behind them, too
};

/// How an image shows a mesh: linear forms of the mesh's coordinates, the constant term last.
struct TriangleView {
  float x[4], y[4], w[4];          // x / w, y / w: place in the image, in pixels, with the first pixel's centre at 0
  float lost_place[4], lost_w[4];  // errors of x and y, and of w: forms of the coordinates' sizes
  float last_x, last_y;            // the last pixel's centre
  float reach;                     // of samples from their pixel's centre, along an axis
  float snap;                      // pixels by which a rasteriser may move a vertex
  bool fronts_alone;               // only triangles that are counter-clockwise in the image are drawn
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

/// Sixteen boxes are given by their coordinates: six arrays of kLanes floats. Answers are bits, bit i of box i.
struct OcclusionKernels {
  // --- boxes in the image ---
  /// Finds the rectangles of sixteen boxes.
  void (*rectangles)(const ScreenView& view, const float* const (&coordinates)[6], BoxRectangles& out);
  /// Writes the projected areas of sixteen boxes, or of `solids` (square metres, or null) where these take less.
  void (*areas)(const ScreenView& view, const float* const (&coordinates)[6], const float* solids, float* out);
  /// Finds the squares that stand for sixteen boxes, `least_area` pixels or larger; `all`: also between pixel centres.
  void (*splats)(const ScreenView& view, const float* const (&coordinates)[6], const float* solids, float least_area,
                 bool all, BoxSplats& out);

  // --- boxes against the depth pyramid ---
  /// Finds boxes behind 2 x 2 blocks around their rectangles. They must cover a sample and project. May miss some.
  unsigned (*behind)(const ScreenView& view, const BoxRectangles& boxes, const PyramidBlocks& pyramid,
                     const DistanceMargin& margin);
  /// Finds boxes that the ray of one of three pixels meets in front of what the pixel holds, but for rounding. Where
  /// the pyramid has no blocks (null), pixels hold nothing; so does unoccluded_boxes().
  unsigned (*seen)(const ScreenView& view, const RayField& rays, const float* const (&coordinates)[6],
                   const BoxRectangles& boxes, unsigned asked, const PyramidBlocks& pyramid);
  /// Bit i: a ray of block i may meet the box within the block's distance. Writes the least distances of entry.
  unsigned (*unoccluded_blocks)(const BoxSpan& box, const BlockTile& tile, float* entries);
  /// Finds boxes that a ray may meet within its pixel's distance, or of which nothing is known. `entries` may be null.
  unsigned (*unoccluded_boxes)(const RayField& rays, const SmallBoxes& boxes, float snap, const PyramidBlocks& pyramid,
                               const DistanceMargin& margin, PixelEntries* entries);
  /// Whether a block of at most kLanes x kLanes floats is less than a limit. Reads kLanes floats of each row.
  bool (*all_less)(const float* first, std::ptrdiff_t pitch, int width, int height, float limit);

  // --- occluder polygons ---
  /// Raises the pixels of an area to its reciprocal depth. `stride`: a multiple of kLanes.
  void (*fill_area)(const OccluderArea& area, float* image, int stride);
  /// Raises the pixels of polygons in front of the near plane. Bit i: polygon i covers a pixel, but for its inset.
  unsigned (*cover_quads)(const OccluderImage& image, const PolygonBatch<4>& polygons, float* pixels);
  unsigned (*cover_octagons)(const OccluderImage& image, const PolygonBatch<8>& polygons, float* pixels);
  /// Finds quads in front of what some pixel within them holds, or of which nothing is known. Ignores image's pixels.
  unsigned (*seen_quads)(const OccluderImage& image, const PolygonBatch<4>& quads, const PyramidBlocks& pyramid,
                         const DistanceMargin& margin);

  // --- triangles of meshes ---
  /// Writes the corners of triangles that may colour a sample, and returns their number. `shown` has room for all.
  std::size_t (*shown_triangles)(const TriangleView& view, const float* positions, const std::uint32_t* indices,
                                 std::size_t count, std::uint32_t* shown);

  // --- rows of depth images ---
  /// Writes distances of `count` pixels from the greatest reciprocal depth of several images, rounded up.
  void (*distances)(const float* const* reciprocal_depth, int images, bool perspective, int count, float* out);
  /// Writes the greatest of each 2 x 2 floats of two rows; with an odd width the last column stands alone.
  void (*coarser_row)(const float* low, const float* high, int width, float* out);
};

const OcclusionKernels& scalar_occlusion_kernels();
const OcclusionKernels& avx2_occlusion_kernels();
const OcclusionKernels& avx512_occlusion_kernels();
const OcclusionKernels& simd128_occlusion_kernels();  ///< NEON and SIMD128
/// The table for instruction_set(); in builds for WebAssembly its own, since a module holds one form alone.
const OcclusionKernels& occlusion_kernels();

}  // namespace sightline::culling
