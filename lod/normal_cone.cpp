#include "sightline/lod/internal/normal_cone.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace sightline::lod {
namespace {

using core::dvec3;

// Of the cross product of two edges, relative to the product of their lengths: each edge is rounded once, and so are
// two products and their difference.
constexpr double kRounding = 2e-15;
constexpr int kSteps = 20;  // towards the axis: the cone is then about a tenth wider than it must be

struct Normal {
  dvec3 unit;
  double rounding;  // the true one lies within so many radians
};
struct Normals {
  std::array<Normal, kClusterTriangles> all;
  std::size_t count = 0;
  std::span<const Normal> list() const { return std::span(all).first(count); }
};

/// Of all triangles but those that are thinner than kThin.
Normals normals_of(std::span<const core::vec3> positions, std::span<const std::uint32_t> corners) {
  assert(corners.size() <= 3 * kClusterTriangles);
  Normals normals;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    const dvec3 a(positions[corners[i]]), u = dvec3(positions[corners[i + 1]]) - a;
    const dvec3 v = dvec3(positions[corners[i + 2]]) - a, normal = glm::cross(u, v);
    const double area = glm::length(normal), most = glm::length(u) * glm::length(v);
    if (area > NormalCone::kThin * most)
      normals.all[normals.count++] = {normal / area, kRounding * (most / area + 1.0)};
  }
  return normals;
}

/// Near the centre of the smallest ball about the unit normals, which has the direction of the narrowest cone's axis
/// (M. Badoiu, K. Clarkson, "Smaller core-sets for balls", 2003).
dvec3 middle(std::span<const Normal> normals) {
  dvec3 centre(0.0);
  for (const Normal& normal : normals) centre += normal.unit / double(normals.size());
  for (int step = 2; step < 2 + kSteps; ++step) {
    const auto& farthest = *std::ranges::min_element(
        normals, {}, [&](const Normal& n) { return glm::dot(n.unit, centre); });  // all lie on the unit sphere
    centre += (farthest.unit - centre) / double(step + 1);
  }
  return centre;
}

}  // namespace

NormalCone cone_of(std::span<const core::vec3> positions, std::span<const std::uint32_t> corners) {
  const Normals normals = normals_of(positions, corners);
  const dvec3 centre = normals.count > 0 ? middle(normals.list()) : dvec3(0.0);
  const double length = glm::length(centre);
  if (!(length > 1e-3)) return {};
  NormalCone cone{core::vec3(centre / length), 0.0f};
  const dvec3 axis = glm::normalize(dvec3(cone.axis));  // of the rounded one
  double sine = 0.0;
  for (const Normal& normal : normals.list()) {
    if (!(glm::dot(axis, normal.unit) > normal.rounding)) return {};
    sine = std::max(sine, glm::length(glm::cross(axis, normal.unit)) + normal.rounding);
  }
  if (!(sine < 1.0)) return {};
  cone.spread = core::round_up(sine);
  return cone;
}

}  // namespace sightline::lod
