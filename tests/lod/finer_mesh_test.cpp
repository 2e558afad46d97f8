// Finer meshes against the surfaces that they come from: shafts with holes, cones, balls and rings, plates, and random
// ones of which the surfaces are wrong.
#include "sightline/lod/finer_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/mesh_edges.h"
#include "sightline/core/mesh_extras.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests::finer_mesh_test {
namespace {

using core::dvec3, core::Mesh, core::MeshSurface;

constexpr double kTurn = 2.0 * std::numbers::pi;

/// A mesh that is made face by face, each with vertices of its own.
struct Body {
  Mesh mesh;
  std::vector<MeshSurface> surfaces;

  std::uint32_t add(const dvec3& p, const dvec3& normal) {
    mesh.positions.emplace_back(p);
    mesh.normals.emplace_back(glm::normalize(normal));
    return std::uint32_t(mesh.positions.size() - 1);
  }
  void end_face(MeshSurface surface) {
    surface.end_triangle = std::uint32_t(mesh.indices.size() / 3);
    surface.gap = 1e-5;
    surfaces.push_back(surface);
  }
  Mesh made() const {
    Mesh with = mesh;
    core::MeshExtras extras;
    extras.surfaces = std::make_shared<const std::vector<MeshSurface>>(surfaces);
    with.extras = core::MeshExtrasSlot(std::move(extras));
    return with;
  }
  /// A strip between two rings, which turn around z: points (radius, z), normals (across, z).
  void strip(const std::array<core::dvec2, 2>& ends, const core::dvec2& normal, int sides, MeshSurface surface) {
    const auto first = std::uint32_t(mesh.positions.size());
    for (int i = 0; i <= sides; ++i)
      for (const core::dvec2& end : ends) {
        const double a = i < sides ? kTurn * i / sides : 0.0;
        add({end.x * std::cos(a), end.x * std::sin(a), end.y},
            {normal.x * std::cos(a), normal.x * std::sin(a), normal.y});
      }
    for (std::uint32_t i = first; i < first + 2 * std::uint32_t(sides); i += 2)
      for (const std::uint32_t corner : {i, i + 2, i + 1, i + 1, i + 2, i + 3}) mesh.indices.push_back(corner);
    end_face(surface);
  }
};

MeshSurface plane(double z) {
  return {.kind = MeshSurface::Kind::kPlane, .origin = {0, 0, z}};
}

/// A pipe: a hole in a shaft.
Mesh pipe(int sides, double radius, double hole, double length) {
  Body body;
  const auto cylinder = [](double r) { return MeshSurface{.kind = MeshSurface::Kind::kCylinder, .radius = r}; };
  body.strip({{{radius, 0}, {radius, length}}}, {1, 0}, sides, cylinder(radius));
  body.strip({{{hole, length}, {hole, 0}}}, {-1, 0}, sides, cylinder(hole));
  body.strip({{{radius, length}, {hole, length}}}, {0, 1}, sides, plane(length));
  body.strip({{{hole, 0}, {radius, 0}}}, {0, -1}, sides, plane(0));
  return body.made();
}

Mesh frustum(int sides) {
  Body body;
  body.strip({{{2, 0}, {1, 4}}}, {4, 1}, sides, {.kind = MeshSurface::Kind::kCone, .radius = 2.0, .slope = -0.25});
  body.strip({{{1, 4}, {0, 4}}}, {0, 1}, sides, plane(4));
  body.strip({{{0, 0}, {2, 0}}}, {0, -1}, sides, plane(0));
  return body.made();
}

/// A surface of the grid of two angles.
Mesh grid(const MeshSurface& surface, int sides, const std::function<dvec3(double a, double b)>& point) {
  Mesh mesh = grid_mesh(std::uint32_t(2 * sides), std::uint32_t(sides),
                        [&](double u, double v) { return point(u < 1.0 ? kTurn * u : 0.0, v); });
  mesh.normals.clear();
  Body body;
  body.mesh = std::move(mesh);
  body.end_face(surface);
  return body.made();
}
Mesh ring(int sides) {
  return grid({.kind = MeshSurface::Kind::kTorus, .radius = 3.0, .tube_radius = 1.0}, sides, [](double a, double v) {
    const double b = v < 1.0 ? kTurn * v : 0.0;
    return dvec3((3 + std::cos(b)) * std::cos(a), (3 + std::cos(b)) * std::sin(a), std::sin(b));
  });
}
Mesh ball(int sides) {
  return grid({.kind = MeshSurface::Kind::kSphere, .radius = 2.0}, sides, [](double a, double v) {
    const double b = std::numbers::pi * (v - 0.5), across = v > 0.0 && v < 1.0 ? 2.0 * std::cos(b) : 0.0;
    return dvec3(across * std::cos(a), across * std::sin(a), 2.0 * std::sin(b));
  });
}

std::vector<NamedMesh> bodies() {
  return {{"pipe", pipe(12, 1.0, 0.6, 5.0)},
          {"thin pipe", pipe(24, 1.0, 0.97, 1.0)},
          {"coarse pipe", pipe(9, 1.0, 0.2, 3.0)},
          {"frustum", frustum(9)},
          {"ring", ring(12)},
          {"ball", ball(9)}};
}

/// The mean of all that lies on a mesh's triangles, and the largest distance of such points from their surfaces.
double largest_gap(const Mesh& mesh) {
  const auto surfaces = core::surfaces_stored_with(mesh);
  double gap = 0.0;
  std::uint32_t face = 0;
  for (std::uint32_t t = 0; t < mesh.indices.size() / 3; ++t) {
    while (t >= surfaces[face].end_triangle) ++face;
    const auto at = [&](std::size_t i) { return dvec3(mesh.positions[mesh.indices[3 * t + i]]); };
    constexpr int kSteps = 6;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j) {
        const double u = double(i) / kSteps, v = double(j) / kSteps;
        const dvec3 p = u * at(0) + v * at(1) + (1.0 - u - v) * at(2);
        gap = std::max(gap, glm::length(core::nearest_point(surfaces[face], p) - p));
      }
  }
  return gap;
}

double area(const Mesh& mesh) {
  double sum = 0.0;
  for (std::size_t t = 0; t + 2 < mesh.indices.size(); t += 3) {
    const auto at = [&](std::size_t i) { return dvec3(mesh.positions[mesh.indices[t + i]]); };
    sum += 0.5 * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
  }
  return sum;
}

/// All points of all triangles come within the tolerance, not only middles of sides; and corners stay exact.
TEST(FinerMesh, ComesWithinTheTolerance) {
  for (const NamedMesh& body : bodies()) {
    SCOPED_TRACE(body.name);
    ASSERT_TRUE(core::validate(body.mesh));
    const double before = lod::facet_gap(body.mesh);
    EXPECT_NEAR(before, largest_gap(body.mesh), 0.5 * before);
    for (const double tolerance : {1e-2, 1e-3, 3e-4}) {
      const auto finer = lod::finer_mesh(body.mesh, tolerance);
      if (before <= tolerance) {
        EXPECT_FALSE(finer);
        continue;
      }
      ASSERT_TRUE(finer);
      ASSERT_TRUE(core::validate(*finer));
      EXPECT_LE(lod::facet_gap(*finer), tolerance);
      EXPECT_LE(largest_gap(*finer), 2.1 * tolerance);  // in the middle of a ball's triangle both bends add
      const auto surfaces = core::surfaces_stored_with(*finer);
      ASSERT_EQ(surfaces.size(), core::surfaces_stored_with(body.mesh).size());
      EXPECT_EQ(surfaces.back().end_triangle, finer->indices.size() / 3);
      for (std::uint32_t t = 0; t < finer->indices.size() / 3; ++t) EXPECT_NE(core::surface_of(*finer, t), core::kNone);
    }
  }
}

TEST(FinerMesh, StaysClosedAndTurnsTheSameWay) {
  for (const NamedMesh& body : bodies()) {
    SCOPED_TRACE(body.name);
    const auto finer = lod::finer_mesh(body.mesh, 1e-3);
    ASSERT_TRUE(finer);
    EXPECT_EQ(core::enclosure(body.mesh), core::Enclosure::kInside);
    EXPECT_EQ(core::enclosure(*finer), core::Enclosure::kInside);
    for (std::size_t t = 0; t < finer->indices.size() && !finer->normals.empty(); t += 3) {
      const auto at = [&](std::size_t i) { return dvec3(finer->positions[finer->indices[t + i]]); };
      const dvec3 across = glm::cross(at(1) - at(0), at(2) - at(0));
      if (across == dvec3(0.0)) continue;  // at the middle of an end
      for (std::size_t i = 0; i < 3; ++i) {
        const dvec3 normal(finer->normals[finer->indices[t + i]]);
        EXPECT_NEAR(glm::length(normal), 1.0, 1e-5);
        EXPECT_GT(glm::dot(normal, across), 0.9 * glm::length(across));
      }
    }
    // The original corners are still there, in their order.
    EXPECT_TRUE(std::equal(body.mesh.positions.begin(), body.mesh.positions.end(), finer->positions.begin()));
  }
}

/// Formulas know the areas.
TEST(FinerMesh, HasTheAreaOfTheSurfaces) {
  const auto expect_area = [](const Mesh& mesh, double wanted) {
    const auto finer = lod::finer_mesh(mesh, 1e-5);
    ASSERT_TRUE(finer);
    EXPECT_NEAR(area(*finer), wanted, 1e-4 * wanted);
  };
  const double r = 1.0, hole = 0.6, length = 5.0;
  expect_area(pipe(12, r, hole, length), kTurn * (r + hole) * length + kTurn * (r * r - hole * hole));
  expect_area(ball(9), 2.0 * kTurn * 4.0);
  expect_area(ring(12), kTurn * kTurn * 3.0);
}

/// Edges of faces lie on both surfaces: as many lines as before, each on its circle.
TEST(FinerMesh, RoundsTheEdgesOfFaces) {
  const Mesh mesh = pipe(12, 1.0, 0.6, 5.0);
  const auto finer = lod::finer_mesh(mesh, 1e-4);
  ASSERT_TRUE(finer);
  const auto edges = core::edges_of(*finer);
  EXPECT_GT(edges.size(), 4 * core::edges_of(mesh).size());
  for (const core::MeshEdge& edge : edges)
    for (const std::uint32_t vertex : edge) {
      const dvec3 p(finer->positions[vertex]);
      const double across = std::hypot(p.x, p.y);
      EXPECT_LT(std::min(std::abs(across - 1.0), std::abs(across - 0.6)), 1e-6);
      EXPECT_LT(std::min(std::abs(p.z), std::abs(p.z - 5.0)), 1e-6);
    }
}

TEST(FinerMesh, LeavesWhatItCannotImprove) {
  EXPECT_FALSE(lod::finer_mesh(terrain(8, 0.5), 1e-9)) << "no surfaces";
  EXPECT_EQ(lod::facet_gap(terrain(8, 0.5)), 0.0);
  EXPECT_FALSE(lod::finer_mesh(pipe(12, 1.0, 0.6, 5.0), 1.0)) << "fine enough";
  EXPECT_FALSE(lod::finer_mesh(pipe(5, 1.0, 0.6, 5.0), 1e-3)) << "too coarse";
  EXPECT_GT(lod::facet_gap(pipe(5, 1.0, 0.6, 5.0)), 0.1);
  const Mesh body = pipe(12, 1.0, 0.6, 5.0);
  const auto bounded = lod::finer_mesh(body, 1e-6, 1000);
  ASSERT_TRUE(bounded);
  EXPECT_LE(bounded->indices.size(), 3000u);
  EXPECT_GT(lod::facet_gap(*bounded), 1e-6);
  Mesh changed = body;
  for (core::vec3& p : changed.positions) p *= 1.1f;
  EXPECT_FALSE(lod::finer_mesh(changed, 1e-3)) << "its surfaces are those of another mesh";
}

/// Surfaces of all kinds and places, to which the triangles do not belong, and coordinates that are none: nothing
/// breaks, and what was closed stays so.
TEST(FinerMesh, BearsWrongSurfaces) {
  std::mt19937_64 random(20261201);
  const auto number = [&] { return between(random, -3.0, 3.0); };
  for (int run = 0; run < 300; ++run) {
    SCOPED_TRACE(run);
    Mesh mesh = run % 2 == 0 ? pipe(3 + run % 7, 1.0, 0.6, 2.0) : bumpy_torus(4, 0.1);
    mesh.normals.clear();
    std::vector<MeshSurface> surfaces;
    const auto triangles = std::uint32_t(mesh.indices.size() / 3);
    for (std::uint32_t end = 0; end < triangles;) {
      end = std::min(triangles, end + 1 + std::uint32_t(random() % 9));
      surfaces.push_back({MeshSurface::Kind(random() % 6),
                          end,
                          {number(), number(), number()},
                          glm::normalize(dvec3(number(), number(), number())),
                          std::abs(number()),
                          std::abs(number()),
                          number(),
                          run % 3 == 0 ? 1e9 : std::abs(number())});
    }
    if (run % 10 == 9) mesh.positions[random() % mesh.positions.size()].x = std::nanf("");
    core::MeshExtras extras;
    extras.surfaces = std::make_shared<const std::vector<MeshSurface>>(surfaces);
    mesh.extras = core::MeshExtrasSlot(std::move(extras));
    const auto before = core::enclosure(mesh);
    const auto finer = lod::finer_mesh(mesh, 1e-2, 20'000);
    if (!finer) continue;
    EXPECT_TRUE(core::validate(*finer));
    EXPECT_LE(finer->indices.size(), 60'000u);
    if (before != core::Enclosure::kNothing) {
      EXPECT_NE(core::enclosure(*finer), core::Enclosure::kNothing);
    }
  }
}

}  // namespace
}  // namespace sightline::tests::finer_mesh_test
