// A depth image of chosen occluders, made by the CPU alone: for DepthPyramid and the occlusion test, where no renderer
// has drawn anything. A few hundred large solids in front of the eye hide most of a plant.
//
//   culling::OccluderRaster raster;
//   raster.begin(view, 640, 360);
//   raster.add_largest(walls_and_vessels, 256);
//   raster.build(pyramid);
//   culler.visible(view, pyramid, indices);   // BoxCuller
//
// Promise: inner-conservative. Where a pixel holds a distance, the line of sight through its centre meets an added
// occluder, beyond the near plane and at that distance or nearer. So occluders must be solid and opaque, and drawn: a
// wall, a vessel's inscribed cylinder, a triangle of a mesh. The bounding box of a pipe is none. Occluders that a
// section plane of the view cuts or removes hide nothing; of meshes this holds for single triangles. The same answer on
// every instruction set.
//
// Boxes and cylinders are rasterised as wholes: the outline of a convex solid is a convex polygon, and a line of sight
// enters it through the farthest of its front planes. (Compare D. Schmalstieg, R. Tobler, "Fast projected area
// computation for three-dimensional bounding boxes", 1999.) As in masked occlusion culling (J. Hasselgren,
// M. Andersson, T. Akenine-Möller, "Masked software occlusion culling", 2016) the sides of a polygon give a span for
// each row, many rows at a time. The image holds a float for each pixel, though, not two distances and a mask for each
// tile: the depth pyramid begins with pixels.
//
// Rounding. What is computed in double, forms of the corners and their quotients, is off by at most a distance `error`
// in the image, which follows from the sizes of the terms; occluders for which it is not tiny are left out. What is
// computed in float, spans and distances within one area, is off by a few units of the area's size.
//   - Coverage: let p lie to the left of every side of the outline, by `error` + `inset` along both axes. The square of
//     that half size around p then lies in the hull of the computed corners. Corners are off by less, so p lies in the
//     hull of the exact ones: else a line would part p from these, and the square from the computed ones. The inset
//     holds the error of the float sides and, for boxes and cylinders, what a rasteriser may move a vertex: an image
//     drawn from the same solids covers these pixels too. Meshes have only the former, or gaps would open between their
//     triangles.
//   - Distance: reciprocal depth (the reciprocal of the distance, or its negative where the view is orthographic) is
//   linear
//     across a face. A computed plane is lowered until it lies below all corners of its face, then by its slope times
//     `error` and the vertex shift, then by its error in float: it is not nearer than the face. A solid's reciprocal
//     depth where a line of sight enters is that of some front face, so at least the least of all front planes; and at
//     least that of its farthest corner. Where rounding leaves open whether a face is a front face, the latter alone
//     counts, unless the face is so near to the outline that the inset leaves no pixel that could see it.
//   - Faces and triangles that cross the near plane are clipped there, or so far in front of the eye that `error` is
//     tiny (some millimetres, for occluders of hundreds of metres). The new corners lie on the exact edges but for what
//     `error` allows. An eye inside a solid sees none of its front faces: the solid hides nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/affine.h"
#include "sightline/core/api.h"
#include "sightline/core/view.h"
#include "sightline/culling/occlusion/depth_pyramid.h"
#include "sightline/culling/occlusion/detail/occluder_image.h"
#include "sightline/culling/occlusion/sample_test.h"

namespace sightline::culling {

struct OccluderPolygon;
struct WholeSolid;

/// Reuse one from frame to frame: it keeps its memory. One thread at a time.
class SIGHTLINE_API OccluderRaster {
 public:
  /// Empties the image, for occluders of this view in an image of width x height pixels, 1 … kMostPixels each. The
  /// view must know its eye; in one made from a combined matrix, or whose depth is not a function of the distance along
  /// the viewing direction, nothing is covered. `snap`: of the rasteriser that draws the occluders (rasteriser_snap).
  void begin(const core::View& view, int width, int height, float snap = kCoarsestSnap);
  static constexpr int kMostPixels = 16384;

  /// The next four return false when the occluder certainly hides nothing: it covers no pixel centre, or a section
  /// plane cuts it, or the eye is in it, or its numbers are not finite.

  /// A solid box in the world. Empty ones hide nothing.
  bool add_box(const core::AabbD& box);
  /// The cube -1 … 1 in a placement: an oriented box.
  bool add_cube(const core::Affine& world_from_cube);
  /// The cylinder of radius 1 about z, from -1 to 1, as its inscribed prism of 3 … 16 sides. More sides hide more and
  /// cost more. Sides that the near plane cuts hide nothing: it opens the cylinder before it meets the prism.
  bool add_cylinder(const core::Affine& world_from_cylinder, int sides = 8);

  /// Occluder polygons within solids (internal/inner_occluders.h), first those of the first solid. Those of solids
  /// whose box the near plane or a section plane may cut hide nothing, except for hexahedra whose growth is known, in
  /// perspective views: the near plane clips these.
  bool add_within(std::span<const WholeSolid> solids, std::span<const OccluderPolygon> polygons);

  /// Tests quads in front of solids (internal/inner_occluders.h): 0 for those that lie behind what all of their pixels
  /// hold in a pyramid of this view and size, else 1. So a solid is hidden when all its quads are. `error`: as for
  /// OcclusionTest.
  void find_seen(std::span<const OccluderPolygon> quads, const DepthPyramid& pyramid, double error,
                 std::vector<std::uint8_t>& seen) const;

  /// Triangles of any winding, seen from both sides; three indices each, all below positions.size().
  void add_mesh(std::span<const core::vec3> positions, std::span<const std::uint32_t> indices,
                const core::Affine& world_from_mesh);

  /// Adds the `count` boxes of `solids` that look largest from the eye (by the solid angle of their faces; in
  /// orthographic views by the projected area), of those that meet the view volume. Returns how many were added. Linear
  /// in the number of solids: hand in hundreds or thousands, not every box of a plant.
  std::size_t add_largest(std::span<const core::AabbD> solids, std::size_t count);

  /// Hands the image to the pyramid, which has its size then. More occluders may follow.
  void build(DepthPyramid& pyramid) const;
  /// Writes the image row by row from the bottom up, as DepthPyramid::build() takes it: width * height floats.
  /// `others`: images of the same view and size, whose occluders count, too.
  void distances(std::span<float> out, std::span<const OccluderRaster* const> others = {}) const;
  /// Writes rows first … end - 1 alone. `out` has room for all rows.
  void distances_of_rows(int first, int end, std::span<float> out, std::span<const OccluderRaster* const> others) const;

 private:
  OccluderImage image_;
};

}  // namespace sightline::culling
