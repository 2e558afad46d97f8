// Distances and angles of features, and of meshes, against closed forms and loops over all triangles.
#include "sightline/analysis/measure/distances.h"

#include <cmath>

#include <gtest/gtest.h>

#include "sightline/tests/analysis/measure/measure_samples.h"

namespace sightline::distances_test {
namespace {

using core::dmat3;
using core::dvec3;
using measure::Arc;
using measure::Distance;
using measure::Face;
using measure::Geometry;
using measure::Item;
using measure::Line;
using measure::Segment;
using tests::Random;
using tests::uniform;

constexpr std::uint64_t kSeed = 18;
constexpr double kFar = 1e6;
constexpr double kMicrometre = 1e-6;

/// A placement of features given near the origin: turned, and 1,000 km away.
struct Far {
  explicit Far(Random& random) : turn(tests::random_rotation(random)), origin(kFar * tests::random_direction(random)) {}
  dmat3 turn;
  dvec3 origin;
  dvec3 operator()(const dvec3& p) const { return turn * p + origin; }
  Segment operator()(const Segment& s) const { return {(*this)(s.from), (*this)(s.to)}; }
};

dvec3 random_point(Random& random, double reach) {
  return {uniform(random, -reach, reach), uniform(random, -reach, reach), uniform(random, -reach, reach)};
}

/// Distance of two segments, by the ends and the inner stationary point of its quadratic.
double segment_distance(const Segment& a, const Segment& b) {
  const auto to_segment = [](const dvec3& p, const Segment& s) {
    const dvec3 along = s.to - s.from;
    const double t = std::clamp(glm::dot(p - s.from, along) / glm::dot(along, along), 0.0, 1.0);
    return glm::length(s.from + t * along - p);
  };
  double least = std::min({to_segment(a.from, b), to_segment(a.to, b), to_segment(b.from, a), to_segment(b.to, a)});
  const dvec3 u = a.to - a.from, v = b.to - b.from, w = b.from - a.from, n = glm::cross(u, v);
  const double nn = glm::dot(n, n);
  if (nn > 0.0) {
    const double s = glm::dot(glm::cross(w, v), n) / nn, t = glm::dot(glm::cross(w, u), n) / nn;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) least = std::min(least, std::fabs(glm::dot(w, n)) / std::sqrt(nn));
  }
  return least;
}

TEST(Distances, PointsSegmentsAndLinesFarFromTheOrigin) {
  Random random(kSeed);
  for (int i = 0; i < 5000; ++i) {
    const Far far(random);
    const Segment a{random_point(random, 2), random_point(random, 2)},
        b{random_point(random, 2), random_point(random, 2)};
    EXPECT_NEAR(measure::distance(far(a), far(b)).distance, segment_distance(a, b), 1e-8) << kSeed << ": " << i;
    EXPECT_NEAR(measure::distance(far(a.from), far(b.from)).distance, glm::length(a.from - b.from), 1e-8);
    const dvec3 u = glm::normalize(b.to - b.from), off = a.from - b.from;
    const Line line{far(b.from), far.turn * (b.to - b.from)};
    EXPECT_NEAR(measure::distance(far(a.from), line).distance, glm::length(off - u * glm::dot(off, u)), 1e-8);
    const Segment longer{b.from - 1000.0 * (b.to - b.from), b.from + 1000.0 * (b.to - b.from)};
    const Distance to_line = measure::distance(line, far(a));
    EXPECT_NEAR(to_line.distance, segment_distance(a, longer), 1e-8) << kSeed << ": " << i;
    EXPECT_NEAR(glm::length(to_line.to - to_line.from), to_line.distance, 1e-8);
    if (HasFailure()) return;
  }
}

TEST(Distances, LinesUpToNearlyParallel) {
  Random random(kSeed);
  for (int i = 0; i < 5000; ++i) {
    const Far far(random);
    const double turn = std::pow(10.0, uniform(random, -5.0, 0.0)), apart = uniform(random, 0.0, 10.0);
    const Line a{far({0, 0, 0}), far.turn * dvec3(1, 0, 0)};
    const Line b{far({0, 0, apart}), far.turn * dvec3(std::cos(turn), std::sin(turn), 0)};
    const Distance d = measure::distance(a, b);
    EXPECT_NEAR(d.distance, apart, kMicrometre * 0.1) << kSeed << ": " << i << " turn " << turn;
    EXPECT_NEAR(*measure::angle(a, b), turn, 1e-12) << kSeed << ": " << i;
  }
}

TEST(Distances, AxesOfParallelPipes) {
  Random random(kSeed);
  for (int i = 0; i < 5000; ++i) {
    const Far far(random);
    const double apart = uniform(random, 0.01, 10.0), shift = uniform(random, -3.0, 3.0);
    const Segment a{{0, 0, 0}, {4, 0, 0}}, b{{6 + shift, apart, 0}, {shift, apart, 0}};
    const measure::AxisDistance d = measure::axis_distance(far(a), far(b));
    EXPECT_TRUE(d.parallel) << kSeed << ": " << i;
    EXPECT_NEAR(d.shortest.distance, apart, 1e-8) << kSeed << ": " << i;
    const double middle = 0.5 * (std::max(0.0, shift) + std::min(4.0, 6 + shift));
    EXPECT_LE(glm::length(d.shortest.from - far({middle, 0, 0})), 1e-8) << kSeed << ": " << i;
    EXPECT_LE(glm::length(d.shortest.to - far({middle, apart, 0})), 1e-8) << kSeed << ": " << i;
    const Segment crossing{{0, 0, apart}, {0, 1, apart}};
    const measure::AxisDistance skew = measure::axis_distance(far(a), far(crossing));
    EXPECT_FALSE(skew.parallel);
    EXPECT_NEAR(skew.angle, 0.5 * std::numbers::pi, 1e-9);
    EXPECT_NEAR(skew.shortest.distance, apart, 1e-8) << kSeed << ": " << i;
    EXPECT_NEAR(skew.shortest.rise(), (far.turn * dvec3(0, 0, apart)).z, 1e-8);
  }
}

TEST(Distances, PointsToArcsAndFaces) {
  Random random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const Far far(random);
    const double r = uniform(random, 0.1, 3.0);
    const dvec3 p = random_point(random, 4), u = far.turn * dvec3(r, 0, 0), v = far.turn * dvec3(0, r, 0);
    const double from_axis = std::hypot(p.x, p.y);
    const Arc circle{far(dvec3(0.0)), u, v};
    EXPECT_NEAR(measure::distance(far(p), circle).distance, std::hypot(from_axis - r, p.z), 1e-8) << kSeed << ": " << i;
    double t = std::atan2(p.y, p.x);
    if (t < 0) t += core::kFullTurn;
    Arc quarter = circle;
    quarter.from = 0.5, quarter.to = 2.0;
    double exact = std::min(glm::length(p - r * dvec3(std::cos(0.5), std::sin(0.5), 0)),
                            glm::length(p - r * dvec3(std::cos(2.0), std::sin(2.0), 0)));
    if (t >= 0.5 && t <= 2.0) exact = std::min(exact, std::hypot(from_axis - r, p.z));
    EXPECT_NEAR(measure::distance(quarter, far(p)).distance, exact, 1e-8) << kSeed << ": " << i;

    const Face disc{far(dvec3(0.0)), far.turn * dvec3(0, 0, 1), {}, u, v};
    EXPECT_NEAR(measure::distance(far(p), disc).distance, std::hypot(std::max(0.0, from_axis - r), p.z), 1e-8);
    Face ring = disc;
    ring.inner = 0.5;
    const double off = std::max({0.0, from_axis - r, 0.5 * r - from_axis});
    EXPECT_NEAR(measure::distance(far(p), ring).distance, std::hypot(off, p.z), 1e-8) << kSeed << ": " << i;
    Face square = disc;
    square.corners = {far({-r, -r, 0}), far({r, -r, 0}), far({r, r, 0}), far({-r, r, 0})};
    const dvec3 outside(std::max(0.0, std::fabs(p.x) - r), std::max(0.0, std::fabs(p.y) - r), p.z);
    EXPECT_NEAR(measure::distance(square, far(p)).distance, glm::length(outside), 1e-8) << kSeed << ": " << i;
    if (HasFailure()) return;
  }
}

TEST(Distances, AnglesOfDirectionsAndPlanes) {
  const Segment x{{0, 0, 0}, {2, 0, 0}}, diagonal{{0, 0, 0}, {-1, -1, 0}};
  const Face level{{0, 0, 0}, {0, 0, 1}, {}};
  const Arc upright{{0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  EXPECT_NEAR(*measure::angle(x, diagonal), 0.25 * std::numbers::pi, 1e-15);
  EXPECT_NEAR(*measure::angle(x, level), 0.0, 1e-15);
  EXPECT_NEAR(*measure::angle(upright, x), 0.5 * std::numbers::pi, 1e-15);
  EXPECT_NEAR(*measure::angle(upright, level), 0.5 * std::numbers::pi, 1e-15);
  EXPECT_FALSE(measure::angle(x, dvec3(0.0)));
  EXPECT_FALSE(measure::angle(x, Segment{{1, 1, 1}, {1, 1, 1}}));
}

/// A closed ball of triangles, `rings` from pole to pole.
core::Mesh ball_mesh(int rings, float radius) {
  core::Mesh mesh;
  const int around = 2 * rings;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < around; ++j) {
      const double polar = std::numbers::pi * i / rings, turn = core::kFullTurn * j / around;
      const double flat = i == 0 || i == rings ? 0.0 : std::sin(polar);
      mesh.positions.emplace_back(radius * flat * std::cos(turn), radius * flat * std::sin(turn),
                                  radius * std::cos(polar));
    }
  const auto index = [&](int i, int j) { return std::uint32_t(i * around + j % around); };
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < around; ++j) {
      if (i > 0) mesh.indices.insert(mesh.indices.end(), {index(i, j), index(i + 1, j), index(i, j + 1)});
      if (i + 1 < rings)
        mesh.indices.insert(mesh.indices.end(), {index(i, j + 1), index(i + 1, j), index(i + 1, j + 1)});
    }
  return mesh;
}

/// Each triangle as a face of its own.
double slow_distance(const core::Mesh& mesh, const core::Affine& a, const Item& other) {
  double least = 1e300;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    Face face{{}, {}, {}};
    for (int k = 0; k < 3; ++k)
      face.corners.push_back(core::transform_point(a, dvec3(mesh.positions[mesh.indices[i + k]])));
    face.centre = face.corners[0];
    least = std::min(least, measure::distance(face, other).distance);
  }
  return least;
}

TEST(Distances, MeshesByAllTheirTriangles) {
  Random random(kSeed);
  const core::Mesh mesh = ball_mesh(8, 1.0f);
  for (int i = 0; i < 200; ++i) {
    const core::Affine place = tests::placement(random, 1.0, 1e6);
    const core::Primitive primitive = tests::ordinary_primitive(tests::random_of(tests::kSolidKinds, random), random);
    core::Affine beside = tests::placement(random, 0.5, 0.0);
    beside.origin = place.origin + uniform(random, 1.0, 4.0) * tests::random_direction(random);
    const Item ball = *Item::create(mesh, place), item = *Item::create(primitive, beside);
    const Item other = i % 3 == 0 ? *Item::create(ball_mesh(5, 0.7f), beside) : item;
    const Distance d = measure::distance(ball, other);
    EXPECT_NEAR(d.distance, slow_distance(mesh, place, other), 1e-8) << "seed " << kSeed << ": " << i;
    EXPECT_NEAR(measure::distance(other, ball).distance, d.distance, 1e-8) << "seed " << kSeed << ": " << i;
    EXPECT_NEAR(glm::length(d.to - d.from), d.distance, 1e-8);
    EXPECT_LE(d.error, 1e-8);
    if (HasFailure()) return;
  }
}

TEST(Distances, WhatASolidMeshEnclosesTouchesIt) {
  const core::Mesh mesh = ball_mesh(16, 1.0f);
  core::Mesh open = mesh;
  open.indices.resize(open.indices.size() - 3);
  const core::Affine place = core::translation({kFar, 0, 0});
  const Item ball = *Item::create(mesh, place), shell = *Item::create(open, place);
  const Item grain = *Item::create(core::Sphere{0.2f}, core::translation({kFar + 0.3, 0, 0}));
  const Item small = *Item::create(ball_mesh(8, 0.1f), core::translation({kFar + 0.3, 0, 0}));
  const Item beside = *Item::create(core::Sphere{0.2f}, core::translation({kFar + 3.0, 0, 0}));
  for (const Item& within : {grain, small}) {
    EXPECT_TRUE(measure::distance(ball, within).touching);
    EXPECT_TRUE(measure::distance(within, ball).touching);
    EXPECT_FALSE(measure::distance(shell, within).touching);
    EXPECT_NEAR(measure::distance(shell, within).distance, 0.6, 0.03);
  }
  EXPECT_FALSE(measure::distance(ball, beside).touching);
}

TEST(Distances, TouchingTori) {
  // Two links of a chain, then pushed together along the inside.
  const core::CircularTorus link{1.0f, 0.25f, 6.3f};
  const core::dmat3 upright(1, 0, 0, 0, 0, 1, 0, -1, 0);
  const Item first = *Item::create(link, core::translation({kFar, 0, 0}));
  for (const double shift : {1.1, 1.2, 1.4, 1.49}) {
    const Item second = *Item::create(link, {upright, {kFar + shift, 0, 0}});
    const Distance d = measure::distance(first, second);
    // The second one's nearest point lies on its circle at x = shift - 1, the first one's at x = 1.
    EXPECT_NEAR(d.distance, 2.0 - shift - 0.5, 1e-8) << shift;
    EXPECT_FALSE(d.touching);
  }
  const Distance touching = measure::distance(first, *Item::create(link, {upright, {kFar + 1.6, 0, 0}}));
  EXPECT_TRUE(touching.touching);
  EXPECT_EQ(touching.distance, 0.0);
}

TEST(Distances, EquallyNearSlicesSayTheirError) {
  const core::CircularTorus ring{1.0f, 0.25f, 6.3f};
  const Item around = *Item::create(ring, {}), middle = *Item::create(core::Sphere{0.5f}, {});
  const Distance d = measure::distance(around, middle);
  EXPECT_NEAR(d.distance, 0.5, 1e-8);
  EXPECT_GT(d.error, 1e-10);
  EXPECT_LE(d.error, 1e-7);
}

TEST(Distances, BadItemsAreErrors) {
  EXPECT_FALSE(Item::create(core::Sphere{NAN}, {}));
  EXPECT_FALSE(Item::create(core::Sphere{1.0f}, core::translation({INFINITY, 0, 0})));
  core::Mesh mesh = ball_mesh(4, 1.0f);
  EXPECT_FALSE(Item::create(mesh, core::translation({0, NAN, 0})));
  mesh.indices[0] = 1u << 30;
  EXPECT_FALSE(Item::create(mesh, {}));
  const Item empty = *Item::create(core::Mesh{}, {});
  EXPECT_TRUE(std::isinf(measure::distance(empty, *Item::create(core::Sphere{1.0f}, {})).distance));
  EXPECT_TRUE(std::isinf(measure::distance(Line{{0, 0, 0}, {1, 0, 0}}, empty).distance));
}

}  // namespace
}  // namespace sightline::distances_test
