// Surfaces against closed forms. Those of each kind are compared with triangles in
// tests/engine/contribution_culling_test.cpp.
#include "sightline/core/surface_area.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sightline/tests/core/primitive_samples.h"

namespace sightline::core::surface_area_test {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(SurfaceArea, ClosedForms) {
  EXPECT_NEAR(surface_area(Box{1, 2, -3}), 22.0, 1e-6);
  EXPECT_NEAR(surface_area(Sphere{2}), 4.0 * kPi, 1e-6);
  EXPECT_NEAR(surface_area(Cylinder{-1, 2}), 6.0 * kPi, 1e-6);
  EXPECT_NEAR(surface_area(SphericalDish{1, 1}), 3.0 * kPi, 1e-6);         // half a ball
  EXPECT_NEAR(surface_area(EllipticalDish{1, 1}), 3.0 * kPi, 1e-6);        // the same
  EXPECT_NEAR(surface_area(EllipticalDish{1, 0}), 2.0 * kPi, 0.03 * kPi);  // a disc, both sides
  EXPECT_NEAR(surface_area(Snout{1, 1, 2, 0, 0, 0, 0, 0, 0}), 6.0 * kPi, 1e-6);
  EXPECT_NEAR(surface_area(Snout{3, 0, 4, 0, 0, 0, 0, 0, 0}), kPi * (9.0 + 15.0), 1e-5);  // a cone
  EXPECT_NEAR(surface_area(Pyramid{1, 2, 1, 2, 0, 0, 3}), 22.0, 1e-6);
  EXPECT_NEAR(surface_area(Pyramid{6, 6, 0, 0, 0, 0, 4}), 36.0 + 4.0 * 0.5 * 6.0 * 5.0, 1e-5);
  EXPECT_NEAR(surface_area(CircularTorus{3, 1, float(kFullTurn)}), 12.0 * kPi * kPi, 1e-4);
  EXPECT_NEAR(surface_area(CircularTorus{3, 1, float(kPi)}), 6.0 * kPi * kPi + 2.0 * kPi, 1e-4);
  EXPECT_NEAR(surface_area(RectangularTorus{1, 2, 3, float(kFullTurn)}), 18.0 * kPi + 6.0 * kPi, 1e-4);
  EXPECT_NEAR(surface_area(RectangularTorus{1, 2, 3, float(kPi)}), 12.0 * kPi + 6.0, 1e-4);
  EXPECT_EQ(surface_area(Line{0, 5}), 0.0);
}

/// A solid and its copy of twice the size.
TEST(SurfaceArea, GrowsWithTheSquare) {
  tests::Random random(5);
  for (int kind = 0; kind < kPrimitiveKindCount; ++kind)
    for (int i = 0; i < 100; ++i) {
      const Primitive one = tests::random_primitive(Kind(kind), random);
      const auto values = parameters(one);
      std::vector<float> doubled(values.begin(), values.end());
      const bool angle = Kind(kind) == Kind::kRectangularTorus || Kind(kind) == Kind::kCircularTorus;
      for (std::size_t k = 0; k < doubled.size() - angle; ++k) doubled[k] *= 2.0f;
      const double small = surface_area(one);
      ASSERT_GE(small, 0.0);
      ASSERT_NEAR(surface_area(make_primitive(Kind(kind), doubled)), 4.0 * small, 1e-6 * small) << name_of(Kind(kind));
    }
}

TEST(SurfaceArea, OfAMeshIsThatOfItsTriangles) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}, {0, 0, 5}};
  mesh.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2};
  EXPECT_NEAR(surface_area(mesh), 6.0 + 7.5 + 10.0, 1e-9);
  EXPECT_EQ(surface_area(Mesh{}), 0.0);
}

}  // namespace
}  // namespace sightline::core::surface_area_test
