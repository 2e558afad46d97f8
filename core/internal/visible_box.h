// Boxes that a view can be fitted to.
#pragma once

#include <algorithm>

#include "sightline/core/aabb.h"

namespace sightline::core {

/// `bounds`, or a cube where they are empty or no larger than the rounding of their coordinates.
inline AabbD visible_box(const AabbD& bounds) {
  if (bounds.empty()) return {dvec3(-1.0), dvec3(1.0)};
  const dvec3 reach = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
  const double rounding = 1e-12 * std::max({reach.x, reach.y, reach.z});
  if (glm::length(bounds.size()) > std::max(1e-6, rounding)) return bounds;
  const dvec3 half(std::max(1.0, rounding));
  return {bounds.centre() - half, bounds.centre() + half};
}

}  // namespace sightline::core
