#include "sightline/analysis/measure/amounts.h"

#include <array>
#include <numbers>

#include <gtest/gtest.h>

#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/analysis/measure/measure_samples.h"

namespace sightline::measure::amounts_test {
namespace {

using core::Affine;
using core::dmat3;
using core::Primitive;

constexpr double kPi = std::numbers::pi;

Affine scaled(double x, double y, double z) {
  return {dmat3(x, 0, 0, 0, y, 0, 0, 0, z), {}};
}

Amounts of(const Primitive& primitive, const Affine& place = {}) {
  const auto found = amounts(primitive, place);
  EXPECT_TRUE(found);
  return found ? *found : Amounts{};
}

void expect(const Amounts& found, double area, double volume) {
  EXPECT_NEAR(found.area, area, found.area_error + 1e-12 * area);
  EXPECT_NEAR(found.volume, volume, found.volume_error + 1e-12 * volume);
  EXPECT_LE(found.area_error, 1e-9 * area);
  EXPECT_LE(found.volume_error, 1e-9 * volume);
  EXPECT_EQ(found.open, 0u);
}

TEST(Amounts, AreThoseOfTheBooks) {
  expect(of(core::Box{1, 2, 3}), 22.0, 6.0);
  expect(of(core::Cylinder{2, 5}), 28.0 * kPi, 20.0 * kPi);
  expect(of(core::Sphere{2}), 4.0 * kPi, 4.0 / 3.0 * kPi);
  expect(of(core::CircularTorus{3, 1, float(2.0 * kPi)}), 12.0 * kPi * kPi, 6.0 * kPi * kPi);
  expect(of(core::SphericalDish{1, 1}), 3.0 * kPi, 2.0 / 3.0 * kPi);
  expect(of(core::EllipticalDish{1, 1}), 3.0 * kPi, 2.0 / 3.0 * kPi);
  expect(of(core::Pyramid{2, 2, 0, 0, 0, 0, 3}), 4.0 + 4.0 * std::sqrt(10.0), 4.0);
  expect(of(core::Snout{1, 0, 1, 0, 0, 0, 0, 0, 0}), kPi * (1.0 + std::sqrt(2.0)), kPi / 3.0);
  // A prolate spheroid of half-axes 1, 1, 2, whose area is 2 pi (1 + 2 asin(e) / e), of a ball that is stretched.
  const double e = std::sqrt(0.75);
  expect(of(core::Sphere{2}, scaled(1, 1, 2)), 2.0 * kPi * (1.0 + 2.0 * std::asin(e) / e), 8.0 / 3.0 * kPi);
  // A pipe cut at 45 degrees at either end: its volume is that of the level one.
  const float turn = float(0.25 * kPi);
  const Amounts cut = of(core::Snout{1, 1, 4, 0, 0, turn, 0, turn, 0});
  EXPECT_NEAR(cut.volume, 4.0 * kPi, 1e-9);
  EXPECT_NEAR(cut.area, 8.0 * kPi + 2.0 * std::sqrt(2.0) * kPi, 1e-6) << "its ends are ellipses; the angle is a float";
  EXPECT_EQ(of(core::Line{0, 1}).open, 1u);
}

/// A spindle torus is a ball where its ring has no radius, and nearly so where that is small.
TEST(Amounts, ToriThatReachBeyondTheirAxisCountOnce) {
  expect(of(core::CircularTorus{0, 1, float(2.0 * kPi)}), 4.0 * kPi, 4.0 / 3.0 * kPi);
  const Amounts half = of(core::CircularTorus{0, 1, float(kPi)});
  EXPECT_NEAR(half.area, 3.0 * kPi, 1e-6);
  EXPECT_NEAR(half.volume, 2.0 / 3.0 * kPi, 1e-6);
}

/// What formulas give for a placement is what sums over surfaces give for one that is hardly another.
TEST(Amounts, FormulasAgreeWithSums) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  tests::Random random(kSeed);
  for (const core::Kind kind : tests::kSolidKinds)
    for (int round = 0; round < 20; ++round) {
      const Primitive primitive = tests::ordinary_primitive(kind, random);
      const Amounts formula = of(primitive), sum = of(primitive, scaled(1.0, 1.0, 1.0 + 2e-6));
      EXPECT_NEAR(sum.area, formula.area, 1e-5 * formula.area) << tests::text_of(primitive, {});
      EXPECT_LE(sum.area_error, 1e-6 * sum.area) << tests::text_of(primitive, {});
      EXPECT_NEAR(sum.volume, formula.volume, 1e-5 * formula.volume) << tests::text_of(primitive, {});
    }
}

/// Fine triangles of the same primitives come near, also of slanted snouts and under any placement.
TEST(Amounts, AreThoseOfFineTriangles) {
  constexpr unsigned kSeed = 9;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  tests::Random random(kSeed);
  for (const core::Kind kind : tests::kSolidKinds)
    for (int round = 0; round < 12; ++round) {
      Primitive primitive = tests::ordinary_primitive(kind, random);
      if (auto* snout = std::get_if<core::Snout>(&primitive); snout && round % 2 == 0) {
        snout->height = 3.0f;
        snout->offset_x = snout->offset_y = 0.2f;
        for (float* shear : {&snout->bottom_shear_x, &snout->bottom_shear_y, &snout->top_shear_x, &snout->top_shear_y})
          *shear = float(tests::uniform(random, -0.3, 0.3));
      }
      Affine place = tests::placement(random, 1.0, 10.0);
      if (kind == core::Kind::kLine) continue;
      const auto mesh = gpuprims::tessellate(primitive, {.fixed_segments = 256});
      const auto triangles = amounts(mesh, place);
      ASSERT_TRUE(triangles);
      const Amounts found = of(primitive, place);
      EXPECT_NEAR(found.area, triangles->area, 2e-3 * found.area) << tests::text_of(primitive, place);
      if (triangles->open == 0) {
        EXPECT_NEAR(found.volume, triangles->volume, 2e-3 * found.volume) << tests::text_of(primitive, place);
      }
    }
}

core::Mesh tetrahedron(bool open) {
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  if (open) mesh.indices.resize(9);
  return mesh;
}

TEST(Amounts, OfMeshesAreOfTheirTriangles) {
  const Affine far{dmat3(2.0), {1e7, -1e7, 1e7}};
  const auto solid = amounts(tetrahedron(false), far), sheet = amounts(tetrahedron(true), far);
  ASSERT_TRUE(solid && sheet);
  expect(*solid, 4.0 * (1.5 + 0.5 * std::sqrt(3.0)), 8.0 / 6.0);
  EXPECT_NEAR(sheet->area, 4.0 * 1.5, 1e-12);
  EXPECT_EQ(sheet->volume, 0.0);
  EXPECT_EQ(sheet->open, 1u);
}

TEST(Amounts, OfItemsAreTheirSum) {
  core::Scene scene;
  const core::NodeId node = scene.add_node(scene.root(), "", scaled(2, 2, 2));
  const std::array items{scene.add_primitive(node, core::Box{1, 1, 1}),
                         scene.add_mesh_instance(scene.root(), scene.add_mesh(tetrahedron(true)).value()),
                         scene.add_primitive(scene.root(), core::Line{0, 1})};
  const auto sum = amounts(scene, items);
  ASSERT_TRUE(sum);
  EXPECT_NEAR(sum->area, 24.0 + 1.5, 1e-12);
  EXPECT_NEAR(sum->volume, 8.0, 1e-12);
  EXPECT_EQ(sum->open, 2u);
}

TEST(Amounts, DegenerateAndBadInput) {
  EXPECT_EQ(of(core::Cylinder{1, 0}).volume, 0.0);
  EXPECT_NEAR(of(core::EllipticalDish{1, 0}).area, 2.0 * kPi, 1e-12);
  EXPECT_NEAR(of(core::SphericalDish{1, 0}).area, 2.0 * kPi, 1e-12);
  EXPECT_EQ(of(core::Sphere{2}, scaled(1, 1, 0)).volume, 0.0);
  for (const float ratio : {0.999f, 0.9999f, 0.99999f, 1.00001f, 1.0001f, 1.001f})
    EXPECT_NEAR(of(core::EllipticalDish{1, ratio}).area / kPi, 3.0 + 4.0 / 3.0 * (double(ratio) - 1.0), 1e-6);
  // Ends that cross.
  const Amounts crossed = of(core::Snout{1, 1, 0.1f, 0, 0, 1, 0, -1, 0});
  EXPECT_TRUE(std::isinf(crossed.area_error) && std::isinf(crossed.volume_error));
  EXPECT_FALSE(amounts(Primitive(core::Sphere{std::numeric_limits<float>::quiet_NaN()}), Affine{}));
  EXPECT_FALSE(amounts(Primitive(core::Sphere{1}), Affine{dmat3(std::numeric_limits<double>::infinity()), {}}));
}

}  // namespace
}  // namespace sightline::measure::amounts_test
