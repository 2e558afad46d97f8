#include <gtest/gtest.h>

#include "intersection_twin.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::sphere_test {
namespace {

using twin::LVec;

struct Solid {
  core::Sphere shape;
  bool inside(const LVec& p) const { return lateral(p) <= 0.25L * shape.diameter * shape.diameter; }
  long double lateral(const LVec& p) const { return glm::dot(p, p); }
  std::vector<dvec3> cap_normals() const { return {}; }
  dvec3 half() const { return dvec3(size()); }
  double size() const { return 0.5 * shape.diameter; }
  double feature() const { return size(); }
};

TEST(Sphere, AgreesWithTheMarchingTwin) {
  twin::run(4000, 0.25, [](twin::Random& random) { return Solid{{float(random.log_uniform(-6, 6))}}; });
}

TEST(Sphere, KeepsItsPrecisionFarFromTheEye) {
  const Hits hits = intersect(core::Sphere{2.0f}, {{-1e7, 0.6, 0.0}, {1.0, 0.0, 0.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_NEAR(hits.hit[0].t, 1e7 - 0.8, 2e-9);
  EXPECT_NEAR(glm::normalize(hits.hit[0].normal).y, 0.6, 1e-15);
}

TEST(Sphere, GrazingRays) {
  const core::Sphere ball{2.0f};
  EXPECT_EQ(intersect(ball, {{-1e3, 1.0 + 1e-12, 0.0}, {1.0, 0.0, 0.0}}).count, 0);
  const Hits hits = intersect(ball, {{-1e3, 1.0 - 1e-12, 0.0}, {1.0, 0.0, 0.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_NEAR(hits.hit[1].t - hits.hit[0].t, 2.0 * std::sqrt(2e-12), 1e-9);
}

TEST(Sphere, NegativeDiameterCountsAsAbsoluteAndZeroIsNothing) {
  const Ray ray{{0.3, 0.2, -9.0}, {0.0, 0.0, 1.0}};
  EXPECT_EQ(intersect(core::Sphere{-2.0f}, ray).count, 2);
  EXPECT_EQ(intersect(core::Sphere{0.0f}, {{0.0, 0.0, -9.0}, {0.0, 0.0, 1.0}}).count, 0);
  EXPECT_EQ(intersect(core::Sphere{2.0f}, ray, {false, false}).count, 2) << "it has no ends";
}

}  // namespace
}  // namespace sightline::gpuprims::sphere_test
