// Internal to the importers: directions of vectors that may have none.
#pragma once

#include <cmath>

#include "sightline/core/conventions.h"

namespace sightline::importers {

/// `v` with length 1, or 0 where its length is 0 or not finite.
inline core::dvec3 unit_or_zero(const core::dvec3& v) {
  const double length = glm::length(v);
  return length > 0.0 && std::isfinite(length) ? v / length : core::dvec3(0.0);
}

}  // namespace sightline::importers
