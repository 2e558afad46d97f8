#include "sightline/lod/internal/normal_cone.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace sightline::lod {
namespace {

using core::dvec3;

// The error of the cross product of two edges, relative to the product of their lengths: each edge is rounded once, and
// so are two products and their difference.
constexpr double kNormalRounding = 2e-15;
constexpr int kSteps = 10;  // towards the axis: the cone is then about a tenth wider than it must be

struct Normal {
  dvec3 unit;
  double rounding;  // the true one lies within so many radians
};
struct Normals {
  std::array<Normal, kClusterTriangles> all;
  std::size_t count = 0;
  std::span<const Normal> list() const { return std::span(all).first(count); }
};

/// Normals of all triangles but those that are thinner than kThin.
Normals normals_of(std::span<const core::vec3> positions, std::span<const std::uint32_t> corners) {
  assert(corners.size() <= 3 * kClusterTriangles);
  Normals normals;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    const dvec3 a(positions[corners[i]]), u = dvec3(positions[corners[i + 1]]) - a;
    const dvec3 v = dvec3(positions[corners[i + 2]]) - a, normal = glm::cross(u, v);
    const double area = glm::length(normal), most = std::sqrt(glm::dot(u, u) * glm::dot(v, v));
    if (!(area > NormalCone::kThin * most)) continue;
    const double inverse = 1.0 / area;
    normals.all[normals.count++] = {inverse * normal, kNormalRounding * (most * inverse + 1.0)};
  }
  return normals;
}

/// Near the centre of the smallest ball about the unit normals, which has the direction of the narrowest cone's axis
/// (M. Badoiu, K. Clarkson, "Smaller core-sets for balls", 2003). All lie on the unit sphere, so the farthest one has
/// the least product with the centre.
core::vec3 middle(std::span<const Normal> normals) {
  float x[kClusterTriangles], y[kClusterTriangles], z[kClusterTriangles], along[kClusterTriangles];
  core::vec3 centre(0.0f);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const core::vec3 unit(normals[i].unit);
    x[i] = unit.x, y[i] = unit.y, z[i] = unit.z;
    centre += unit / float(normals.size());
  }
  for (int step = 3; step < 3 + kSteps; ++step) {
    for (std::size_t i = 0; i < normals.size(); ++i) along[i] = x[i] * centre.x + y[i] * centre.y + z[i] * centre.z;
    const auto farthest = std::min_element(along, along + normals.size()) - along;
    centre += (core::vec3(x[farthest], y[farthest], z[farthest]) - centre) / float(step);
  }
  return centre;
}

}  // namespace

NormalCone cone_of(std::span<const core::vec3> positions, std::span<const std::uint32_t> corners) {
  const Normals normals = normals_of(positions, corners);
  const core::vec3 centre = normals.count > 0 ? middle(normals.list()) : core::vec3(0.0f);
  const float length = glm::length(centre);
  if (!(length > 1e-3f)) return {};
  NormalCone cone{centre / length, 0.0f};
  const dvec3 axis = glm::normalize(dvec3(cone.axis));  // of the rounded one
  double square = 0.0, rounding = 0.0;
  for (const Normal& normal : normals.list()) {
    if (!(glm::dot(axis, normal.unit) > normal.rounding)) return {};
    const dvec3 across = glm::cross(axis, normal.unit);
    square = std::max(square, glm::dot(across, across)), rounding = std::max(rounding, normal.rounding);
  }
  const double sine = std::sqrt(square) + rounding;
  if (!(sine < 1.0)) return {};
  cone.spread = core::round_up(sine);
  return cone;
}

}  // namespace sightline::lod
