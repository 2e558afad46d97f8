// Shortest distances of items against closed forms, certificates and dense samples.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/analysis/measure/distances.h"
#include "sightline/tests/analysis/measure/measure_samples.h"

namespace sightline::closest_test {
namespace {

using core::Affine;
using core::dvec3;
using core::Kind;
using core::Primitive;
using measure::Distance;
using measure::Item;
using tests::Random;
using tests::uniform;

constexpr std::uint64_t kSeed = 18;

Item item_of(const Primitive& primitive, const Affine& placement) {
  auto item = Item::create(primitive, placement);
  EXPECT_TRUE(item.has_value());
  return *item;
}

Distance between(const Primitive& a, const Affine& place_a, const Primitive& b, const Affine& place_b) {
  return measure::distance(item_of(a, place_a), item_of(b, place_b));
}

struct Pair {
  Primitive a, b;
  Affine place_a, place_b;
};

std::string text_of(const Pair& p) {
  return "seed " + std::to_string(kSeed) + ": " + tests::text_of(p.a, p.place_a) + "; " +
         tests::text_of(p.b, p.place_b);
}

/// Both closest points are in their solids, as far as core's support functions can tell.
void expect_within(const Pair& p, const Distance& d, double tolerance, Random& random) {
  for (int i = 0; i < 50; ++i) {
    const dvec3 u = tests::random_direction(random);
    EXPECT_LE(glm::dot(u, d.from - p.place_a.origin),
              tests::placed_support(p.a, p.place_a, u, p.place_a.origin) + tolerance);
    EXPECT_LE(glm::dot(u, d.to - p.place_b.origin),
              tests::placed_support(p.b, p.place_b, u, p.place_b.origin) + tolerance);
  }
}

/// Proves a distance of convex solids: the slab between the closest points separates them. The tolerance is that of the
/// slab's direction: where a surface is curved, points 1e-8 apart are equally near within rounding.
void expect_separated(const Pair& p, const Distance& d, double tolerance) {
  if (d.distance <= tolerance) return;
  const dvec3 u = glm::normalize(d.to - d.from);
  EXPECT_LE(tests::placed_support(p.a, p.place_a, u, d.from), tolerance);
  EXPECT_LE(tests::placed_support(p.b, p.place_b, -u, d.to), tolerance);
}

TEST(Closest, SpheresByTheirRadii) {
  Random random(kSeed);
  for (int i = 0; i < 20000; ++i) {
    const double scale = std::pow(10.0, uniform(random, -3.0, 4.0)), far = random() % 2 == 0 ? 1e6 : 10.0;
    const core::Sphere a{float(uniform(random, 0.1, 2.0))}, b{float(uniform(random, 0.1, 2.0))};
    const dvec3 centre = far * tests::random_direction(random);
    const double gap = scale * std::pow(10.0, uniform(random, -9.0, 2.0));
    const double radii = scale * 0.5 * (double(a.diameter) + b.diameter);
    const dvec3 apart = (radii + gap) * tests::random_direction(random);
    const Pair p{a, b, {scale * tests::random_rotation(random), centre}, {core::dmat3(scale), centre + apart}};
    const double exact = glm::length(p.place_b.origin - p.place_a.origin) - radii;
    const Distance d = between(p.a, p.place_a, p.b, p.place_b);
    EXPECT_NEAR(d.distance, exact, 1e-9 * exact + 1e-12 * scale + 1e-14 * far) << text_of(p);
    EXPECT_LE(d.error, 1e-9 * exact + 1e-12 * scale) << text_of(p);
    EXPECT_NEAR(glm::length(d.to - d.from), exact, 1e-9 * exact + 1e-12 * scale + 1e-14 * far);
    if (HasFailure()) return;
  }
}

TEST(Closest, ParallelCylindersAndBoxes) {
  Random random(kSeed);
  for (int i = 0; i < 5000; ++i) {
    const core::Cylinder a{float(uniform(random, 0.1, 1)), 10.0f}, b{float(uniform(random, 0.1, 1)), 4.0f};
    const core::dmat3 turn = tests::random_rotation(random);
    const dvec3 centre = 1e6 * tests::random_direction(random);
    const double gap = std::pow(10.0, uniform(random, -7.0, 2.0)), axes = double(a.radius) + b.radius + gap;
    const dvec3 offset = turn * dvec3(axes, 0, uniform(random, -3, 3));
    EXPECT_NEAR(between(a, {turn, centre}, b, {turn, centre + offset}).distance, gap, 1e-8)
        << "seed " << kSeed << ": " << i;

    dvec3 apart;
    double squared = 0.0;
    const core::Box c{1, 2, 3}, d{3, 1, 2};
    const dvec3 reach = 0.5 * dvec3(4, 3, 5);
    for (int k = 0; k < 3; ++k) {
      apart[k] = uniform(random, -5, 5);
      squared += std::pow(std::max(0.0, std::fabs(apart[k]) - reach[k]), 2);
    }
    const Distance found = between(c, {turn, centre}, d, {turn, centre + turn * apart});
    EXPECT_NEAR(found.distance, std::sqrt(squared), 1e-8) << "seed " << kSeed << ": " << i;
    EXPECT_EQ(found.touching, squared == 0.0) << "seed " << kSeed << ": " << i;
  }
}

TEST(Closest, ConvexSolidsBySeparatingSlabs) {
  Random random(kSeed);
  int apart = 0, touching = 0;
  for (int i = 0; i < 30000; ++i) {
    Pair p;
    const bool adversarial = i % 2 == 1;  // needles and plates of six orders of magnitude
    const Kind kind_a = tests::random_of(tests::kConvexKinds, random),
               kind_b = tests::random_of(tests::kConvexKinds, random);
    p.a = adversarial ? tests::random_primitive(kind_a, random) : tests::ordinary_primitive(kind_a, random);
    p.b = adversarial ? tests::random_primitive(kind_b, random) : tests::ordinary_primitive(kind_b, random);
    const double scale_a = adversarial ? std::pow(10.0, uniform(random, -3, 1)) : 1.0;
    const double scale_b = adversarial ? std::pow(10.0, uniform(random, -3, 1)) : 1.0;
    p.place_a = tests::placement(random, scale_a, 2.0);
    p.place_b = tests::placement(random, scale_b, 2.0);
    const double size = tests::size_of(p.a, p.place_a) + tests::size_of(p.b, p.place_b);
    p.place_b.origin = p.place_a.origin + size * uniform(random, 0.0, 1.5) * tests::random_direction(random);
    const Distance d = between(p.a, p.place_a, p.b, p.place_b);
    const double tolerance = 1e-9 * d.distance + 1e-10 * size;
    expect_separated(p, d, 1e-6 * size);
    expect_within(p, d, tolerance, random);
    EXPECT_LE(d.error, tolerance);
    EXPECT_EQ(d.touching, d.distance == 0.0);
    (d.touching ? touching : apart)++;
    if (HasFailure()) FAIL() << text_of(p) << " distance " << d.distance << " error " << d.error << " size " << size;
  }
  EXPECT_GT(apart, 5000);
  EXPECT_GT(touching, 5000);
}

/// Twice the solid, moved apart along a direction by its width there and `gap`: the distance is at most that.
TEST(Closest, NearlyTouchingSolids) {
  Random random(kSeed);
  for (int i = 0; i < 20000; ++i) {
    Pair p;
    p.a = tests::ordinary_primitive(tests::random_of(tests::kConvexKinds, random), random);
    p.b = tests::ordinary_primitive(tests::random_of(tests::kConvexKinds, random), random);
    p.place_a = tests::placement(random, 1.0, 2.0);
    p.place_b = tests::placement(random, 1.0, 0.0);
    const dvec3 u = tests::random_direction(random);
    const double gap = std::pow(10.0, uniform(random, -9.0, -2.0));
    const double wide = tests::placed_support(p.a, p.place_a, u, p.place_a.origin) +
                        tests::placed_support(p.b, p.place_b, -u, p.place_b.origin);
    p.place_b.origin = p.place_a.origin + u * (wide + gap);
    const Distance d = between(p.a, p.place_a, p.b, p.place_b);
    EXPECT_GE(d.distance, gap - 1e-12);
    EXPECT_LE(d.error, 1e-9 * d.distance + 1e-9);
    expect_separated(p, d, 1e-6);
    if (HasFailure()) FAIL() << text_of(p) << " distance " << d.distance << " gap " << gap << " error " << d.error;
  }
}

/// Distance of a point to the disc of a slice at angle `t`.
double slice_distance(const core::CircularTorus& torus, double t, const dvec3& p) {
  const dvec3 e(std::cos(t), std::sin(t), 0), n(-e.y, e.x, 0), from_centre = p - double(torus.major_radius) * e;
  const double off = glm::dot(from_centre, n), across = glm::length(from_centre - off * n);
  return std::hypot(off, std::max(0.0, across - torus.tube_radius));
}

TEST(Closest, SphereToTorusByItsOwnSlice) {
  Random random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const double tube = uniform(random, 0.05, 0.9);
    const core::CircularTorus torus{1.0f, float(tube), float(uniform(random, 0.1, 6.5))};
    const core::Sphere ball{0.02f};
    const core::dmat3 turn = tests::random_rotation(random);
    const dvec3 centre = (i % 2 == 0 ? 1e6 : 1.0) * tests::random_direction(random);
    const dvec3 local = uniform(random, 0, 3) * tests::random_direction(random);
    const double sweep = core::sweep_angle(torus.angle);
    double angle = std::atan2(local.y, local.x);
    if (angle < 0) angle += core::kFullTurn;
    double exact = std::min(slice_distance(torus, 0.0, local), slice_distance(torus, sweep, local));
    if (angle <= sweep) exact = std::min(exact, slice_distance(torus, angle, local));
    exact = std::max(0.0, exact - 0.01f);
    const Distance d = between(torus, {turn, centre}, ball, {turn, centre + turn * local});
    EXPECT_NEAR(d.distance, exact, 1e-8) << "seed " << kSeed << ": " << i << " tube " << tube;
    EXPECT_LE(d.error, 1e-9) << "seed " << kSeed << ": " << i;
    if (HasFailure()) return;
  }
}

/// A tube wider than its bend sweeps only what lies on its own side of the axis.
TEST(Closest, SpindleTorus) {
  const core::CircularTorus spindle{1.0f, 2.0f, 0.1f};
  const Distance d = between(spindle, {}, core::Sphere{0.5f}, core::translation({-2, 0, 0.5}));
  EXPECT_NEAR(d.distance, 1.75, 1e-9);
  EXPECT_NEAR(d.from.x, 0.0, 1e-7);
  EXPECT_TRUE(between(spindle, {}, core::Sphere{0.5f}, core::translation({2.9, 0.1, 0})).touching);
}

/// How far a point lies outside a snout, by its definition; about 0 on the surface.
double outside_snout(const core::Snout& s, const dvec3& p) {
  const double h = s.height, share = p.z / h;
  const double radius =
      0.5 * (double(s.bottom_radius) + s.top_radius) + (double(s.top_radius) - s.bottom_radius) * share;
  double outside = std::max(-radius, std::hypot(p.x - s.offset_x * share, p.y - s.offset_y * share) - radius);
  const core::EndRange bottom = core::bottom_end_range(s), top = core::top_end_range(s);
  outside = std::max({outside, -0.5 * h + bottom.min - p.z, p.z - 0.5 * h - top.max});
  const dvec3 end(0.5 * s.offset_x, 0.5 * s.offset_y, 0.5 * h), from_bottom = p + end, from_top = p - end;
  const auto plane = [](const dvec3& v, float x, float y) {
    return v.z - std::tan(double(x)) * v.x - std::tan(double(y)) * v.y;
  };
  outside = std::max(outside, -plane(from_bottom, s.bottom_shear_x, s.bottom_shear_y));
  return std::max(outside, plane(from_top, s.top_shear_x, s.top_shear_y));
}

/// Ends that are slanted, cross each other, or are steeper than the cone.
TEST(Closest, SlantedSnouts) {
  Random random(kSeed);
  int rough = 0, points = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto length = [&] { return float(uniform(random, 0.2, 2.0)); };
    const auto slant = [&] { return float(uniform(random, -1.2, 1.2)); };
    const core::Snout s{length(), length(), 2 * length(), 0.5f * slant(), 0.5f * slant(),
                        slant(),  slant(),  slant(),      slant()};
    const dvec3 apart = 6.0 * tests::random_direction(random);
    const Distance d = between(s, {}, core::Sphere{0.2f}, core::translation(apart));
    const bool exact = d.error < 1e-8;
    if (!exact) ++rough;
    // Within the planes' slope of the surface.
    EXPECT_LE(outside_snout(s, d.from), 1e-8) << "seed " << kSeed << ": " << i;
    for (int k = 0; k < 200; ++k) {
      const dvec3 p(uniform(random, -3, 3), uniform(random, -3, 3), uniform(random, -4, 4));
      if (outside_snout(s, p) > 0.0) continue;
      ++points;
      EXPECT_GE(glm::length(p - apart) - 0.1f, d.distance - d.error - 1e-9) << "seed " << kSeed << ": " << i;
    }
    if (HasFailure()) FAIL() << tests::text_of(s, {}) << " error " << d.error;
  }
  EXPECT_GT(rough, 300);
  EXPECT_LT(rough, 2700);
  EXPECT_GT(points, 10000);
}

/// Points of a torus' surface and interior on a grid, in the world relative to `origin`; no point of the solid lies
/// farther than `step` from one of them.
struct Cloud {
  std::vector<dvec3> points;
  double step;
};
Cloud sample(const Primitive& primitive, const Affine& a, const dvec3& origin) {
  constexpr int kA = 64, kB = 12, kC = 3;
  Cloud cloud;
  const auto at = [&](double u, double v, double w) {
    return a.linear * tests::point_at(primitive, u, v, w) + (a.origin - origin);
  };
  // tests::point_at() widens the range of some parameters; the grid is finer than it needs to be.
  std::vector<dvec3> grid;
  for (int i = 0; i <= kA; ++i)
    for (int j = 0; j <= kB; ++j)
      for (int k = 0; k <= kC; ++k) grid.push_back(at(double(i) / kA, double(j) / kB, double(k) / kC));
  const auto index = [](int i, int j, int k) { return (i * (kB + 1) + j) * (kC + 1) + k; };
  double largest = 0.0;  // of a cell's sides along each parameter
  double sides[3] = {};
  for (int i = 0; i <= kA; ++i)
    for (int j = 0; j <= kB; ++j)
      for (int k = 0; k <= kC; ++k) {
        const dvec3& p = grid[index(i, j, k)];
        if (i < kA) sides[0] = std::max(sides[0], glm::length(grid[index(i + 1, j, k)] - p));
        if (j < kB) sides[1] = std::max(sides[1], glm::length(grid[index(i, j + 1, k)] - p));
        if (k < kC) sides[2] = std::max(sides[2], glm::length(grid[index(i, j, k + 1)] - p));
      }
  largest = 0.5 * (sides[0] + sides[1] + sides[2]) * 1.1;  // curved sides are a little longer than their chords
  cloud.points = std::move(grid);
  cloud.step = largest;
  return cloud;
}

TEST(Closest, ToriByDenseSamples) {
  Random random(kSeed);
  constexpr Kind kTori[] = {Kind::kCircularTorus, Kind::kRectangularTorus};
  int apart = 0;
  for (int i = 0; i < 60; ++i) {
    Pair p;
    p.a = tests::ordinary_primitive(kTori[i % 2], random);
    p.b = tests::ordinary_primitive(
        i % 3 == 0 ? tests::random_of(kTori, random) : tests::random_of(tests::kSolidKinds, random), random);
    p.place_a = tests::placement(random, 1.0, 2.0);
    p.place_b = tests::placement(random, 0.5, 0.0);
    p.place_b.origin = p.place_a.origin + uniform(random, 0.0, 4.0) * tests::random_direction(random);
    const Distance d = between(p.a, p.place_a, p.b, p.place_b);
    const Cloud a = sample(p.a, p.place_a, p.place_a.origin), b = sample(p.b, p.place_b, p.place_a.origin);
    double least = 1e300;
    for (const dvec3& x : a.points)
      for (const dvec3& y : b.points) least = std::min(least, glm::dot(x - y, x - y));
    least = std::sqrt(least);
    EXPECT_LE(d.distance, least + 1e-12);
    EXPECT_GE(d.distance + a.step + b.step, least);
    EXPECT_LE(d.error, 1e-9 * (1.0 + d.distance));
    expect_within(p, d, 1e-11, random);
    if (!d.touching) ++apart;
    if (HasFailure())
      FAIL() << text_of(p) << " distance " << d.distance << " samples " << least << " error " << d.error;
  }
  EXPECT_GT(apart, 20);
}

/// A pair at another scale, turned, mirrored and 1,000 km away, is so much farther apart.
TEST(Closest, ScaledMirroredAndFar) {
  Random random(kSeed);
  for (int i = 0; i < 3000; ++i) {
    Pair p;
    p.a = tests::ordinary_primitive(tests::random_of(tests::kSolidKinds, random), random);
    p.b = tests::ordinary_primitive(tests::random_of(tests::kSolidKinds, random), random);
    p.place_a = tests::placement(random, 1.0, 2.0);
    p.place_b = tests::placement(random, 1.0, 2.0);
    const double scale = std::pow(10.0, uniform(random, -3.0, 4.0));
    Affine other{scale * tests::random_rotation(random), 1e6 * tests::random_direction(random)};
    if (i % 2 == 0) other.linear[2] = -other.linear[2];
    const Distance near = between(p.a, p.place_a, p.b, p.place_b);
    const Distance far = between(p.a, other * p.place_a, p.b, other * p.place_b);
    EXPECT_NEAR(far.distance, scale * near.distance, 2e-9 * scale + 1e-8) << text_of(p) << " scale " << scale;
    if (HasFailure()) return;
  }
}

/// The distance does not depend on the order, and a part of an item is not nearer than the item.
TEST(Closest, SlicesOfTheSameTorus) {
  Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    const core::Primitive other = tests::ordinary_primitive(tests::random_of(tests::kSolidKinds, random), random);
    const float turn = float(uniform(random, 1.0, 6.0));
    const core::CircularTorus whole{1.0f, 0.2f, turn}, first{1.0f, 0.2f, 0.4f * turn},
        rest{1.0f, 0.2f, turn - 0.4f * turn};
    const Affine place = tests::placement(random, 1.0, 1e3);
    Affine beside = tests::placement(random, 0.5, 0.0);
    beside.origin = place.origin + uniform(random, 0.0, 3.0) * tests::random_direction(random);
    const double start = 0.4f * turn;
    const Affine turned =
        place * Affine{{std::cos(start), std::sin(start), 0, -std::sin(start), std::cos(start), 0, 0, 0, 1}, {}};
    const double least =
        std::min(between(first, place, other, beside).distance, between(rest, turned, other, beside).distance);
    EXPECT_NEAR(between(whole, place, other, beside).distance, least, 1e-6) << "seed " << kSeed << ": " << i;
    EXPECT_NEAR(between(other, beside, first, place).distance, between(first, place, other, beside).distance, 1e-9);
    if (HasFailure()) return;
  }
}

TEST(Closest, DegenerateItemsDoNotFail) {
  Random random(kSeed);
  for (int i = 0; i < 3000; ++i) {
    Pair p;
    for (Primitive* primitive : {&p.a, &p.b}) {
      *primitive = tests::ordinary_primitive(tests::random_of(tests::kSolidKinds, random), random);
      std::vector<float> values(core::parameters(*primitive).begin(), core::parameters(*primitive).end());
      for (float& value : values)
        if (random() % 3 == 0) value = 0.0f;
      *primitive = core::make_primitive(core::kind_of(*primitive), values);
    }
    for (Affine* a : {&p.place_a, &p.place_b}) {
      *a = tests::placement(random, 1.0, 2.0);
      if (random() % 4 == 0) a->linear[int(random() % 3)] = dvec3(0.0);
      if (random() % 16 == 0) a->linear = core::dmat3(0.0);
    }
    const Distance d = between(p.a, p.place_a, p.b, p.place_b);
    ASSERT_TRUE(std::isfinite(d.distance) && core::is_finite(d.from) && core::is_finite(d.to)) << text_of(p);
    ASSERT_NEAR(glm::length(d.to - d.from), d.distance, 1e-9) << text_of(p);
    ASSERT_LE(d.error, 1e-6) << text_of(p);
  }
}

}  // namespace
}  // namespace sightline::closest_test
