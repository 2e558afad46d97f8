#include <gtest/gtest.h>

#include "intersection_twin.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::cylinder_test {
namespace {

using twin::LVec;

struct Solid {
  core::Cylinder shape;
  bool inside(const LVec& p) const {
    return p.x * p.x + p.y * p.y <= (long double)shape.radius * shape.radius && std::fabs(p.z) <= 0.5L * shape.height;
  }
  long double lateral(const LVec& p) const { return p.x * p.x + p.y * p.y; }
  std::vector<dvec3> cap_normals() const { return {{0, 0, -1}, {0, 0, 1}}; }
  dvec3 half() const { return {shape.radius, shape.radius, 0.5 * shape.height}; }
  double size() const { return std::hypot(double(shape.radius), 0.5 * shape.height); }
  double feature() const { return std::min(shape.radius, shape.height); }
};

TEST(Cylinder, AgreesWithTheMarchingTwin) {
  twin::run(6000, 0.25, [](twin::Random& random) {
    const double scale = random.log_uniform(-6, 6);
    return Solid{{float(scale * random.log_uniform(-2, 2)), float(scale * random.log_uniform(-2, 2))}};
  });
}

TEST(Cylinder, KeepsItsPrecisionFarFromTheEye) {
  // 1000 km from a pipe of 10 mm: the crossing is known to one rounding of the distance.
  const core::Cylinder pipe{0.005f, 100.0f};
  const double radius = double(0.005f);
  const Hits hits = intersect(pipe, {{-1e6, 0.003, 1.0}, {1.0, 0.0, 0.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_NEAR(hits.hit[0].t, 1e6 - std::sqrt(radius * radius - 0.003 * 0.003), 2e-10);
  EXPECT_NEAR(glm::normalize(hits.hit[0].normal).y, 0.003 / radius, 1e-13);
}

TEST(Cylinder, HeightZeroIsADiscOfTwoSides) {
  const core::Cylinder disc{2.0f, 0.0f};
  const Hits hits = intersect(disc, {{1.0, 0.0, 5.0}, {0.0, 0.0, -2.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_EQ(hits.hit[0].t, 2.5);
  EXPECT_EQ(hits.hit[0].normal.z, 1.0);
  EXPECT_EQ(hits.hit[1].t, 2.5);
  EXPECT_EQ(hits.hit[1].normal.z, -1.0);
  EXPECT_EQ(intersect(disc, {{2.1, 0.0, 5.0}, {0.0, 0.0, -1.0}}).count, 0);
  EXPECT_EQ(intersect(disc, {{-5.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}).count, 0) << "edge on";
}

TEST(Cylinder, ShowsNothingWithoutRadiusOrDirection) {
  EXPECT_EQ(intersect(core::Cylinder{0.0f, 1.0f}, {{0, 0, -5}, {0, 0, 1}}).count, 0);
  EXPECT_EQ(intersect(core::Cylinder{1.0f, 1.0f}, {{0, 0, -5}, {0, 0, 0}}).count, 0);
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(intersect(core::Cylinder{nan, 1.0f}, {{0, 0, -5}, {0, 0, 1}}).count, 0);
  EXPECT_EQ(intersect(core::Cylinder{1.0f, infinity}, {{0, 0, -5}, {0, 0, 1}}).count, 0);
  EXPECT_EQ(intersect(core::Cylinder{1.0f, 1.0f}, {{0, 0, -5}, {0, double(nan), 1}}).count, 0);
}

TEST(Cylinder, NegativeLengthsCountAsAbsolute) {
  const Ray ray{{0.5, -3.0, 0.1}, {0.1, 1.0, 0.2}};
  const Hits a = intersect(core::Cylinder{1.0f, 2.0f}, ray), b = intersect(core::Cylinder{-1.0f, -2.0f}, ray);
  ASSERT_EQ(a.count, 2);
  ASSERT_EQ(b.count, 2);
  EXPECT_EQ(a.hit[0].t, b.hit[0].t);
  EXPECT_EQ(a.hit[1].t, b.hit[1].t);
}

TEST(Cylinder, OpenEndsDropTheirCrossingOnly) {
  const core::Cylinder c{1.0f, 2.0f};
  const Ray slanted{{0.0, 0.0, 3.0}, {0.3, 0.0, -1.0}};  // in through the top, out through the wall
  ASSERT_EQ(intersect(c, slanted).count, 2);
  const Hits open = intersect(c, slanted, {true, false});
  ASSERT_EQ(open.count, 1);
  EXPECT_GT(open.hit[0].normal.x, 0.0);
  EXPECT_EQ(intersect(c, slanted, {false, true}).count, 2);
  const Ray through{{0.2, 0.1, 3.0}, {0.0, 0.0, -1.0}};
  EXPECT_EQ(intersect(c, through, {false, false}).count, 0);
  const Hits bottom = intersect(c, through, {true, false}), top = intersect(c, through, {false, true});
  ASSERT_EQ(bottom.count, 1);
  EXPECT_EQ(bottom.hit[0].t, 4.0);
  ASSERT_EQ(top.count, 1);
  EXPECT_EQ(top.hit[0].t, 2.0);
}

}  // namespace
}  // namespace sightline::gpuprims::cylinder_test
