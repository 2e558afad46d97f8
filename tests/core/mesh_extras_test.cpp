// Surfaces that come with meshes: nearest points, against many points of the surface, and which triangles have one.
#include "sightline/core/mesh_extras.h"

#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "sightline/tests/core/primitive_samples.h"

namespace sightline::tests::mesh_extras_test {
namespace {

using core::dvec3;
using core::MeshSurface;
using Kind = MeshSurface::Kind;

constexpr std::uint64_t kSeed = 57;

/// A point of a surface by two parameters: the first an angle about the axis.
dvec3 point_at(const MeshSurface& s, const core::dmat3& frame, double t, double v) {
  const dvec3 out = std::cos(t) * frame[0] + std::sin(t) * frame[1];
  switch (s.kind) {
    case Kind::kPlane:
      return s.origin + v * out;
    case Kind::kCylinder:
      return s.origin + s.radius * out + v * s.axis;
    case Kind::kCone:
      return s.origin + std::max(0.0, s.radius + s.slope * v) * out +
             (s.radius + s.slope * v < 0.0 ? -s.radius / s.slope : v) * s.axis;
    case Kind::kSphere:
      return s.origin + s.radius * (std::cos(v) * out + std::sin(v) * s.axis);
    case Kind::kTorus:
      return s.origin + (s.radius + s.tube_radius * std::cos(v)) * out + s.tube_radius * std::sin(v) * s.axis;
    default:
      return s.origin;
  }
}

TEST(MeshExtras, NearestPointsAreThoseOfManyPoints) {
  Random random(kSeed);
  for (int i = 0; i < 50; ++i) {
    const core::dmat3 frame = random_rotation(random);
    MeshSurface s;
    s.kind = Kind(1 + i % 5);
    s.origin = 3.0 * random_direction(random), s.axis = frame[2];
    s.radius = uniform(random, 0.5, 2.0), s.tube_radius = uniform(random, 0.1, 0.4), s.slope = uniform(random, -1, 1);
    const dvec3 p = s.origin + uniform(random, 0.0, 3.0) * random_direction(random);
    const dvec3 found = core::nearest_point(s, p);
    double least = 1e300, off = 1e300;
    constexpr int kSteps = 600;
    for (int a = 0; a < kSteps; ++a)
      for (int b = 0; b <= kSteps; ++b) {
        const double v =
            s.kind == Kind::kSphere || s.kind == Kind::kTorus ? core::kFullTurn * b / kSteps : 12.0 * b / kSteps - 6.0;
        const dvec3 q = point_at(s, frame, core::kFullTurn * a / kSteps, v);
        least = std::min(least, glm::length(q - p)), off = std::min(off, glm::length(q - found));
      }
    EXPECT_LE(glm::length(found - p), least + 1e-12) << "seed " << kSeed << ": " << i;
    EXPECT_LE(off, 0.05) << "seed " << kSeed << ": " << i << ": it lies on the surface";
    EXPECT_LE(glm::length(core::nearest_point(s, found) - found), 1e-12) << "seed " << kSeed << ": " << i;
  }
}

TEST(MeshExtras, PlacesThatAreEquallyNearHaveAPoint) {
  MeshSurface s;
  s.radius = 2.0, s.tube_radius = 0.5, s.slope = 0.5;
  for (const Kind kind : {Kind::kPlane, Kind::kCylinder, Kind::kCone, Kind::kSphere, Kind::kTorus}) {
    s.kind = kind;
    const dvec3 found = core::nearest_point(s, s.origin);
    EXPECT_TRUE(core::is_finite(found)) << core::name_of(kind);
    EXPECT_LE(glm::length(core::nearest_point(s, found) - found), 1e-12) << core::name_of(kind);
  }
}

/// Triangles that do not lie on the surface of their face have none, whoever changed the mesh.
TEST(MeshExtras, TrianglesHaveTheSurfaceThatTheyLieOn) {
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.indices = {0, 1, 2, 0, 1, 3, 0, 2, 3};
  EXPECT_EQ(core::surface_of(mesh, 0), core::kNone);
  std::vector<MeshSurface> surfaces(2);
  surfaces[0].end_triangle = 1, surfaces[1].end_triangle = 2;
  surfaces[0].kind = surfaces[1].kind = Kind::kPlane;
  surfaces[1].axis = {0, 1, 0};
  mesh.extras = core::MeshExtrasSlot({nullptr, std::make_shared<const std::vector<MeshSurface>>(surfaces)});
  const core::Mesh copy = mesh;
  for (const core::Mesh* one : {&std::as_const(mesh), &copy}) {
    EXPECT_EQ(core::surface_of(*one, 0), 0u);
    EXPECT_EQ(core::surface_of(*one, 1), 1u);
    EXPECT_EQ(core::surface_of(*one, 2), core::kNone) << "of no face";
    EXPECT_EQ(core::surface_of(*one, 7), core::kNone) << "no triangle";
  }
  mesh.positions[2].z = 0.1f;
  EXPECT_EQ(core::surface_of(mesh, 0), core::kNone);
  EXPECT_EQ(core::surface_of(mesh, 1), 1u);
}

}  // namespace
}  // namespace sightline::tests::mesh_extras_test
