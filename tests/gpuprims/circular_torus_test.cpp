#include <numbers>

#include <gtest/gtest.h>

#include "intersection_twin.h"
#include "sightline/gpuprims/internal/primitives.h"

namespace sightline::gpuprims::circular_torus_test {
namespace {

using twin::LVec;
constexpr double kPi = std::numbers::pi;

struct Solid {
  core::CircularTorus shape;

  bool inside(const LVec& p) const {
    if (lateral(p) > 0) return false;
    if (shape.angle >= 2.0 * kPi) return true;
    long double phi = std::atan2(p.y, p.x);
    if (phi < 0) phi += 2.0L * std::numbers::pi_v<long double>;
    return phi <= (long double)shape.angle;
  }
  long double lateral(const LVec& p) const {
    const long double off = std::hypot(p.x, p.y) - shape.major_radius;
    return off * off + p.z * p.z - (long double)shape.tube_radius * shape.tube_radius;
  }
  std::vector<dvec3> cap_normals() const {
    if (shape.angle >= 2.0 * kPi) return {};
    return {{0, -1, 0}, {-std::sin(double(shape.angle)), std::cos(double(shape.angle)), 0}};
  }
  dvec3 half() const { return {size(), size(), shape.tube_radius}; }
  double size() const { return double(shape.major_radius) + shape.tube_radius; }
  double feature() const { return shape.tube_radius; }
};

core::CircularTorus random_torus(twin::Random& random) {
  const double scale = random.log_uniform(-6, 6);
  core::CircularTorus t{};
  t.tube_radius = float(scale);
  t.major_radius = float(scale * random.log_uniform(0, 2));
  switch (random.below(6)) {
    case 0:
      t.major_radius = t.tube_radius;
      break;  // horn
    case 1:
      t.major_radius = t.tube_radius * float(random.uniform(0.0, 1.0));
      break;  // spindle
    case 2:
      t.major_radius = std::nextafterf(t.tube_radius, 2.0f * t.tube_radius);
      break;  // a hair from a horn
    default:
      break;
  }
  const float angles[] = {float(2.0 * kPi), float(0.5 * kPi), float(kPi), float(1.5 * kPi), 1e-3f, 6.28f};
  t.angle = random.below(2) ? angles[random.below(6)] : float(random.uniform(0.01, 2.0 * kPi));
  return t;
}

/// Half of the shots go into the tube, which is thin.
twin::Shot aim(twin::Random& random, const Solid& solid) {
  twin::Shot shot = random_shot(random, solid.half());
  if (random.below(2)) {
    const double phi = random.uniform(0.0, solid.shape.angle);
    const dvec3 target(solid.shape.major_radius * std::cos(phi), solid.shape.major_radius * std::sin(phi),
                       solid.shape.tube_radius * random.uniform(-1.0, 1.0));
    shot.ray.origin = target - shot.aim * shot.ray.direction;
  }
  return shot;
}

TEST(CircularTorus, AgreesWithTheMarchingTwin) {
  const auto make = [](twin::Random& random) { return Solid{random_torus(random)}; };
  const twin::Tally tally = twin::run(8000, 0.25, make, aim);
  EXPECT_GT(tally.crossings, 2 * tally.hit) << "no ray crossed more than twice";
}

TEST(CircularTorus, FourCrossingsThroughBothSides) {
  const core::CircularTorus ring{3.0f, 1.0f, float(2.0 * kPi)};
  const Hits hits = intersect(ring, {{-10.0, 0.0, 0.0}, {1.0, 0.0, 0.0}});
  ASSERT_EQ(hits.count, 4);
  const double expected[] = {6.0, 8.0, 12.0, 14.0};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(hits.hit[i].t, expected[i], 1e-14);
  EXPECT_EQ(intersect(ring, {{0.0, 0.0, -5.0}, {0.0, 0.0, 1.0}}).count, 0) << "through the hole";
}

/// The solid is closed: a line that touches it from outside meets it, one a hair beside does not.
TEST(CircularTorus, TouchingIsMeeting) {
  for (const double scale : {1.0, 0.25, 1024.0}) {
    const core::CircularTorus ring{float(3.0 * scale), float(scale), float(2.0 * kPi)};
    for (const dvec3& direction : {dvec3(0, 0, 1), dvec3(0, 1, 0), dvec3(0, 1, 1)}) {
      const dvec3 touching(4.0 * scale, 0.0, 0.0), beside(4.0001 * scale, 0.0, 0.0);
      const Hits hits = intersect(ring, {touching - 5.0 * direction, direction});
      ASSERT_EQ(hits.count, 2) << scale;
      EXPECT_NEAR(hits.hit[0].t, 5.0, 1e-6 * scale);
      EXPECT_EQ(intersect(ring, {beside - 5.0 * direction, direction}).count, 0);
    }
  }
}

TEST(CircularTorus, ThinRingFarAway) {
  // R / r = 1e4, seen from 1e5 R.
  const core::CircularTorus ring{1e4f, 1.0f, float(2.0 * kPi)};
  const Hits hits = intersect(ring, {{1e4 + 0.5, 0.0, -1e9}, {0.0, 0.0, 1.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_NEAR(hits.hit[1].t - hits.hit[0].t, 2.0 * std::sqrt(0.75), 1e-6);
  EXPECT_NEAR(hits.hit[0].normal.x / -hits.hit[0].normal.z, 0.5 / std::sqrt(0.75), 1e-9);
}

TEST(CircularTorus, SpindleHasNoInnerWall) {
  const core::CircularTorus spindle{0.5f, 1.0f, float(2.0 * kPi)};
  const Hits hits = intersect(spindle, {{-10.0, 0.0, 0.0}, {1.0, 0.0, 0.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_NEAR(hits.hit[0].t, 8.5, 1e-14);
  EXPECT_NEAR(hits.hit[1].t, 11.5, 1e-14);
}

TEST(CircularTorus, MajorRadiusZeroIsABall) {
  const Hits hits = intersect(core::CircularTorus{0.0f, 2.0f, float(2.0 * kPi)}, {{0.3, 0.2, -9.0}, {0.0, 0.0, 1.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_NEAR(hits.hit[0].t, 9.0 - std::sqrt(4.0 - 0.13), 1e-14);
}

TEST(CircularTorus, AngleZeroIsADiscOfTwoSides) {
  const core::CircularTorus disc{3.0f, 1.0f, 0.0f};
  const Hits hits = intersect(disc, {{3.5, -2.0, 0.0}, {0.0, 1.0, 0.0}});
  ASSERT_EQ(hits.count, 2);
  EXPECT_EQ(hits.hit[0].t, 2.0);
  EXPECT_EQ(hits.hit[1].t, 2.0);
  EXPECT_EQ(hits.hit[0].normal.y, -1.0);
  EXPECT_EQ(hits.hit[1].normal.y, 1.0);
  EXPECT_EQ(intersect(disc, {{-3.5, -2.0, 0.0}, {0.0, 1.0, 0.0}}).count, 0) << "the other side of the axis";
  EXPECT_EQ(intersect(disc, {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}}).count, 0) << "edge on";
}

TEST(CircularTorus, ShowsNothingWithoutATube) {
  const Ray ray{{3.0, -5.0, 0.0}, {0.0, 1.0, 0.0}};
  EXPECT_EQ(intersect(core::CircularTorus{3.0f, 0.0f, 1.0f}, ray).count, 0);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(intersect(core::CircularTorus{3.0f, 1.0f, nan}, ray).count, 0);
  EXPECT_EQ(intersect(core::CircularTorus{nan, 1.0f, 1.0f}, ray).count, 0);
}

TEST(CircularTorus, OpenEndsDropTheirCrossingOnly) {
  const core::CircularTorus elbow{3.0f, 1.0f, float(0.5 * kPi)};
  const Ray ray{{3.0, -5.0, 0.2}, {0.0, 1.0, 0.0}};  // in through the start, out through the wall
  EXPECT_EQ(intersect(elbow, ray).count, 2);
  const Hits open = intersect(elbow, ray, {false, true});
  ASSERT_EQ(open.count, 1);
  EXPECT_GT(open.hit[0].normal.y, 0.0);
  EXPECT_EQ(intersect(elbow, ray, {true, false}).count, 2);
}

TEST(CircularTorus, TurnsAHairShortAreClosed) {
  const float full = float(2.0 * kPi), nearly = 6.283185f, short_of_it = std::nextafter(nearly, 0.0f);
  ASSERT_LT(double(nearly), 2.0 * kPi);
  const Ray across_the_seam{{3.0, -2.0, 0.2}, {0.0, 1.0, 0.0}};
  const core::Mesh closed = tessellate(core::CircularTorus{3.0f, 1.0f, full});
  for (const float angle : {nearly, -nearly, full, 7.0f}) {
    const core::CircularTorus torus{3.0f, 1.0f, angle};
    EXPECT_EQ(intersect(torus, across_the_seam).count, 2) << angle;
    const core::Mesh mesh = tessellate(torus);
    EXPECT_TRUE(mesh.positions == closed.positions) << angle;
    EXPECT_TRUE(mesh.indices == closed.indices) << angle;
  }
  const core::CircularTorus slice{3.0f, 1.0f, short_of_it};
  EXPECT_EQ(intersect(slice, across_the_seam).count, 4);
  EXPECT_GT(tessellate(slice).indices.size(), closed.indices.size());
}

}  // namespace
}  // namespace sightline::gpuprims::circular_torus_test
