// Internal: flat figures within an analytic solid that face the eye, and so hide nearly what the solid hides.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sightline/core/affine.h"
#include "sightline/core/primitive.h"

namespace sightline::culling {

/// Corners relative to the eye: of a convex polygon, or of a hexahedron as OccluderRaster takes it.
struct SolidFigure {
  static constexpr int kMostCorners = 8;
  std::span<const core::dvec3> polygon() const { return {corners.data(), std::size_t(count)}; }

  std::array<core::dvec3, kMostCorners> corners;
  int count;
  bool hexahedron;
};

/// How the eye sees: from a point, or along a direction.
struct Sight {
  bool perspective;
  core::dvec3 forward;  // the direction, or any where the view is perspective
};

/// Appends figures within a primitive, in no order; none for lines, meshes, singular placements, and what has no volume
/// or parameters that are not finite. They are smaller than the solid: by `of_radius` of its radius (tori by four times
/// that of the tube's, and a fortieth of the other), and by `metres`.
void add_figures(core::Kind kind, const float* parameters, const core::Affine& eye_from_item, const Sight& sight,
                 double of_radius, double metres, std::vector<SolidFigure>& figures);

}  // namespace sightline::culling
