// The distance of a point from triangles, found slowly and plainly: what proven bounds are held against.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"
#include "sightline/core/mesh.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests {

/// By the edges, and by the height above the plane where the foot of the perpendicular lies within.
inline double distance_to_triangle(const core::dvec3& p, const core::dvec3& a, const core::dvec3& b,
                                   const core::dvec3& c) {
  const auto to_edge = [&](const core::dvec3& from, const core::dvec3& to) {
    const core::dvec3 along = to - from;
    const double square = glm::dot(along, along);
    const double t = square > 0.0 ? std::clamp(glm::dot(p - from, along) / square, 0.0, 1.0) : 0.0;
    return glm::length(p - (from + t * along));
  };
  double least = std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
  core::dvec3 normal = glm::cross(b - a, c - a);
  const double length = glm::length(normal);
  if (!(length > 0.0)) return least;
  normal /= length;
  const double height = glm::dot(p - a, normal);
  const core::dvec3 foot = p - height * normal;
  const auto left = [&](const core::dvec3& from, const core::dvec3& to) {
    return glm::dot(glm::cross(to - from, foot - from), normal) >= 0.0;
  };
  if (left(a, b) && left(b, c) && left(c, a)) least = std::min(least, std::abs(height));
  return least;
}

/// Triangles of a mesh's vertices, with boxes about runs of sixteen, so that points skip those that are farther.
class SurfaceTwin {
 public:
  SurfaceTwin(std::span<const core::vec3> positions, std::span<const std::uint32_t> corners) {
    for (const std::uint32_t corner : corners) points_.emplace_back(positions[corner]);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (i % (3 * kRun) == 0) boxes_.emplace_back();
      boxes_.back().grow(points_[i]);
    }
  }
  /// Largest magnitude of a coordinate.
  double size() const {
    double size = 0.0;
    for (const core::dvec3& p : points_) size = std::max({size, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    return size;
  }
  std::size_t triangles() const { return points_.size() / 3; }

  double distance(const core::dvec3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t run = 0; run < boxes_.size(); ++run) {
      const core::dvec3 out = glm::max(glm::max(boxes_[run].min - p, p - boxes_[run].max), core::dvec3(0.0));
      if (glm::length(out) >= least) continue;
      for (std::size_t i = 3 * kRun * run; i < std::min(points_.size(), 3 * kRun * (run + 1)); i += 3)
        least = std::min(least, distance_to_triangle(p, points_[i], points_[i + 1], points_[i + 2]));
    }
    return least;
  }

  /// A corner, a point of an edge or one inside of any triangle.
  core::dvec3 sample(MeshRandom& random) const {
    const std::size_t i = 3 * (random() % triangles());
    double u = between(random, 0, 1), v = between(random, 0, 1);
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const auto where = random() % 4;
    if (where == 0) return points_[i + random() % 3];
    if (where == 1) v = 0.0;
    return points_[i] + u * (points_[i + 1] - points_[i]) + v * (points_[i + 2] - points_[i]);
  }

  /// The largest distance of samples of this surface from another one.
  double farthest_from(const SurfaceTwin& other, int samples, MeshRandom& random) const {
    double largest = 0.0;
    for (int i = 0; i < samples; ++i) largest = std::max(largest, other.distance(sample(random)));
    return largest;
  }

 private:
  static constexpr std::size_t kRun = 16;
  std::vector<core::dvec3> points_;
  std::vector<core::AabbD> boxes_;
};

}  // namespace sightline::tests
