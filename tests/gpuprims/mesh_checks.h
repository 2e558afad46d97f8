// What every tessellation must satisfy, checked the slow way.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include "sightline/core/affine.h"
#include "sightline/core/mesh.h"
#include "sightline/core/primitive.h"

namespace sightline::tests {

using core::dvec3;

/// Indices in range, three each; everything finite; unit normals; no triangle with two corners at one position.
inline void expect_sound(const core::Mesh& mesh) {
  ASSERT_EQ(mesh.indices.size() % 3, 0u);
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    ASSERT_TRUE(core::is_finite(dvec3(mesh.positions[v]))) << "vertex " << v;
    ASSERT_NEAR(glm::length(dvec3(mesh.normals[v])), 1.0, 1e-5) << "vertex " << v;
  }
  for (const std::uint32_t i : mesh.indices) ASSERT_LT(i, mesh.positions.size());
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const core::vec3 &a = mesh.positions[mesh.indices[i]], &b = mesh.positions[mesh.indices[i + 1]],
                     &c = mesh.positions[mesh.indices[i + 2]];
    ASSERT_TRUE(a != b && b != c && c != a) << "triangle " << i / 3;
  }
}

/// Every directed edge, as a pair of positions, occurs as often as its reverse.
inline void expect_closed(const core::Mesh& mesh) {
  using Key = std::array<float, 6>;
  std::map<Key, int> edges;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const core::vec3 &a = mesh.positions[mesh.indices[i + k]], &b = mesh.positions[mesh.indices[i + (k + 1) % 3]];
      ++edges[{a.x, a.y, a.z, b.x, b.y, b.z}];
      --edges[{b.x, b.y, b.z, a.x, a.y, a.z}];
    }
  for (const auto& [key, count] : edges)
    ASSERT_EQ(count, 0) << "edge (" << key[0] << ", " << key[1] << ", " << key[2] << ") - (" << key[3] << ", " << key[4]
                        << ", " << key[5] << ")";
}

/// Volume by signed tetrahedra: positive when the winding is counter-clockwise from outside.
inline double volume(const core::Mesh& mesh) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const dvec3 a(mesh.positions[mesh.indices[i]]), b(mesh.positions[mesh.indices[i + 1]]),
        c(mesh.positions[mesh.indices[i + 2]]);
    sum += glm::dot(a, glm::cross(b, c)) / 6.0;
  }
  return sum;
}

/// Vertex normals look to the side from which their triangles are counter-clockwise. Triangles that are thin against
/// the mesh are skipped: float positions do not define their plane.
inline void expect_normals_follow_winding(const core::Mesh& mesh, double size) {
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const dvec3 a(mesh.positions[mesh.indices[i]]), b(mesh.positions[mesh.indices[i + 1]]),
        c(mesh.positions[mesh.indices[i + 2]]);
    const dvec3 normal = glm::cross(b - a, c - a);
    const double longest = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
    if (glm::length(normal) < 1e-4 * size * longest) continue;
    for (std::size_t k = 0; k < 3; ++k)
      ASSERT_GT(glm::dot(glm::normalize(normal), dvec3(mesh.normals[mesh.indices[i + k]])), -1e-4)
          << "triangle " << i / 3;
  }
}

}  // namespace sightline::tests
