// How far points are from triangles, for comparisons of meshes with what stands for them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sightline/core/conventions.h"

namespace sightline::tests {

/// To the closest point of a triangle, which may be a line or a point: on its plane, or on one of its edges.
inline double distance_to_triangle(const core::dvec3& p, const std::array<core::dvec3, 3>& t) {
  const auto to_edge = [&](const core::dvec3& a, const core::dvec3& b) {
    const core::dvec3 way = b - a;
    const double squared = glm::dot(way, way);
    const double s = squared > 0.0 ? std::clamp(glm::dot(p - a, way) / squared, 0.0, 1.0) : 0.0;
    return glm::length(p - (a + s * way));
  };
  const double edges = std::min({to_edge(t[0], t[1]), to_edge(t[1], t[2]), to_edge(t[2], t[0])});
  const core::dvec3 normal = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double length = glm::length(normal);
  if (!(length > 0.0)) return edges;
  for (std::size_t k = 0; k < 3; ++k)
    if (glm::dot(glm::cross(t[(k + 1) % 3] - t[k], p - t[k]), normal) < 0.0) return edges;
  return std::fabs(glm::dot(p - t[0], normal)) / length;
}

}  // namespace sightline::tests
