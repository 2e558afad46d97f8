// Spatial queries against loops over all boxes in long double, and against themselves without a hierarchy.
#include "sightline/culling/queries/spatial_queries.h"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "scenes.h"

namespace sightline::tests::spatial_queries_test {
namespace {

using core::Aabb;
using core::AabbD;
using core::dvec3;
using core::Ray;
using core::Slot;
using culling::SlotDistance;
using culling::SpatialQueries;
using Real = long double;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// How far answers may be off, and how far the twin may: in between, either answer is right.
constexpr Real kPromised = 4e-15L, kTwin = 1e-17L;

enum class Expected { kNo, kYes, kEither };

/// A scene to be asked, with the same boxes without a hierarchy.
struct Asked {
  Scene scene;
  culling::Hierarchy none;
  SpatialQueries queries{scene.bounds, scene.culler->hierarchy()}, linear{scene.bounds, none};

  Asked(std::span<const Aabb> boxes, const dvec3& origin, std::size_t tail) : scene(boxes, origin, tail) {}
  const core::ItemBounds& bounds() const { return scene.bounds; }
  bool on(Slot slot, std::uint32_t layers) const {
    return !bounds().box(slot).empty() && (bounds().layers(slot) & layers) != 0;
  }
  Real low(Slot slot, int axis) const { return Real(bounds().origin[axis]) + bounds().box(slot).min[axis]; }
  Real high(Slot slot, int axis) const { return Real(bounds().origin[axis]) + bounds().box(slot).max[axis]; }
};

Asked random_scene(Random& random, double half) {
  auto boxes = random_boxes(random, std::size_t(magnitude(random, 1.0, 3000.0)), half);
  if (chance(random, 0.4)) spoil(random, boxes);
  const dvec3 origin = chance(random, 0.5) ? dvec3(0.0) : point(random, chance(random, 0.5) ? 1e3 : 1e7);
  Asked asked(boxes, origin, chance(random, 0.5) ? boxes.size() / 5 : 0);
  if (chance(random, 0.5))
    for (std::size_t i = 0; i < boxes.size(); i += 3)
      asked.scene.bounds.set_layers(i, std::uint32_t(whole(random, 1, 3)));
  if (chance(random, 0.3))
    for (std::size_t i = 0; i < boxes.size(); i += 50) asked.scene.bounds.set(i, Aabb{});
  asked.scene.culler->refit();
  return asked;
}

/// Somewhere in the scene, often on a corner of a box as closely as doubles allow.
dvec3 interesting_point(Random& random, const Asked& asked, double half) {
  const dvec3 anywhere = asked.bounds().origin + point(random, 1.5 * half);
  const auto slot = Slot(whole(random, 0, int(asked.bounds().size()) - 1));
  if (asked.bounds().box(slot).empty() || chance(random, 0.4)) return anywhere;
  dvec3 p = anywhere;
  for (int axis = 0; axis < 3; ++axis) {
    if (chance(random, 0.7)) p[axis] = double(chance(random, 0.5) ? asked.low(slot, axis) : asked.high(slot, axis));
    if (chance(random, 0.3)) p[axis] = std::nextafter(p[axis], chance(random, 0.5) ? kInfinity : -kInfinity);
  }
  return p;
}

std::uint32_t random_layers(Random& random) {
  return chance(random, 0.6) ? core::kDefaultLayerMask : std::uint32_t(whole(random, 0, 3));
}

/// kYes where a <= b. Sums of a double and a float may have been rounded: then the last bits of `size` say nothing.
Expected at_most(Real a, Real b, Real size) {
  const Real slack = 2.0L * std::numeric_limits<Real>::epsilon() * size;
  return a <= b - slack ? Expected::kYes : a > b + slack ? Expected::kNo : Expected::kEither;
}
Expected both(Expected a, Expected b) {
  if (a == Expected::kNo || b == Expected::kNo) return Expected::kNo;
  return a == Expected::kYes ? b : a;
}

template <class Expect>
void expect_slots(const Asked& asked, std::uint32_t layers, const std::vector<Slot>& slots, const Expect& expect) {
  ASSERT_EQ(std::adjacent_find(slots.begin(), slots.end(), std::greater_equal<>()), slots.end()) << "not rising";
  for (Slot slot = 0; slot < asked.bounds().size(); ++slot) {
    const bool reported = std::binary_search(slots.begin(), slots.end(), slot);
    const Expected expected = asked.on(slot, layers) ? expect(slot) : Expected::kNo;
    if (expected != Expected::kEither) {
      ASSERT_EQ(reported, expected == Expected::kYes) << "slot " << slot;
    }
  }
}

template <class Check>
void for_random_scenes(const Check& check) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = magnitude(random, 1e-3, 1e5);
    const Asked asked = random_scene(random, half);
    for (int query = 0; query < 12; ++query) {
      SCOPED_TRACE(testing::Message() << "query " << query);
      ASSERT_NO_FATAL_FAILURE(check(random, asked, half));
    }
  }
}

TEST(SpatialQueries, Ranges) {
  std::vector<Slot> slots, linear;
  std::size_t found = 0;
  for_random_scenes([&](Random& random, const Asked& asked, double half) {
    AabbD range;
    range.grow(interesting_point(random, asked, half));
    if (chance(random, 0.8)) range.grow(interesting_point(random, asked, half));
    if (chance(random, 0.2)) range.max[whole(random, 0, 2)] = kInfinity;
    if (chance(random, 0.2)) range.min[whole(random, 0, 2)] = -kInfinity;
    const std::uint32_t layers = random_layers(random);
    const auto size = [&](Slot slot, int i, double limit) {
      const Real o = std::abs(asked.bounds().origin[i]);
      return std::isinf(limit) ? o : o + std::abs(asked.low(slot, i)) + std::abs(asked.high(slot, i));
    };
    asked.queries.intersecting(range, layers, slots);
    asked.linear.intersecting(range, layers, linear);
    ASSERT_EQ(slots, linear);
    found += slots.size();
    ASSERT_NO_FATAL_FAILURE(expect_slots(asked, layers, slots, [&](Slot slot) {
      Expected all = Expected::kYes;
      for (int i = 0; i < 3; ++i) {
        all = both(all, at_most(asked.low(slot, i), range.max[i], size(slot, i, range.max[i])));
        all = both(all, at_most(range.min[i], asked.high(slot, i), size(slot, i, range.min[i])));
      }
      return all;
    })) << "intersecting";
    asked.queries.inside(range, layers, slots);
    asked.linear.inside(range, layers, linear);
    ASSERT_EQ(slots, linear);
    ASSERT_NO_FATAL_FAILURE(expect_slots(asked, layers, slots, [&](Slot slot) {
      Expected all = Expected::kYes;
      for (int i = 0; i < 3; ++i) {
        all = both(all, at_most(range.min[i], asked.low(slot, i), size(slot, i, range.min[i])));
        all = both(all, at_most(asked.high(slot, i), range.max[i], size(slot, i, range.max[i])));
      }
      return all;
    })) << "inside";
  });
  EXPECT_GT(found, 1000u);
}

Real distance_to(const Asked& asked, Slot slot, const dvec3& p) {
  Real squared = 0.0L;
  for (int i = 0; i < 3; ++i) {
    const Real d = std::max({asked.low(slot, i) - p[i], p[i] - asked.high(slot, i), 0.0L});
    squared += d * d;
  }
  return std::sqrt(squared);
}

/// What the rounding of origin + coordinate in the twin may add to a distance.
Real twin_error(const Asked& asked, const dvec3& p) {
  return 4.0L * std::numeric_limits<Real>::epsilon() * (glm::length(asked.bounds().origin) + glm::length(p));
}

TEST(SpatialQueries, Spheres) {
  std::vector<Slot> slots, linear;
  std::size_t found = 0;
  for_random_scenes([&](Random& random, const Asked& asked, double half) {
    const dvec3 p = interesting_point(random, asked, half);
    double radius = chance(random, 0.1) ? 0.0 : half * magnitude(random, 1e-6, 2.0);
    if (chance(random, 0.5)) {  // just far enough for one of them
      const auto slot = Slot(whole(random, 0, int(asked.bounds().size()) - 1));
      if (!asked.bounds().box(slot).empty()) radius = double(distance_to(asked, slot, p));
      if (chance(random, 0.5)) radius = std::nextafter(radius, kInfinity);
    }
    const std::uint32_t layers = random_layers(random);
    asked.queries.around(p, radius, layers, slots);
    asked.linear.around(p, radius, layers, linear);
    ASSERT_EQ(slots, linear);
    found += slots.size();
    const Real error = twin_error(asked, p);
    ASSERT_NO_FATAL_FAILURE(expect_slots(asked, layers, slots, [&](Slot slot) {
      const Real d = distance_to(asked, slot, p);
      if (d <= radius * (1.0L - kTwin) - error || (d == 0.0L && error == 0.0L)) return Expected::kYes;
      return d > radius * (1.0L + kPromised) + error ? Expected::kNo : Expected::kEither;
    }));
  });
  EXPECT_GT(found, 1000u);
}

TEST(SpatialQueries, Nearest) {
  std::vector<SlotDistance> hits, linear;
  for_random_scenes([&](Random& random, const Asked& asked, double half) {
    const dvec3 p = interesting_point(random, asked, half);
    const std::size_t count = chance(random, 0.2) ? asked.bounds().size() : std::size_t(whole(random, 0, 30));
    const std::uint32_t layers = random_layers(random);
    asked.queries.nearest(p, count, layers, hits);
    asked.linear.nearest(p, count, layers, linear);
    ASSERT_EQ(hits, linear);
    std::vector<Real> distances;
    for (Slot slot = 0; slot < asked.bounds().size(); ++slot)
      if (asked.on(slot, layers)) distances.push_back(distance_to(asked, slot, p));
    std::sort(distances.begin(), distances.end());
    ASSERT_EQ(hits.size(), std::min(count, distances.size()));
    const Real error = twin_error(asked, p);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      ASSERT_TRUE(asked.on(hits[i].slot, layers));
      const Real expected = distance_to(asked, hits[i].slot, p);
      ASSERT_LE(std::abs(hits[i].distance - expected), kPromised * expected + error);
      ASSERT_LE(std::abs(hits[i].distance - distances[i]), kPromised * distances[i] + error) << "not the nearest";
      if (i > 0) {
        ASSERT_LE(hits[i - 1].distance, hits[i].distance);
      }
    }
  });
}

// --- rays ------------------------------------------------------------------------------------------------------------

struct Slab {
  Real in, out;         // t
  Real error = 0.0L;    // of both, from the rounding of origin + coordinate
  bool missed = false;  // a parallel slab
  bool clear = true;    // false: a parallel face is closer than that rounding
};

/// Where the ray is inside the box, in > out when nowhere.
Slab interval(const Asked& asked, Slot slot, const Ray& ray) {
  Slab slab{ray.t_min, ray.t_max};
  for (int i = 0; i < 3; ++i) {
    const Real from = asked.low(slot, i) - ray.origin[i], to = asked.high(slot, i) - ray.origin[i];
    const Real d = std::abs(ray.direction[i]) < 1e-150 ? 0.0 : ray.direction[i];
    const Real o = std::abs(asked.bounds().origin[i]);
    const Real error = o == 0.0L ? 0.0L : 2.0L * std::numeric_limits<Real>::epsilon() * (o + std::abs(ray.origin[i]));
    if (d == 0.0L) {
      if (from > error || to < -error)
        slab.missed = true;
      else
        slab.clear = slab.clear && from <= -error && to >= error;
      continue;
    }
    slab.in = std::max(slab.in, std::min(from / d, to / d));
    slab.out = std::min(slab.out, std::max(from / d, to / d));
    slab.error = std::max(slab.error, error / std::abs(d));
  }
  return slab;
}

Ray random_ray(Random& random, const Asked& asked, double half) {
  Ray ray;
  ray.origin = interesting_point(random, asked, half);
  ray.direction = interesting_point(random, asked, half) - ray.origin;
  if (chance(random, 0.4)) ray.direction[whole(random, 0, 2)] = chance(random, 0.5) ? 0.0 : -0.0;
  if (chance(random, 0.2)) {
    const double d = chance(random, 0.5) ? 1.0 : -1.0;
    ray.direction = dvec3(0.0), ray.direction[whole(random, 0, 2)] = d;
  }
  if (chance(random, 0.2)) ray.direction *= magnitude(random, 1e-60, 1e60);
  if (chance(random, 0.3)) ray.t_max = magnitude(random, 1e-3, 2.0);
  if (chance(random, 0.2)) ray.t_min = -ray.t_max;
  if (chance(random, 0.1)) ray.direction = dvec3(0.0);
  return ray;
}

TEST(SpatialQueries, Rays) {
  std::vector<SlotDistance> hits, linear, sorted;
  std::vector<Slot> slots;
  std::size_t found = 0, undecided = 0;
  for_random_scenes([&](Random& random, const Asked& asked, double half) {
    const Ray ray = random_ray(random, asked, half);
    const std::uint32_t layers = random_layers(random);
    asked.queries.along(ray, layers, hits);
    asked.linear.along(ray, layers, linear);
    ASSERT_EQ(hits, linear);
    slots.clear();
    for (const SlotDistance& hit : hits) slots.push_back(hit.slot);
    found += slots.size();
    ASSERT_NO_FATAL_FAILURE(expect_slots(asked, layers, slots, [&](Slot slot) {
      const Slab slab = interval(asked, slot, ray);
      if (slab.missed) return Expected::kNo;
      const auto finite = [](Real t) { return std::isinf(t) ? 0.0L : std::abs(t); };
      const Real size = finite(slab.in) + finite(slab.out);
      if (slab.in > slab.out + kPromised * size + slab.error) return Expected::kNo;
      if (!slab.clear) return ++undecided, Expected::kEither;
      if (slab.error == 0.0L && slab.in == slab.out) return Expected::kYes;  // touching, without rounding
      if (slab.in <= slab.out - kTwin * size - slab.error) return Expected::kYes;
      return ++undecided, Expected::kEither;
    }));
    for (const SlotDistance& hit : hits) {
      const Slab slab = interval(asked, hit.slot, ray);
      if (std::isinf(slab.in))
        ASSERT_EQ(hit.distance, slab.in);
      else
        ASSERT_LE(std::abs(hit.distance - slab.in), kPromised * std::abs(slab.in) + slab.error) << "slot " << hit.slot;
    }
    // In order, and the first of them.
    sorted = hits;
    std::sort(sorted.begin(), sorted.end(), [](const SlotDistance& a, const SlotDistance& b) {
      return a.distance < b.distance || (a.distance == b.distance && a.slot < b.slot);
    });
    asked.queries.first_along(ray, asked.bounds().size(), layers, hits);
    ASSERT_EQ(hits, sorted);
    const auto count = std::size_t(whole(random, 0, 5));
    sorted.resize(std::min(sorted.size(), count));
    asked.queries.first_along(ray, count, layers, hits);
    ASSERT_EQ(hits, sorted);
    asked.linear.first_along(ray, count, layers, hits);
    ASSERT_EQ(hits, sorted);
  });
  EXPECT_GT(found, 1000u);
  EXPECT_LT(undecided, found / 20);
}

// --- by hand ---------------------------------------------------------------------------------------------------------

std::vector<Slot> slots_along(const Asked& asked, const Ray& ray) {
  std::vector<SlotDistance> hits;
  std::vector<Slot> slots;
  asked.queries.along(ray, core::kLayerModel, hits);
  slots.reserve(hits.size());
  for (const SlotDistance& hit : hits) slots.push_back(hit.slot);
  return slots;
}

TEST(SpatialQueries, TouchingIsMeeting) {
  const std::vector<Aabb> unit{{core::vec3(0.0f), core::vec3(1.0f)}};
  const std::vector<Slot> found{0}, none;
  for (const double away : {0.0, 4194304.0}) {
    const Asked asked(unit, dvec3(away), 0);
    std::vector<Slot> slots;
    const auto at = [&](double x, double y, double z) { return dvec3(away + x, away + y, away + z); };
    asked.queries.intersecting({at(1, 1, 1), at(2, 2, 2)}, core::kLayerModel, slots);
    EXPECT_EQ(slots, found);
    asked.queries.intersecting({at(std::nextafter(1.0 + away, 2.0 + away) - away, 1, 1), at(2, 2, 2)},
                               core::kLayerModel, slots);
    EXPECT_EQ(slots, none);
    asked.queries.inside({at(0, 0, 0), at(1, 1, 1)}, core::kLayerModel, slots);
    EXPECT_EQ(slots, found);
    asked.queries.inside({at(0, 0, 0), at(1, 1, std::nextafter(1.0 + away, 0.0) - away)}, core::kLayerModel, slots);
    EXPECT_EQ(slots, none);
    asked.queries.around(at(4, 5, 1), 5.0, core::kLayerModel, slots);
    EXPECT_EQ(slots, found);
    asked.queries.around(at(1, 0.5, 1), 0.0, core::kLayerModel, slots);
    EXPECT_EQ(slots, found);
    // In a face, along an edge, through a corner, up to a face, from a face away, a point on a corner.
    EXPECT_EQ(slots_along(asked, {at(-1, 0.5, 1), {1, 0, 0}}), found);
    EXPECT_EQ(slots_along(asked, {at(-1, 1, 1), {1, 0.0, -0.0}}), found);
    EXPECT_EQ(slots_along(asked, {at(2, 0, 0.5), {-1, 1, 0}}), found);
    EXPECT_EQ(slots_along(asked, {at(-2, 0.5, 0.5), {1, 0, 0}, 0.0, 2.0}), found);
    EXPECT_EQ(slots_along(asked, {at(1, 0.5, 0.5), {1, 0, 0}}), found);
    EXPECT_EQ(slots_along(asked, {at(1, 1, 0), {0, 0, 0}}), found);
    EXPECT_EQ(slots_along(asked, {at(-2, 0.5, 0.5), {1, 0, 0}, 0.0, 1.999}), none);
    EXPECT_EQ(slots_along(asked, {at(-1, 1.001, 0.5), {1, 0, 0}}), none);
    EXPECT_EQ(slots_along(asked, {at(-1, -0.001, 0.5), {1, 0, 0}, -kInfinity}), none);
    EXPECT_EQ(slots_along(asked, {at(1.001, 0.5, 0.5), {1, 0, 0}}), none);
    EXPECT_EQ(slots_along(asked, {at(1.001, 0.5, 0.5), {1, 0, 0}, -kInfinity}), found);
    EXPECT_EQ(slots_along(asked, {at(1, 1, 1.001), {0, 0, 0}}), none);
  }
}

/// The origin's last bits lie far below a float's: rounding before comparing would get these wrong.
TEST(SpatialQueries, RangesAreExactFarAway) {
  const std::vector<Aabb> tiny{{core::vec3(0x1p-40f), core::vec3(0x1p-40f)}};
  const Asked asked(tiny, dvec3(1e7), 0);
  std::vector<Slot> slots;
  asked.queries.intersecting({dvec3(1e7), dvec3(1e7)}, core::kLayerModel, slots);
  EXPECT_TRUE(slots.empty()) << "in double 1e7 + 2^-40 is 1e7";
  const double next = std::nextafter(1e7, 2e7);
  asked.queries.intersecting({dvec3(1e7), dvec3(next)}, core::kLayerModel, slots);
  EXPECT_EQ(slots.size(), 1u);
  asked.queries.inside({dvec3(1e7), dvec3(next)}, core::kLayerModel, slots);
  EXPECT_EQ(slots.size(), 1u);
}

TEST(SpatialQueries, TinyComponentsOfADirectionCountAsZero) {
  const std::vector<Aabb> boxes = {{{-1, 1, -1}, {1, 2, 1}}, {{-1, -2, -1}, {1, -1, 1}}, {{-1, -1, -1}, {1, 1, 1}}};
  const Asked asked(boxes, dvec3(0.0), 0);
  std::vector<SlotDistance> hits;
  const auto met = [&](double y, double x) {
    asked.queries.along({.origin = {0.0, 0.5, 0.0}, .direction = {x, y, 0.0}}, core::kDefaultLayerMask, hits);
    std::size_t beside = 0;  // boxes that the origin is not in
    for (const SlotDistance& hit : hits) beside += hit.distance > 0.0;
    std::ranges::sort(hits, {}, &SlotDistance::distance);
    EXPECT_EQ(hits.size() - beside, 1u) << y;
    return beside;
  };
  const double least = 1.0 / 1e150;
  for (const double tiny : {0.0, 1e-310, 1e-200, std::nextafter(least, 0.0)})
    for (const double x : {0.0, 0.25, -0.25}) {
      EXPECT_EQ(met(tiny, x), 0u) << tiny;
      EXPECT_EQ(met(-tiny, x), 0u) << -tiny;
    }
  for (const double y : {least, 1e-149, 1e-100, 1.0}) {
    EXPECT_EQ(met(y, 0.0), 1u) << y;
    EXPECT_NEAR(hits.back().distance * y, 0.5, 1e-12);
    EXPECT_EQ(met(-y, 0.0), 1u) << -y;
    EXPECT_NEAR(hits.back().distance * y, 1.5, 1e-12);
  }
}

TEST(SpatialQueries, BadQueriesFindNothing) {
  Random random(5);
  const Asked asked(random_boxes(random, 300, 10.0), dvec3(0.0), 50);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Slot> slots{7};
  std::vector<SlotDistance> hits{{7, 0.0}};
  const auto& q = asked.queries;
  const auto nothing = [&] { return slots.empty() && hits.empty(); };
  q.along({dvec3(0.0), dvec3(1.0), 1.0, 0.0}, 1, hits);
  q.intersecting(AabbD{}, 1, slots);
  EXPECT_TRUE(nothing());
  q.inside({dvec3(nan), dvec3(1e9)}, 1, slots), q.along({dvec3(nan), dvec3(1.0)}, 1, hits);
  EXPECT_TRUE(nothing());
  q.around(dvec3(0.0), -1.0, 1, slots), q.along({dvec3(0.0), dvec3(kInfinity)}, 1, hits);
  EXPECT_TRUE(nothing());
  q.around(dvec3(0.0), nan, 1, slots), q.nearest(dvec3(kInfinity), 5, 1, hits);
  EXPECT_TRUE(nothing());
  q.around(dvec3(0.0), kInfinity, 2, slots), q.nearest(dvec3(0.0), 5, 2, hits);
  EXPECT_TRUE(nothing()) << "no such layer";
  q.around(dvec3(0.0), kInfinity, 1, slots), q.nearest(dvec3(1e140), 1000, 1, hits);
  EXPECT_EQ(slots.size(), 300u);
  EXPECT_EQ(hits.size(), 300u);
}

}  // namespace
}  // namespace sightline::tests::spatial_queries_test
