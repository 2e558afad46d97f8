// The sample test for the triangles of meshes: which of them can colour an image at all. Of a mesh of small triangles
// these are few. Internal: for what draws.
//
// Promise: conservative, so an image loses nothing. A triangle is rejected only when no sample of the image lies within
// it, or, where back faces are not drawn, when it is one. Both hold for any corners that a shader computes in float
// from the same placement, and a rasteriser then moves (ImageSamples::snap). Triangles that reach behind the eye, or so
// near to it that the corners' places are not known well, are kept, and so are those with a coordinate that is not
// finite. All instruction sets give the same answer.
#pragma once

#include <cstdint>
#include <span>

#include "sightline/core/affine.h"
#include "sightline/core/view.h"
#include "sightline/culling/occlusion/internal/kernels.h"
#include "sightline/culling/occlusion/sample_test.h"

namespace sightline::culling {

class TriangleTest {
 public:
  TriangleTest(const core::View& view, const ImageSamples& samples);

  /// How the image shows a mesh that a shader places in eye space by a float matrix and origin. `fronts_alone`: only
  /// triangles that are counter-clockwise in the image are drawn.
  TriangleView of(const core::Affine& world_from_mesh, bool fronts_alone) const;
  /// Writes the corners of triangles that may colour the image, in order, and returns their number. `indices`: three
  /// per triangle; `shown` has room for as many.
  static std::size_t filter(const TriangleView& view, std::span<const core::vec3> positions,
                            std::span<const std::uint32_t> indices, std::uint32_t* shown);

 private:
  core::dmat4 eye_from_world_;
  core::dmat3 world_from_eye_;  // linear part
  core::dmat4 clip_rows_;       // rows: linear forms of eye space
  double width_, height_;
  float snap_, reach_ = 0.0f;
};

}  // namespace sightline::culling
