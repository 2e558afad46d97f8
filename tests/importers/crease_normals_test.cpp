// Normals for meshes without any, beside a slower twin that walks around each corner.
#include "sightline/importers/internal/crease_normals.h"

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/importers/import.h"

namespace sightline::importers::crease_normals_test {
namespace {

using core::dvec3;
using core::Mesh;

constexpr double kDegree = std::numbers::pi / 180.0;

/// Welds a mesh that was made with vertices of its own for each normal.
Mesh without_normals(Mesh mesh) {
  mesh.normals.clear();
  return mesh;
}

dvec3 corner(const Mesh& mesh, std::size_t i) {
  return dvec3(mesh.positions[mesh.indices[i]]);
}

dvec3 face_normal(const Mesh& mesh, std::size_t face) {
  const dvec3 a = corner(mesh, 3 * face);
  const dvec3 across = glm::cross(corner(mesh, 3 * face + 1) - a, corner(mesh, 3 * face + 2) - a);
  return glm::length(across) > 0.0 ? glm::normalize(across) : dvec3(0.0);
}

/// Whether two faces share the edge between two places.
bool share_edge(const Mesh& mesh, std::size_t a, std::size_t b, const dvec3& at) {
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const dvec3 p = corner(mesh, 3 * a + std::size_t(i));
      if (p != at && p == corner(mesh, 3 * b + std::size_t(k))) return true;
    }
  return false;
}

/// The normal at a corner: walks from face to face around its place over edges that are no creases.
dvec3 twin_normal(const Mesh& mesh, std::size_t at, double angle) {
  const dvec3 place = corner(mesh, at);
  std::vector<std::size_t> corners;
  for (std::size_t i = 0; i < mesh.indices.size(); ++i)
    if (corner(mesh, i) == place) corners.push_back(i);
  std::set<std::size_t> reached{at};
  std::vector<std::size_t> open{at};
  dvec3 sum(0.0);
  while (!open.empty()) {
    const std::size_t from = open.back();
    open.pop_back();
    const dvec3 n = face_normal(mesh, from / 3);
    const dvec3 a = corner(mesh, from - from % 3 + (from + 1) % 3) - place,
                b = corner(mesh, from - from % 3 + (from + 2) % 3) - place;
    if (glm::length(a) > 0.0 && glm::length(b) > 0.0)
      sum += n * std::acos(glm::clamp(glm::dot(a, b) / (glm::length(a) * glm::length(b)), -1.0, 1.0));
    for (const std::size_t to : corners)
      if (!reached.contains(to) && share_edge(mesh, from / 3, to / 3, place) &&
          glm::dot(n, face_normal(mesh, to / 3)) >= std::cos(angle)) {
        reached.insert(to);
        open.push_back(to);
      }
  }
  return glm::length(sum) > 0.0 ? glm::normalize(sum) : dvec3(0.0);
}

/// Corners lie where they lay, and each place has one vertex for each normal.
void expect_same_surface(const Mesh& before, const Mesh& after) {
  ASSERT_EQ(after.indices.size(), before.indices.size());
  ASSERT_EQ(after.normals.size(), after.positions.size());
  for (std::size_t i = 0; i < before.indices.size(); ++i) ASSERT_EQ(corner(after, i), corner(before, i));
  ASSERT_TRUE(core::validate(after));
}

TEST(CreaseNormals, OfABoxAreThoseOfItsFaces) {
  const Mesh before = without_normals(gpuprims::tessellate(core::Box{2, 3, 4}));
  Mesh mesh = before;
  add_crease_normals(mesh, 30.0 * kDegree);
  expect_same_surface(before, mesh);
  EXPECT_EQ(mesh.positions.size(), 24u);
  for (std::size_t i = 0; i < mesh.indices.size(); ++i)
    EXPECT_LT(glm::length(dvec3(mesh.normals[mesh.indices[i]]) - face_normal(before, i / 3)), 1e-6);
  Mesh round = before;
  add_crease_normals(round, std::numbers::pi);
  EXPECT_EQ(round.positions.size(), 8u) << "no edge is a crease";
}

TEST(CreaseNormals, OfABallPointOutwards) {
  const Mesh before = without_normals(gpuprims::tessellate(core::Sphere{2.0f}, {.fixed_segments = 32}));
  Mesh mesh = before;
  add_crease_normals(mesh, 30.0 * kDegree);
  expect_same_surface(before, mesh);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    EXPECT_GT(glm::dot(mesh.normals[i], glm::normalize(mesh.positions[i])), 0.999f) << i;
}

/// A prism of twelve sides, whose edges are bent by just the angle, is a cylinder.
TEST(CreaseNormals, AnglesThatAreJustMetAreSmooth) {
  const Mesh before = without_normals(gpuprims::tessellate(core::Cylinder{1.0f, 3.0f}, {.fixed_segments = 12}));
  for (const double degrees : {30.0, 29.0}) {
    Mesh mesh = before;
    add_crease_normals(mesh, degrees * kDegree);
    expect_same_surface(before, mesh);
    int bent = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); ++i)
      bent += glm::dot(dvec3(mesh.normals[mesh.indices[i]]), face_normal(before, i / 3)) < 0.999;
    EXPECT_EQ(bent > 0, degrees == 30.0) << bent;
    EXPECT_EQ(mesh.positions.size(), degrees == 30.0 ? 48u : 72u);
  }
}

/// A bumpy field, with holes, faces that face the other way, doubled faces, and faces without area.
Mesh random_mesh(std::mt19937& random) {
  const auto uniform = [&](float low, float high) { return std::uniform_real_distribution(low, high)(random); };
  constexpr int kSide = 7;
  Mesh mesh;
  const float bump = uniform(0.0f, 0.8f);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) mesh.positions.emplace_back(x, y, uniform(-bump, bump));
  mesh.positions.push_back(mesh.positions[8]);  // a place with two vertices
  for (std::uint32_t y = 0; y + 1 < kSide; ++y)
    for (std::uint32_t x = 0; x + 1 < kSide; ++x)
      for (int half = 0; half < 2; ++half) {
        const std::uint32_t a = y * kSide + x, b = a + 1, c = a + kSide, d = c + 1;
        std::uint32_t face[3] = {half ? b : a, half ? d : b, c};
        for (std::uint32_t& vertex : face)
          if (vertex == 8 && uniform(0, 1) < 0.5f) vertex = kSide * kSide;
        const float what = uniform(0, 1);
        if (what < 0.05f) continue;
        if (what < 0.1f) std::swap(face[0], face[1]);
        if (what > 0.97f) face[1] = face[0];
        for (int times = what > 0.1f && what < 0.13f ? 2 : 1; times > 0; --times)
          mesh.indices.insert(mesh.indices.end(), face, face + 3);
      }
  return mesh;
}

TEST(CreaseNormals, AreThoseOfTheTwin) {
  std::mt19937 random(5);
  for (int i = 0; i < 60; ++i) {
    const double angle = std::uniform_real_distribution(5.0, 90.0)(random) * kDegree;
    SCOPED_TRACE("case " + std::to_string(i) + " of seed 5");
    const Mesh before = random_mesh(random);
    Mesh mesh = before;
    add_crease_normals(mesh, angle);
    expect_same_surface(before, mesh);
    for (std::size_t k = 0; k < mesh.indices.size(); ++k) {
      const dvec3 found(mesh.normals[mesh.indices[k]]);
      // An edge bent by nearly the angle may be on either side of it.
      const bool same = glm::length(found - twin_normal(before, k, angle)) < 1e-5 ||
                        glm::length(found - twin_normal(before, k, angle + 2e-3)) < 1e-5;
      ASSERT_TRUE(same) << "corner " << k;
    }
  }
}

TEST(CreaseNormals, ManyFacesAtOneEdgeTakeNoLonger) {
  Mesh fan;
  fan.positions = {{0, 0, 0}, {0, 0, 1}};
  for (std::uint32_t i = 0; i < 200'000; ++i) {
    fan.positions.emplace_back(std::cos(float(i)), std::sin(float(i)), 0.0f);
    fan.indices.insert(fan.indices.end(), {0, 1, i + 2});
  }
  add_crease_normals(fan, 1.0);
  EXPECT_EQ(fan.normals.size(), fan.positions.size());
}

TEST(CreaseNormals, AreMadeByImportsThatAskForThem) {
  const std::string file = testing::TempDir() + "crease_normals.obj";
  std::ofstream(file) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.1\nf 1 2 3\nf 2 4 3\n";
  for (const double angle : {0.0, 0.5}) {
    core::Scene scene;
    ImportOptions options;
    options.crease_angle = angle;
    ASSERT_TRUE(import_file(file, scene, scene.root(), options));
    const Mesh& mesh = scene.mesh(core::MeshId{0});
    EXPECT_EQ(mesh.normals.size(), angle > 0.0 ? 4u : 0u);
  }
  core::Scene scene;
  ImportOptions options;
  options.crease_angle = 4.0;
  EXPECT_FALSE(import_file(file, scene, scene.root(), options));
}

}  // namespace
}  // namespace sightline::importers::crease_normals_test
