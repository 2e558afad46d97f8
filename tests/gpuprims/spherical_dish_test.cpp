#include <gtest/gtest.h>

#include "dish_checks.h"
#include "intersection_twin.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::spherical_dish_test {
namespace {

using twin::LVec;

struct Solid {
  core::SphericalDish shape;
  bool inside(const LVec& p) const {
    const long double r = radius();
    return p.z >= 0 && lateral(p) <= r * r;
  }
  long double radius() const {
    const long double r = shape.base_radius, h = shape.height;
    return (r * r + h * h) / (2.0L * h);
  }
  long double lateral(const LVec& p) const {
    const long double z = p.z - (shape.height - radius());
    return p.x * p.x + p.y * p.y + z * z;
  }
  std::vector<dvec3> cap_normals() const { return {{0, 0, -1}}; }
  double widest() const { return shape.height > shape.base_radius ? double(radius()) : shape.base_radius; }
  dvec3 half() const { return {widest(), widest(), shape.height}; }
  double size() const { return glm::length(half()); }
  double feature() const { return std::min(shape.base_radius, shape.height); }
};

TEST(SphericalDish, AgreesWithTheMarchingTwin) {
  twin::run(6000, 0.125, [](twin::Random& random) {
    const double scale = random.log_uniform(-6, 6);
    return Solid{{float(scale), float(scale * random.log_uniform(-2, 2))}};
  });
}

TEST(SphericalDish, KeepsItsPrecisionWhenVeryFlat) {
  const core::SphericalDish flat{1.0f, 1e-6f};
  const Hits hits = intersect(flat, {{0.6, 0.0, 1e3}, {0.0, 0.0, -1.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_NEAR(hits.hit[0].t, 1e3 - (1.0 - 0.36) * 1e-6, 2e-13);
  EXPECT_EQ(hits.hit[1].t, 1e3);
}

TEST(SphericalDish, HeightZeroIsADiscOfTwoSides) {
  twin::expect_a_disc_of_two_sides_without_height<core::SphericalDish>();
}

/// A cap so flat that squares of its height underflow is its base's disc.
TEST(SphericalDish, IsFlatFromAThousandthOfAFemtometrePerMetre) {
  for (const float radius : {0.01f, 4.0f, 1000.0f}) {
    const Ray down{{0.0, 0.5 * radius, radius}, {0.0, 0.0, -1.0}};
    const Hits disc = intersect(core::SphericalDish{radius, 0.9e-18f * radius}, down);
    const Hits cap = intersect(core::SphericalDish{radius, 1.1e-18f * radius}, down);
    ASSERT_TRUE(disc.count == 2 && cap.count == 2) << radius;
    EXPECT_EQ(disc.hit[0].normal.y, 0.0);
    EXPECT_GT(cap.hit[0].normal.y, 0.0);
  }
}

TEST(SphericalDish, BaseRadiusZeroIsABall) {
  const Hits hits = intersect(core::SphericalDish{0.0f, 2.0f}, {{0.6, 0.0, 5.0}, {0.0, 0.0, -1.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_NEAR(hits.hit[0].t, 5.0 - 1.8, 1e-14);
  EXPECT_NEAR(hits.hit[1].t, 5.0 - 0.2, 1e-14);
  EXPECT_EQ(intersect(core::SphericalDish{0.0f, 0.0f}, {{0.0, 0.0, 5.0}, {0.0, 0.0, -1.0}}).count, 0);
}

TEST(SphericalDish, OpenBaseDropsItsCrossingOnly) {
  twin::expect_an_open_base_to_drop_its_crossing_only<core::SphericalDish>();
}

}  // namespace
}  // namespace sightline::gpuprims::spherical_dish_test
