// The distance of a point from triangles, found slowly and plainly: what proven bounds are held against.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <queue>
#include <span>
#include <vector>

#include "sightline/core/conventions.h"
#include "sightline/core/mesh.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests {

/// By the edges, and by the height above the plane where the foot of the perpendicular lies within. In double, or in
/// long double where the last digits count.
template <class Real>
Real distance_to_triangle(const glm::vec<3, Real>& p, const glm::vec<3, Real>& a, const glm::vec<3, Real>& b,
                          const glm::vec<3, Real>& c) {
  using Vector = glm::vec<3, Real>;
  const auto to_edge = [&](const Vector& from, const Vector& to) {
    const Vector along = to - from;
    const Real square = glm::dot(along, along);
    const Real t = square > Real(0) ? std::clamp(glm::dot(p - from, along) / square, Real(0), Real(1)) : Real(0);
    return glm::length(p - (from + t * along));
  };
  Real least = std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
  Vector normal = glm::cross(b - a, c - a);
  const Real length = glm::length(normal);
  if (!(length > Real(0))) return least;
  normal /= length;
  const Real height = glm::dot(p - a, normal);
  const Vector foot = p - height * normal;
  const auto left = [&](const Vector& from, const Vector& to) {
    return glm::dot(glm::cross(to - from, foot - from), normal) >= Real(0);
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

  struct Nearest {
    double distance;
    std::size_t triangle;
  };
  Nearest nearest(const core::dvec3& p) const {
    Nearest least{std::numeric_limits<double>::infinity(), 0};
    for (std::size_t run = 0; run < boxes_.size(); ++run) {
      const core::dvec3 out = glm::max(glm::max(boxes_[run].min - p, p - boxes_[run].max), core::dvec3(0.0));
      if (glm::length(out) >= least.distance) continue;
      for (std::size_t i = kRun * run; i < std::min(triangles(), kRun * (run + 1)); ++i)
        if (const double distance = distance_to(i, p); distance < least.distance) least = {distance, i};
    }
    return least;
  }
  double distance(const core::dvec3& p) const { return nearest(p).distance; }
  double distance_to(std::size_t triangle, const core::dvec3& p) const {
    const core::dvec3* const t = &points_[3 * triangle];
    return distance_to_triangle(p, t[0], t[1], t[2]);
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

  /// The largest distance of any point of this surface from another one, too large by at most that share. Divides the
  /// triangle that may reach farthest, whose points are no farther than the corner that is farthest from one triangle.
  double distance_from(const SurfaceTwin& other, double share) const {
    struct Part {
      double most;
      std::array<core::dvec3, 3> corners;
      bool operator<(const Part& part) const { return most < part.most; }
    };
    std::priority_queue<Part> parts;
    double reached = 0.0;
    const auto add = [&](const core::dvec3& a, const core::dvec3& b, const core::dvec3& c) {
      Part part{std::numeric_limits<double>::infinity(), {a, b, c}};
      for (const core::dvec3& p : {a, b, c, (a + b + c) / 3.0}) {
        const Nearest nearest = other.nearest(p);
        reached = std::max(reached, nearest.distance);
        double most = 0.0;
        for (const core::dvec3& corner : part.corners)
          most = std::max(most, other.distance_to(nearest.triangle, corner));
        part.most = std::min(part.most, most);
      }
      parts.push(part);
    };
    for (std::size_t i = 0; i < points_.size(); i += 3) add(points_[i], points_[i + 1], points_[i + 2]);
    for (int steps = 0; steps < 20000 && parts.top().most > reached * (1.0 + share); ++steps) {
      const auto [a, b, c] = parts.top().corners;
      parts.pop();
      const core::dvec3 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
      add(a, ab, ca), add(ab, b, bc), add(ca, bc, c), add(ab, bc, ca);
    }
    return parts.top().most;
  }

 private:
  static constexpr std::size_t kRun = 16;
  std::vector<core::dvec3> points_;
  std::vector<core::AabbD> boxes_;
};

}  // namespace sightline::tests
