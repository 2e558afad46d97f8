// Distance of a triangle from a point. Internal to sightline-bench contribution and lod.
#pragma once

#include "sightline/core/conventions.h"

namespace sightline::bench {

/// The distance of a triangle from the origin. Not what the proof of levels computes with (lod/surface_deviation.cpp),
/// so that what is measured does not rest on it. After C. Ericson, "Real-Time Collision Detection", 2005, 5.1.5.
inline double distance_to_triangle(const core::dvec3& a, const core::dvec3& b, const core::dvec3& c) {
  const core::dvec3 ab = b - a, ac = c - a;
  const double d1 = -glm::dot(ab, a), d2 = -glm::dot(ac, a);
  if (d1 <= 0.0 && d2 <= 0.0) return glm::length(a);
  const double d3 = -glm::dot(ab, b), d4 = -glm::dot(ac, b);
  if (d3 >= 0.0 && d4 <= d3) return glm::length(b);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return glm::length(a + d1 / (d1 - d3) * ab);
  const double d5 = -glm::dot(ab, c), d6 = -glm::dot(ac, c);
  if (d6 >= 0.0 && d5 <= d6) return glm::length(c);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return glm::length(a + d2 / (d2 - d6) * ac);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0)
    return glm::length(b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b));
  return glm::length(a + ab * (vb / (va + vb + vc)) + ac * (vc / (va + vb + vc)));
}

}  // namespace sightline::bench
