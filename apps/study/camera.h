// A view as the tests of box_tests.h want it: made once per frame.
#pragma once

#include <array>

#include "sightline/apps/study/box_tests.h"
#include "sightline/core/aabb.h"
#include "sightline/core/view.h"

namespace sightline::study {

struct Camera {
  /// `extent`: bounds of every box that will be tested. Sections and layers of the view are not looked at.
  Camera(const core::View& view, const core::Aabb& extent);

  std::array<Plane, kPlanes> planes;  ///< order of core::FrustumPlane. A missing far plane never rejects
  SplitPlanes split;
  Radar radar;
  Box bounds;  ///< of the frustum, rounded outwards

  bool has_corners = false;  ///< all planes exist: `bounds` and octants may be used
  /// Whether the view is a perspective one about its axis with a far plane; radar tests keep everything otherwise.
  bool radar_usable = false;

  /// Which plane of each pair (left or right, bottom or top, near or far) is nearer to a point: mask of three planes.
  unsigned octant(const float (&p)[3]) const {
    unsigned mask = 0;
    for (int pair = 0; pair < 3; ++pair) {
      const float* n = middles[pair];
      mask |= ((n[0] * p[0] + n[1] * p[1]) + n[2] * p[2] + n[3] < 0.0f ? 1u : 2u) << 2 * pair;
    }
    return mask;
  }
  float middles[3][4];  ///< between the planes of a pair: height over the first less height over the second
  /// Up to this radius a bounding sphere takes the octant test: distance of the frustum's centre from its next plane.
  float octant_radius = 0.0f;

  // For motion bounds, in double.
  core::dvec3 eye{0.0};
  std::array<core::dvec3, kPlanes> normals;
  std::array<double, kPlanes> eye_heights;  ///< of the planes above the eye, signed

 private:
  /// `complete`: all planes exist.
  void set_corners(const core::View& view, bool complete);
  void set_radar(const core::View& view);
};

}  // namespace sightline::study
