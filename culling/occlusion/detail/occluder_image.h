// Internal: the state of an OccluderRaster.
#pragma once

#include <array>
#include <vector>

#include "sightline/core/large_array.h"
#include "sightline/core/view.h"

namespace sightline::culling {

/// A linear form of world points p: dot(normal, p - eye) + at_eye. Great coordinates cost no digits so.
struct EyeForm {
  core::dvec3 normal;
  core::dvec3 sizes;    // of what entered the normal
  double at_eye, lost;  // by how much at_eye may be off
};

struct OccluderImage {
  int width = 0, height = 0;
  int stride = 0;                            // pixels from row to row
  core::LargeArray<float> reciprocal_depth;  // row by row
  bool perspective = true;
  bool usable = false;  // else nothing can be covered
  double snap = 0.0;    // pixels by which a rasteriser may move a corner
  // x, y: place in the image, in pixels with centres at integers; times z in perspective views. z: distance along the
  // viewing direction. near: 0 or more where the near plane leaves a point.
  EyeForm x, y, z, near;
  core::dvec3 eye, forward;  // forward: not of unit length if the view scales
  std::array<core::Plane, core::kFrustumPlaneCount> frustum;
  std::vector<EyeForm> sections;  // of planes with a normal
  core::SectionMode section_mode = core::SectionMode::kIntersection;
};

}  // namespace sightline::culling
