#include <numbers>

#include <gtest/gtest.h>

#include "intersection_twin.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::rectangular_torus_test {
namespace {

using twin::LVec;
constexpr double kPi = std::numbers::pi;
constexpr float kFullTurn = float(2.0 * kPi);

struct Solid {
  core::RectangularTorus shape;

  bool inside(const LVec& p) const {
    const long double rho = std::hypot(p.x, p.y);
    if (rho < shape.inner_radius || rho > shape.outer_radius || std::fabs(p.z) > 0.5L * shape.height) return false;
    if (shape.angle >= 2.0 * kPi) return true;
    long double phi = std::atan2(p.y, p.x);
    if (phi < 0) phi += 2.0L * std::numbers::pi_v<long double>;
    return phi <= (long double)shape.angle;
  }
  long double lateral(const LVec& p) const {
    const long double rho = std::hypot(p.x, p.y);
    return (rho - shape.inner_radius) * (rho - shape.outer_radius);
  }
  std::vector<dvec3> cap_normals() const {
    const double angle = shape.angle;
    return {{0, 0, -1}, {0, 0, 1}, {0, -1, 0}, {-std::sin(angle), std::cos(angle), 0}};
  }
  dvec3 half() const { return {shape.outer_radius, shape.outer_radius, 0.5 * shape.height}; }
  double size() const { return std::hypot(double(shape.outer_radius), 0.5 * shape.height); }
  double feature() const { return std::min(shape.outer_radius - shape.inner_radius, shape.height); }
};

core::RectangularTorus random_torus(twin::Random& random) {
  const double scale = random.log_uniform(-6, 6);
  core::RectangularTorus t{};
  t.outer_radius = float(scale);
  t.inner_radius = random.below(6) ? float(scale * random.uniform(0.01, 0.99)) : 0.0f;
  t.height = float(scale * random.log_uniform(-2, 1));
  const float angles[] = {kFullTurn, float(0.5 * kPi), float(kPi), float(1.5 * kPi), 1e-3f, 6.28f};
  t.angle = random.below(2) ? angles[random.below(6)] : float(random.uniform(0.01, 2.0 * kPi));
  return t;
}

TEST(RectangularTorus, AgreesWithTheMarchingTwin) {
  twin::run(8000, 0.125, [](twin::Random& random) { return Solid{random_torus(random)}; });
}

TEST(RectangularTorus, SixCrossingsThroughWallsAndEnds) {
  // Cut open by a thin gap just before a full turn; chords through the hole and across the gap.
  const core::RectangularTorus ring{1.0f, 3.0f, 2.0f, float(1.99 * kPi)};
  const Hits hits = intersect(ring, {{2.0, -9.0, 0.0}, {0.0, 1.0, 0.0}});
  ASSERT_EQ(hits.count, 4) << "in and out beside the gap";
  EXPECT_NEAR(hits.hit[2].t, 9.0, 1e-14);
  const Hits slanted = intersect(ring, {{-9.0, -1.1, 0.0}, {1.0, 0.1, 0.0}});
  EXPECT_EQ(slanted.count, 6) << "both walls, and both ends of the gap";
}

TEST(RectangularTorus, WithoutThicknessHasTwoSides) {
  const core::RectangularTorus tube{2.0f, 2.0f, 2.0f, kFullTurn};
  const Hits hits = intersect(tube, {{-5.0, 0.0, 0.5}, {1.0, 0.0, 0.0}});
  ASSERT_EQ(hits.count, 4);
  const double expected[] = {3.0, 3.0, 7.0, 7.0}, facing[] = {-1.0, 1.0, -1.0, 1.0};
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(hits.hit[i].t, expected[i]) << i;
    EXPECT_EQ(glm::normalize(hits.hit[i].normal).x, facing[i]) << i;
  }
  EXPECT_EQ(intersect(tube, {{-5.0, 0.3, 0.5}, {1.0, 0.1, 0.0}}).count, 4);
  EXPECT_EQ(intersect(tube, {{2.0, 0.0, -5.0}, {0.0, 0.0, 1.0}}).count, 0) << "edge on";
}

TEST(RectangularTorus, WithoutHeightHasTwoSides) {
  const core::RectangularTorus washer{1.0f, 2.0f, 0.0f, kFullTurn};
  const Hits hits = intersect(washer, {{1.5, 0.0, 5.0}, {0.0, 0.0, -1.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_EQ(hits.hit[0].t, 5.0);
  EXPECT_EQ(hits.hit[1].t, 5.0);
  EXPECT_EQ(hits.hit[0].normal.z, 1.0);
  EXPECT_EQ(hits.hit[1].normal.z, -1.0);
  EXPECT_EQ(intersect(washer, {{0.5, 0.0, 5.0}, {0.0, 0.0, -1.0}}).count, 0) << "through the hole";
  EXPECT_EQ(intersect(washer, {{-5.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}).count, 0) << "edge on";
}

TEST(RectangularTorus, AngleZeroHasTwoSides) {
  const core::RectangularTorus sheet{1.0f, 3.0f, 2.0f, 0.0f};
  const Hits hits = intersect(sheet, {{2.0, -2.0, 0.5}, {0.0, 1.0, 0.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_EQ(hits.hit[0].t, 2.0);
  EXPECT_EQ(hits.hit[1].t, 2.0);
  EXPECT_EQ(hits.hit[0].normal.y, -1.0);
  EXPECT_EQ(hits.hit[1].normal.y, 1.0);
  EXPECT_EQ(intersect(sheet, {{-2.0, -2.0, 0.5}, {0.0, 1.0, 0.0}}).count, 0) << "the other side of the axis";
  EXPECT_EQ(intersect(sheet, {{-5.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}).count, 0) << "edge on";
}

TEST(RectangularTorus, RadiiInAnyOrderAndNoneIsNothing) {
  const Ray ray{{-5.0, 0.2, 0.1}, {1.0, 0.0, 0.0}};
  EXPECT_EQ(intersect(core::RectangularTorus{3.0f, 1.0f, 1.0f, kFullTurn}, ray).count, 4);
  EXPECT_EQ(intersect(core::RectangularTorus{0.0f, 0.0f, 1.0f, kFullTurn}, ray).count, 0);
}

TEST(RectangularTorus, OpenEndsDropTheirCrossingOnly) {
  const core::RectangularTorus elbow{1.0f, 3.0f, 2.0f, float(0.5 * kPi)};
  const Ray ray{{2.0, -5.0, 0.2}, {0.0, 1.0, 0.0}};  // in through the start, out through the wall
  EXPECT_EQ(intersect(elbow, ray).count, 2);
  EXPECT_EQ(intersect(elbow, ray, {false, true}).count, 1);
  EXPECT_EQ(intersect(elbow, ray, {true, false}).count, 2);
}

TEST(RectangularTorus, NormalsAreThoseOfItsWalls) {
  const core::Mesh mesh = tessellate(core::RectangularTorus{1.0f, 3.0f, 2.0f, 1.0f});
  std::size_t level = 0, upright = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const core::vec3 p = mesh.positions[i], n = mesh.normals[i];
    if (n.z != 0.0f) {
      ++level;
      EXPECT_EQ(n, core::vec3(0.0f, 0.0f, p.z));
      continue;
    }
    ++upright;
    const float rho = std::hypot(p.x, p.y), out = (n.x * p.x + n.y * p.y) / rho;
    if (std::abs(out) < 1e-6f) continue;  // of an end
    EXPECT_NEAR(out, rho > 2.0f ? 1.0f : -1.0f, 1e-6f);
  }
  EXPECT_GT(level, 8u);
  EXPECT_GT(upright, 8u);
}

TEST(RectangularTorus, TurnsAHairShortAreClosed) {
  const float nearly = 6.283185f, short_of_it = std::nextafter(nearly, 0.0f);
  ASSERT_LT(double(nearly), 2.0 * std::numbers::pi);
  const Ray across_the_seam{{2.0, -4.0, 0.2}, {0.0, 1.0, 0.0}};
  const core::Mesh closed = tessellate(core::RectangularTorus{1.0f, 3.0f, 1.0f, kFullTurn});
  for (const float angle : {nearly, -nearly, kFullTurn, 7.0f}) {
    const core::RectangularTorus torus{1.0f, 3.0f, 1.0f, angle};
    EXPECT_EQ(intersect(torus, across_the_seam).count, 2) << angle;
    const core::Mesh mesh = tessellate(torus);
    EXPECT_TRUE(mesh.positions == closed.positions) << angle;
    EXPECT_TRUE(mesh.indices == closed.indices) << angle;
  }
  const core::RectangularTorus slice{1.0f, 3.0f, 1.0f, short_of_it};
  EXPECT_EQ(intersect(slice, across_the_seam).count, 4);
  EXPECT_GT(tessellate(slice).indices.size(), closed.indices.size());
}

}  // namespace
}  // namespace sightline::gpuprims::rectangular_torus_test
