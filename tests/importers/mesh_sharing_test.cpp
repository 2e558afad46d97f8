#include "sightline/importers/internal/mesh_sharing.h"

#include <cmath>
#include <limits>
#include <random>

#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

namespace sightline::importers::mesh_sharing_test {
namespace {

using core::Affine;
using core::dvec3;
using core::Mesh;
using core::vec3;

/// Random triangles over random vertices.
Mesh random_mesh(std::mt19937& random, std::uint32_t vertices, double size) {
  std::uniform_real_distribution<double> place(-size, size);
  std::uniform_int_distribution<std::uint32_t> vertex(0, vertices - 1);
  Mesh mesh;
  for (std::uint32_t i = 0; i < vertices; ++i)
    mesh.positions.emplace_back(dvec3(place(random), place(random), place(random)));
  for (std::uint32_t i = 0; i < 3 * vertices; ++i) mesh.indices.push_back(vertex(random));
  return mesh;
}

Mesh box_mesh(const dvec3& half) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.emplace_back(half * dvec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  mesh.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                  2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return mesh;
}

Affine random_similarity(std::mt19937& random, double reach) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> exponent(-2.0, 2.0), place(-reach, reach);
  const glm::dquat turn = glm::normalize(glm::dquat(normal(random), normal(random), normal(random), normal(random)));
  return {std::pow(10.0, exponent(random)) * glm::mat3_cast(turn), {place(random), place(random), place(random)}};
}

/// What a file would hold: vertices moved in double, then rounded.
Mesh moved(const Mesh& mesh, const Affine& map) {
  Mesh copy = mesh;
  for (vec3& p : copy.positions) p = vec3(core::transform_point(map, dvec3(p)));
  const core::dmat3 turn = map.linear / std::cbrt(glm::determinant(map.linear));
  for (vec3& n : copy.normals) n = vec3(turn * dvec3(n));
  return copy;
}

double largest_coordinate(const Mesh& mesh) {
  float largest = 0.0f;
  for (const vec3& p : mesh.positions) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return double(largest);
}

TEST(MeshSharing, FindsCopiesUnderSimilarities) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    core::Scene scene;
    MeshSharing sharing(scene);
    Mesh mesh = seed % 2 ? box_mesh({1.0 + 0.01 * seed, 0.5, 0.2}) : random_mesh(random, 4 + seed, 1.0);
    if (seed % 3 == 0)
      for (const vec3& p : mesh.positions) mesh.normals.push_back(glm::normalize(p + vec3(1e-3f)));
    const auto original = sharing.add(mesh).value();
    EXPECT_FALSE(original.shared);
    for (int copy = 0; copy < 5; ++copy) {
      // Importers centre meshes: a copy lies within a few sizes of the origin.
      Affine map = random_similarity(random, 0.0);
      map.origin = std::cbrt(glm::determinant(map.linear)) * dvec3(1.0, -0.5, 0.25);
      const Mesh there = moved(mesh, map);
      const auto use = sharing.add(there).value();
      ASSERT_TRUE(use.shared);
      EXPECT_EQ(use.mesh, original.mesh);
      double worst = 0.0;
      for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        worst = std::max(worst, glm::distance(core::transform_point(use.added_from_mesh, dvec3(mesh.positions[i])),
                                              dvec3(there.positions[i])));
      EXPECT_LE(worst, 1e-6 * largest_coordinate(there));
      EXPECT_NEAR(worst, use.error, 1e-12 * largest_coordinate(there));
    }
    EXPECT_EQ(scene.mesh_slots(), 1u);
  }
}

TEST(MeshSharing, KeepsApartWhatDiffers) {
  std::mt19937 random(1);
  const Mesh mesh = random_mesh(random, 50, 1.0);
  const auto found = [&](const Mesh& other) {
    core::Scene scene;
    MeshSharing sharing(scene);
    sharing.add(mesh).value();
    const auto use = sharing.add(other).value();
    EXPECT_EQ(scene.mesh_slots(), use.shared ? 1u : 2u);
    return use.shared;
  };
  EXPECT_TRUE(found(mesh));
  Mesh other = mesh;
  other.positions[17].x += 1e-4f;
  EXPECT_FALSE(found(other)) << "one vertex moved";
  other = mesh;
  std::swap(other.indices[3], other.indices[4]);
  EXPECT_FALSE(found(other)) << "another triangle";
  other = mesh;
  for (vec3& p : other.positions) p.x = -p.x;
  EXPECT_FALSE(found(other)) << "mirrored";
  other = moved(mesh, {core::dmat3(1.0, 0.0, 0.0, 0.0, 1.001, 0.0, 0.0, 0.0, 1.0), {}});
  EXPECT_FALSE(found(other)) << "stretched along one axis";
  other = mesh;
  other.normals.assign(mesh.positions.size(), {0, 0, 1});
  EXPECT_FALSE(found(other)) << "with normals";
  other = mesh;
  other.contour_sizes = {50};
  other.polygon_contours = {1};
  EXPECT_FALSE(found(other)) << "other polygons";
}

TEST(MeshSharing, KeepsApartWhatIsShadedDifferently) {
  std::mt19937 random(2);
  Mesh mesh = random_mesh(random, 20, 1.0);
  for (const vec3& p : mesh.positions) mesh.normals.push_back(glm::normalize(p));
  const Mesh there = moved(mesh, core::translation({3.0, 1.0, 2.0}));
  const auto found = [&](float off) {
    core::Scene scene;
    MeshSharing sharing(scene);
    sharing.add(mesh).value();
    Mesh other = there;
    other.normals[7] += off * vec3(other.normals[7].y, -other.normals[7].x, 0.0f);
    return sharing.add(other).value().shared;
  };
  EXPECT_TRUE(found(0.0f));
  EXPECT_TRUE(found(0.5e-3f));
  for (const float off : {3e-3f, 1e-2f, 0.1f, 1.0f, std::numeric_limits<float>::quiet_NaN()})
    EXPECT_FALSE(found(off)) << off;
}

/// What is only moved has a placement without a turn, to the bit, and says how far off its vertices are.
TEST(MeshSharing, AMovedCopyIsNotTurned) {
  std::mt19937 random(3);
  for (int round = 0; round < 50; ++round) {
    core::Scene scene;
    MeshSharing sharing(scene);
    const Mesh mesh = random_mesh(random, 10, 1.0);
    sharing.add(mesh).value();
    const Mesh there = moved(mesh, core::translation({0.1 + round, 0.2, -0.3}));
    const auto use = sharing.add(there).value();
    ASSERT_TRUE(use.shared);
    EXPECT_EQ(use.added_from_mesh.linear, core::dmat3(1.0));
    double worst = 0.0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
      worst = std::max(worst, glm::distance(core::transform_point(use.added_from_mesh, dvec3(mesh.positions[i])),
                                            dvec3(there.positions[i])));
    EXPECT_GT(worst, 0.0);
    EXPECT_NEAR(use.error, worst, 1e-15);
  }
}

TEST(MeshSharing, ExactCopiesAlone) {
  core::Scene scene;
  MeshSharing sharing(scene, MeshCopies::kExact);
  const Mesh box = box_mesh({1, 2, 3});
  sharing.add(box).value();
  EXPECT_TRUE(sharing.add(box).value().shared);
  EXPECT_FALSE(sharing.add(moved(box, core::translation({1.0, 0.0, 0.0}))).value().shared);
}

TEST(MeshSharing, TakesMeshesWithoutExtent) {
  core::Scene scene;
  MeshSharing sharing(scene);
  const auto add = [&](std::vector<vec3> positions) {
    Mesh mesh;
    for (std::size_t i = 0; i + 2 < positions.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) mesh.indices.push_back(std::uint32_t(i + k));
    mesh.positions = std::move(positions);
    return sharing.add(std::move(mesh)).value();
  };
  EXPECT_FALSE(add({}).shared);
  EXPECT_TRUE(add({}).shared);
  EXPECT_FALSE(add({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}).shared);
  EXPECT_TRUE(add({{2, 1, 1}, {2, 1, 1}, {2, 1, 1}}).shared) << "moved point";
  EXPECT_FALSE(add({{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {4, 0, 0}}).shared);
  EXPECT_TRUE(add({{0, 1, 0}, {1, 1, 0}, {3, 1, 0}, {4, 1, 0}}).shared) << "moved line";
  EXPECT_FALSE(add({{0, 0, 0}, {0, 1, 0}, {0, 3, 0}, {0, 4, 0}}).shared) << "a turned line has no axes";
}

/// The placement that maps one to the other could not be committed.
TEST(MeshSharing, KeepsApartWhatDiffersByMoreThanAnySite) {
  core::Scene scene;
  MeshSharing sharing(scene);
  const Mesh tiny = box_mesh(dvec3(1e-20, 2e-20, 3e-20));
  EXPECT_FALSE(sharing.add(tiny).value().shared);
  EXPECT_FALSE(sharing.add(moved(tiny, {core::dmat3(1e38), {}})).value().shared);
  EXPECT_TRUE(sharing.add(moved(tiny, {core::dmat3(1e5), {}})).value().shared);
}

/// Thousands of meshes of one topology: each is looked up by its shape, not compared with all others.
TEST(MeshSharing, TellsManyBoxesApart) {
  core::Scene scene;
  MeshSharing sharing(scene);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> side(0.1, 1.0);
  std::vector<dvec3> halves;
  for (int i = 0; i < 3000; ++i) halves.emplace_back(side(random), side(random), side(random));
  for (const dvec3& half : halves) sharing.add(box_mesh(half)).value();
  const std::size_t kinds = scene.mesh_slots();
  EXPECT_GE(kinds, 2990u);
  std::size_t shared = 0;
  for (const dvec3& half : halves)
    shared += sharing.add(moved(box_mesh(half), random_similarity(random, 1.0))).value().shared;
  EXPECT_GE(shared, 2990u);
}

}  // namespace
}  // namespace sightline::importers::mesh_sharing_test
