#include "sightline/importers/internal/tessellated.h"

#include <algorithm>
#include <cmath>

namespace sightline::importers {
namespace {

using core::dmat3;
using core::dvec3;

/// Height of the arc over an edge whose ends have these unit normals. Only the part of the edge along the difference of
/// the normals is bent: a cylinder's rulings do not count.
double arc_height(const dvec3& edge, const dvec3& from, const dvec3& to) {
  const dvec3 turn = to - from;
  const double sine = 0.5 * glm::length(turn);  // of half the angle between them
  if (sine < 1e-9) return 0.0;
  const double bent = std::abs(glm::dot(edge, turn)) / (2.0 * sine);
  return 0.5 * bent * std::tan(0.5 * std::asin(std::min(1.0, sine)));
}

}  // namespace

double largest_scale(const dmat3& linear) {
  const dmat3 gram = glm::transpose(linear) * linear;
  double most = 0.0;
  for (int i = 0; i < 3; ++i) most = std::max(most, std::abs(gram[i].x) + std::abs(gram[i].y) + std::abs(gram[i].z));
  return std::sqrt(most);
}

double chord_error(const core::Mesh& mesh) {
  double most = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::uint32_t a = mesh.indices[i], b = mesh.indices[i % 3 == 2 ? i - 2 : i + 1];
    most = std::max(most, arc_height(dvec3(mesh.positions[b]) - dvec3(mesh.positions[a]), dvec3(mesh.normals[a]),
                                     dvec3(mesh.normals[b])));
  }
  return most;
}

dmat3 normal_map(const dmat3& m) {
  const dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  return glm::dot(m[0], cofactors[0]) < 0.0 ? -cofactors : cofactors;
}

}  // namespace sightline::importers
