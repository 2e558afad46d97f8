// Where boxes lie in an image, by all of their corners.
#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "sightline/core/view.h"

namespace sightline::tests {

/// Where corners lie in the image, -1 to 1 between its borders, and how far ahead of the eye.
struct Seen {
  core::dvec2 low{std::numeric_limits<double>::infinity()}, high{-std::numeric_limits<double>::infinity()};
  double nearest = std::numeric_limits<double>::infinity();
};

inline Seen look_at_boxes(std::span<const core::AabbD> boxes, const core::View& view) {
  Seen seen;
  for (const core::AabbD& box : boxes)
    for (int corner = 0; corner < 8; ++corner) {
      const core::dvec3 p(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                          corner & 4 ? box.max.z : box.min.z);
      const core::dvec4 clip = view.clip_from_eye() * (view.eye_from_world() * core::dvec4(p, 1.0));
      const core::dvec2 place = core::dvec2(clip) / clip.w;
      seen.low = glm::min(seen.low, place);
      seen.high = glm::max(seen.high, place);
      seen.nearest = std::min(seen.nearest, clip.w);
    }
  return seen;
}

inline Seen look_at_box(const core::AabbD& box, const core::View& view) {
  return look_at_boxes({&box, 1}, view);
}

}  // namespace sightline::tests
