#include <gtest/gtest.h>

#include "dish_checks.h"
#include "intersection_twin.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::elliptical_dish_test {
namespace {

using twin::LVec;

struct Solid {
  core::EllipticalDish shape;
  bool inside(const LVec& p) const { return p.z >= 0 && lateral(p) <= 1.0L; }
  long double lateral(const LVec& p) const {
    const long double r = shape.base_radius, h = shape.height;
    return (p.x * p.x + p.y * p.y) / (r * r) + p.z * p.z / (h * h);
  }
  std::vector<dvec3> cap_normals() const { return {{0, 0, -1}}; }
  dvec3 half() const { return {shape.base_radius, shape.base_radius, shape.height}; }
  double size() const { return std::max(shape.base_radius, shape.height); }
  double feature() const { return std::min(shape.base_radius, shape.height); }
};

TEST(EllipticalDish, AgreesWithTheMarchingTwin) {
  twin::run(6000, 0.125, [](twin::Random& random) {
    const double scale = random.log_uniform(-6, 6);
    return Solid{{float(scale), float(scale * random.log_uniform(-2, 2))}};
  });
}

TEST(EllipticalDish, KeepsItsPrecisionWhenVeryFlat) {
  const core::EllipticalDish flat{1.0f, 1e-6f};
  const Hits hits = intersect(flat, {{0.6, 0.0, 1e3}, {0.0, 0.0, -1.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_NEAR(hits.hit[0].t, 1e3 - 0.8e-6, 2e-13);
  EXPECT_EQ(hits.hit[1].t, 1e3);
}

TEST(EllipticalDish, HeightZeroIsADiscOfTwoSides) {
  twin::expect_a_disc_of_two_sides_without_height<core::EllipticalDish>();
}

TEST(EllipticalDish, BaseRadiusZeroIsNothing) {
  EXPECT_EQ(intersect(core::EllipticalDish{0.0f, 1.0f}, {{0.0, 0.0, 5.0}, {0.0, 0.0, -1.0}}).count, 0);
}

TEST(EllipticalDish, OpenBaseDropsItsCrossingOnly) {
  twin::expect_an_open_base_to_drop_its_crossing_only<core::EllipticalDish>();
}

}  // namespace
}  // namespace sightline::gpuprims::elliptical_dish_test
