// Edges of meshes: of shapes whose edges are known, and of random ones against a search of all pairs of triangles.
#include "sightline/core/mesh_edges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "sightline/core/mesh_extras.h"
#include "sightline/core/primitive.h"

namespace sightline::core::mesh_edges_test {
namespace {

/// A prism around z with `sides` sides, each vertex once, and triangles of its sides, bottom and top.
Mesh prism(std::uint32_t sides, bool smooth) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < sides; ++i) {
    const double t = kFullTurn * i / sides;
    for (const float z : {0.0f, 1.0f}) {
      mesh.positions.emplace_back(std::cos(t), std::sin(t), z);
      if (smooth) mesh.normals.emplace_back(std::cos(t), std::sin(t), 0.0);
    }
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % sides);
    mesh.indices.insert(mesh.indices.end(), {a, b, b + 1, a, b + 1, a + 1});
  }
  return mesh;
}

std::size_t count(const Mesh& mesh, MeshEdges which = MeshEdges::kFeature) {
  return edges_of(mesh, which).size();
}

TEST(MeshEdges, OfPrisms) {
  EXPECT_EQ(count(prism(4, false)), 4u + 8u);               // uprights, and the borders of both ends
  EXPECT_EQ(count(prism(24, false)), 48u);                  // bent by 15 degrees: borders alone
  EXPECT_EQ(count(prism(8, false)), 8u + 16u);              // bent by 45 degrees
  EXPECT_EQ(count(prism(8, true)), 16u);                    // normals run on
  EXPECT_EQ(count(prism(6, true)), 12u);                    // 60 degrees
  EXPECT_EQ(count(prism(4, true)), 4u + 8u);                // normals cannot excuse so much
  EXPECT_EQ(count(prism(5, false), MeshEdges::kAll), 20u);  // five uprights, five diagonals, ten at the ends
}

TEST(MeshEdges, OfVerticesThatAreDoubled) {
  Mesh mesh = prism(8, true);
  Mesh doubled;
  for (const std::uint32_t index : mesh.indices) {
    doubled.indices.push_back(std::uint32_t(doubled.positions.size()));
    doubled.positions.push_back(mesh.positions[index]);
    doubled.normals.push_back(mesh.normals[index]);
  }
  EXPECT_EQ(count(doubled), count(mesh));
  for (std::size_t i = 0; i < doubled.normals.size(); ++i)  // as flat shading has them
    doubled.normals[i] = glm::normalize(glm::cross(doubled.positions[i / 3 * 3 + 1] - doubled.positions[i / 3 * 3],
                                                   doubled.positions[i / 3 * 3 + 2] - doubled.positions[i / 3 * 3]));
  EXPECT_EQ(count(doubled), 8u + 16u);
}

TEST(MeshEdges, OfSheets) {
  Mesh sheet{"", {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {}, {0, 1, 2, 0, 2, 3}, {}, {}};
  EXPECT_EQ(count(sheet), 4u);
  Mesh both = sheet;  // with a back
  both.indices.insert(both.indices.end(), {2, 1, 0, 3, 2, 0});
  EXPECT_EQ(count(both), 4u);
  Mesh turned = sheet;  // one triangle the other way round
  std::swap(turned.indices[4], turned.indices[5]);
  EXPECT_EQ(count(turned), 4u);
  Mesh tee = sheet;  // a third sheet on the diagonal
  tee.positions.emplace_back(0, 0, 1);
  tee.indices.insert(tee.indices.end(), {0, 2, 4});
  EXPECT_EQ(count(tee), 4u + 1u + 2u);
}

TEST(MeshEdges, OfFaces) {
  MeshExtras extras;
  // Faces of an octagonal rod: two halves, which meet at a seam on either side.
  extras.surfaces = std::make_shared<std::vector<MeshSurface>>(2);
  Mesh rod = prism(8, true);
  std::vector<MeshSurface> faces(2);
  faces[0].end_triangle = 8, faces[1].end_triangle = 16;
  extras.surfaces = std::make_shared<const std::vector<MeshSurface>>(faces);
  rod.extras = MeshExtrasSlot(extras);
  EXPECT_EQ(count(rod), 16u);  // seams are smooth
  rod.normals.clear();
  EXPECT_EQ(count(rod), 16u + 2u);  // and inside of a face nothing is an edge
}

TEST(MeshEdges, LeaveOutWhatHasNoLength) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Mesh mesh{"", {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {0, 1, 0}, {nan, 0, 0}}, {}, {0, 1, 2, 0, 1, 3, 1, 4, 3}, {},
                  {}};
  for (const MeshEdge& edge : edges_of(mesh, MeshEdges::kAll)) {
    EXPECT_NE(mesh.positions[edge[0]], mesh.positions[edge[1]]);
    EXPECT_LT(edge[0], edge[1]);
    EXPECT_NE(edge[1], 4u);
  }
  EXPECT_EQ(count(mesh, MeshEdges::kAll), 3u);
  EXPECT_EQ(count(Mesh()), 0u);
}

/// By comparing every triangle with every other one.
std::set<std::pair<std::uint32_t, std::uint32_t>> creases_of(const Mesh& mesh) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> found;
  const auto normal = [&](std::size_t t) {
    const auto at = [&](std::size_t i) { return dvec3(mesh.positions[mesh.indices[3 * t + i]]); };
    return glm::normalize(glm::cross(at(1) - at(0), at(2) - at(0)));
  };
  for (std::size_t t = 0; t < mesh.indices.size() / 3; ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = mesh.indices[3 * t + i], b = mesh.indices[3 * t + (i + 1) % 3];
      double sharpest = -1.0;
      bool alone = true;
      for (std::size_t other = 0; other < mesh.indices.size() / 3; ++other)
        for (std::size_t j = 0; j < 3; ++j)
          if (mesh.indices[3 * other + j] == b && mesh.indices[3 * other + (j + 1) % 3] == a) {
            alone = false;
            sharpest = std::max(sharpest, std::acos(std::clamp(glm::dot(normal(t), normal(other)), -1.0, 1.0)));
          }
      if (alone || sharpest > kCreaseAngle) found.insert(std::minmax(a, b));
    }
  return found;
}

TEST(MeshEdges, OfHillsAreThoseOfAllPairs) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> height(0.0f, 1.2f);
    Mesh hills;
    constexpr std::uint32_t kSide = 9;
    for (std::uint32_t i = 0; i < kSide * kSide; ++i)
      hills.positions.emplace_back(i % kSide, i / kSide, height(random));
    for (std::uint32_t y = 0; y + 1 < kSide; ++y)
      for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
        const std::uint32_t a = y * kSide + x;
        hills.indices.insert(hills.indices.end(), {a, a + 1, a + kSide + 1, a, a + kSide + 1, a + kSide});
      }
    std::set<std::pair<std::uint32_t, std::uint32_t>> found;
    for (const MeshEdge& edge : edges_of(hills)) found.emplace(edge[0], edge[1]);
    EXPECT_EQ(found, creases_of(hills));
    EXPECT_GT(found.size(), 4u * (kSide - 1));
  }
}

}  // namespace
}  // namespace sightline::core::mesh_edges_test
