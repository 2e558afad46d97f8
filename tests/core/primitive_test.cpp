#include "sightline/core/primitive.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "sightline/tests/core/primitive_samples.h"

namespace sightline::core::primitive_test {
namespace {

using tests::Random;
using tests::uniform;

constexpr double kPi = std::numbers::pi;

Kind kind_at(int i) {
  return static_cast<Kind>(i);
}

/// Which parameters are lengths, of which only the absolute value counts.
constexpr const char* kLengths[kPrimitiveKindCount] = {"1111001", "111",       "1110", "110", "11",
                                                       "11",      "111000000", "11",   "1",   "00"};

/// Largest coordinate that the parameters can make, for tolerances.
double size_of(const Primitive& p) {
  double sum = 0.0;
  for (const float v : parameters(p)) sum += std::abs(double(v));
  return sum;
}

// --- parameters ------------------------------------------------------------------------------------------------------

TEST(Primitive, KindsFollowTheRvmNumbers) {
  // RVM kind number, name, number of parameters: from the format.
  const struct {
    int rvm;
    const char* name;
    int count;
  } expected[] = {{1, "pyramid", 7},
                  {2, "box", 3},
                  {3, "rectangular_torus", 4},
                  {4, "circular_torus", 3},
                  {5, "elliptical_dish", 2},
                  {6, "spherical_dish", 2},
                  {7, "snout", 9},
                  {8, "cylinder", 2},
                  {9, "sphere", 1},
                  {10, "line", 2},
                  {11, "facet_group", 0},
                  {12, "mesh", 0}};
  ASSERT_EQ(std::size(expected), std::size_t(kKindCount));
  for (const auto& e : expected) {
    const Kind kind = kind_at(e.rvm - 1);
    EXPECT_EQ(name_of(kind), e.name);
    if (e.rvm <= kPrimitiveKindCount) {
      EXPECT_EQ(parameter_count(kind), e.count);
    }
  }
  EXPECT_EQ(kind_of(Pyramid{}), Kind::kPyramid);
  EXPECT_EQ(kind_of(Box{}), Kind::kBox);
  EXPECT_EQ(kind_of(RectangularTorus{}), Kind::kRectangularTorus);
  EXPECT_EQ(kind_of(CircularTorus{}), Kind::kCircularTorus);
  EXPECT_EQ(kind_of(EllipticalDish{}), Kind::kEllipticalDish);
  EXPECT_EQ(kind_of(SphericalDish{}), Kind::kSphericalDish);
  EXPECT_EQ(kind_of(Snout{}), Kind::kSnout);
  EXPECT_EQ(kind_of(Cylinder{}), Kind::kCylinder);
  EXPECT_EQ(kind_of(Sphere{}), Kind::kSphere);
  EXPECT_EQ(kind_of(Line{}), Kind::kLine);
}

TEST(Primitive, ParametersComeInFileOrderAndGoBack) {
  for (int k = 0; k < kPrimitiveKindCount; ++k) {
    std::vector<float> values;
    for (int i = 0; i < parameter_count(kind_at(k)); ++i) values.push_back(float(i + 1) + 0.1f);
    const Primitive p = make_primitive(kind_at(k), values);
    EXPECT_EQ(kind_of(p), kind_at(k));
    const auto back = parameters(p);
    EXPECT_TRUE(std::equal(back.begin(), back.end(), values.begin(), values.end())) << name_of(kind_at(k));
  }
  const Primitive p = make_primitive(Kind::kSnout, std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8, 9});
  const Snout& s = std::get<Snout>(p);
  EXPECT_EQ(s.top_radius, 2.0f);
  EXPECT_EQ(s.height, 3.0f);
  EXPECT_EQ(s.offset_y, 5.0f);
  EXPECT_EQ(s.bottom_shear_x, 6.0f);
  EXPECT_EQ(s.top_shear_y, 9.0f);
}

// --- support ---------------------------------------------------------------------------------------------------------

TEST(Primitive, SupportIsReachedByNoPointAndNearlyByTheBest) {
  for (int k = 0; k < kPrimitiveKindCount; ++k)
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      SCOPED_TRACE(testing::Message() << name_of(kind_at(k)) << " seed " << seed);
      Random random(seed * 100 + std::uint64_t(k));
      const Primitive p = tests::random_primitive(kind_at(k), random);
      std::vector<dvec3> points;
      for (int a = 0; a <= 96; ++a)
        for (int b = 0; b <= 48; ++b)
          for (int c = 0; c <= 12; ++c) points.push_back(tests::point_at(p, a / 96.0, b / 48.0, c / 12.0));
      for (int i = 0; i < 2000; ++i) points.push_back(tests::random_point(p, random));
      for (int d = 0; d < 20; ++d) {
        dvec3 u = tests::random_direction(random);
        if (d < 6) (u = dvec3(0.0))[d % 3] = d < 3 ? 1.0 : -1.0;
        double best = -std::numeric_limits<double>::infinity(), least = -best;
        for (const dvec3& q : points) {
          best = std::max(best, glm::dot(u, q));
          least = std::min(least, glm::dot(u, q));
        }
        const double s = support(p, u);
        ASSERT_GE(s, best - 1e-14 * size_of(p));
        ASSERT_LE(s, best + 0.01 * (best - least) + 1e-14 * size_of(p))
            << "direction " << u.x << " " << u.y << " " << u.z;
      }
    }
}

TEST(Primitive, SupportScalesWithItsDirection) {
  Random random(1);
  for (int k = 0; k < kPrimitiveKindCount; ++k)
    for (int i = 0; i < 100; ++i) {
      const Primitive p = tests::random_primitive(kind_at(k), random);
      const dvec3 u = tests::random_direction(random);
      const double scale = std::pow(10.0, uniform(random, -6.0, 6.0));
      EXPECT_NEAR(support(p, scale * u), scale * support(p, u), 1e-12 * scale * size_of(p)) << name_of(kind_at(k));
      EXPECT_NEAR(support(p, dvec3(0.0)), 0.0, 1e-300);
    }
}

TEST(Primitive, NegativeLengthsCountAsPositive) {
  Random random(2);
  for (int k = 0; k < kPrimitiveKindCount; ++k)
    for (int i = 0; i < 100; ++i) {
      const Primitive p = tests::random_primitive(kind_at(k), random);
      const auto values = parameters(p);
      std::vector<float> flipped(values.begin(), values.end());
      for (std::size_t v = 0; v < flipped.size(); ++v)
        if (kLengths[k][v] == '1' && random() % 2) flipped[v] = -flipped[v];
      const Primitive q = make_primitive(kind_at(k), flipped);
      const dvec3 u = tests::random_direction(random);
      EXPECT_EQ(support(p, u), support(q, u)) << name_of(kind_at(k));
      EXPECT_EQ(is_degenerate(p), is_degenerate(q)) << name_of(kind_at(k));
    }
}

TEST(Primitive, TorusArcsOfAnyAngle) {
  // Angles and directions in steps of 15 degrees, so that ends and extremes coincide, and a hair beside them.
  for (int steps = 0; steps <= 24; ++steps)
    for (const double beside : {0.0, -1e-7, 1e-7}) {
      const float angle = float(std::max(0.0, steps * kPi / 12.0 + beside));
      const RectangularTorus box{2.0f, 5.0f, 1.0f, angle};
      const CircularTorus ring{5.0f, 2.0f, angle};
      for (int toward = 0; toward < 24; ++toward)
        for (const double z : {0.0, -0.5, 3.0}) {
          const dvec3 u(std::cos(toward * kPi / 12.0), std::sin(toward * kPi / 12.0), z);
          double rectangle = -1e9, circle = -1e9;
          for (int i = 0; i <= 2000; ++i) {
            const double at = std::min(double(angle), 2.0 * kPi) * i / 2000.0;
            const double w = u.x * std::cos(at) + u.y * std::sin(at);
            rectangle = std::max({rectangle, 2.0 * w, 5.0 * w});
            circle = std::max(circle, 5.0 * w + 2.0 * std::hypot(w, z));
          }
          EXPECT_NEAR(support(box, u), rectangle + 0.5 * std::abs(z), 2e-5) << angle << " toward " << toward;
          EXPECT_NEAR(support(ring, u), circle, 2e-5) << angle << " toward " << toward;
        }
    }
}

TEST(Primitive, TurnsAHairShortAreFull) {
  const float full = float(2.0 * kPi), nearly = 6.283185f, short_of_it = std::nextafter(nearly, 0.0f);
  ASSERT_LT(double(nearly), 2.0 * kPi);
  const auto towards_the_gap = [](float angle) {
    const double middle = 0.5 * (double(angle) - 2.0 * kPi);
    return dvec3(std::cos(middle), std::sin(middle), 0.5);
  };
  for (const float angle : {nearly, -nearly, full, -full, 7.0f, 1e6f}) {
    const dvec3 u = towards_the_gap(nearly);
    EXPECT_EQ(support(CircularTorus{5, 2, angle}, u), support(CircularTorus{5, 2, full}, u)) << angle;
    EXPECT_EQ(support(RectangularTorus{2, 5, 1, angle}, u), support(RectangularTorus{2, 5, 1, full}, u)) << angle;
  }
  for (const float angle : {short_of_it, -short_of_it}) {
    const dvec3 u = towards_the_gap(short_of_it);
    EXPECT_LT(support(CircularTorus{5, 2, angle}, u), support(CircularTorus{5, 2, full}, u)) << angle;
    EXPECT_LT(support(RectangularTorus{2, 5, 1, angle}, u), support(RectangularTorus{2, 5, 1, full}, u)) << angle;
  }
}

TEST(Primitive, HornAndSpindleToriAndBulgingDishes) {
  const float full = float(2.0 * kPi);
  EXPECT_NEAR(support(CircularTorus{1, 1, full}, {1, 0, 0}), 2.0, 1e-12);
  EXPECT_NEAR(support(CircularTorus{1, 3, full}, {0, 0, 1}), 3.0, 1e-12) << "the tube crosses the axis";
  EXPECT_NEAR(support(CircularTorus{1, 3, 0.1f}, {-1, 0, 0}), 2.0, 1e-12);
  EXPECT_NEAR(support(SphericalDish{1, 1}, {1, 0, 0}), 1.0, 1e-12) << "half a sphere";
  EXPECT_NEAR(support(SphericalDish{3, 9}, {1, 0, 0}), 5.0, 1e-12) << "more than half a sphere: its equator";
  EXPECT_NEAR(support(SphericalDish{3, 9}, {0, 0, -1}), 0.0, 1e-12);
  EXPECT_NEAR(support(SphericalDish{0, 4}, {1, 0, 0}), 2.0, 1e-12) << "a whole sphere on a point";
}

TEST(Primitive, NearlyFlatDishesKeepTheirHeight) {
  // The sphere's radius is 5e11: taken from its centre, the pole would be off by more than the dish is high.
  const SphericalDish dish{1000.0f, 1e-6f};
  EXPECT_NEAR(support(dish, {0, 0, 1}), double(dish.height), 1e-18);
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    const dvec3 u(uniform(random, -1, 1) * 1e-9, uniform(random, -1, 1) * 1e-9, 1.0);
    const double s = support(dish, u);
    for (int j = 0; j < 50; ++j) {
      const dvec3 p = tests::random_point(dish, random);
      ASSERT_GE(s * (1 + 1e-9), glm::dot(u, p));
    }
    EXPECT_LE(s, 2.0 * (double(dish.height) + 1000.0 * std::hypot(u.x, u.y)));
  }
}

// --- slanted snouts --------------------------------------------------------------------------------------------------

/// Where the generator at angle direction e meets the end planes, along the way from the bottom circle to the top one.
struct Generator {
  dvec3 from, way;
  double at_bottom, at_top;
  Generator(const Snout& s, const dvec2& e) {
    const double h = std::abs(double(s.height));
    const dvec2 offset(s.offset_x, s.offset_y);
    from = dvec3(-0.5 * offset + std::abs(double(s.bottom_radius)) * e, -0.5 * h);
    way = dvec3(0.5 * offset + std::abs(double(s.top_radius)) * e, 0.5 * h) - from;
    at_bottom = meet(-0.5 * offset, -0.5 * h, s.bottom_shear_x, s.bottom_shear_y);
    at_top = meet(0.5 * offset, 0.5 * h, s.top_shear_x, s.top_shear_y);
  }
  double meet(const dvec2& centre, double z, double shear_x, double shear_y) const {
    const dvec2 m(std::tan(shear_x), std::tan(shear_y));
    const double start = from.z - z - glm::dot(m, dvec2(from) - centre);
    return -start / (way.z - glm::dot(m, dvec2(way)));
  }
};

Snout random_slanted_snout(Random& random, double steepest) {
  Snout s{};
  s.bottom_radius = float(uniform(random, 0.0, 10.0));
  s.top_radius = random() % 4 == 0 ? s.bottom_radius : float(uniform(random, 0.0, 10.0));
  s.height = float(std::pow(10.0, uniform(random, -1.0, 2.0)));
  if (random() % 2) {
    s.offset_x = float(uniform(random, -10.0, 10.0));
    s.offset_y = float(uniform(random, -10.0, 10.0));
  }
  for (float* shear : {&s.bottom_shear_x, &s.bottom_shear_y, &s.top_shear_x, &s.top_shear_y})
    *shear = float(uniform(random, -steepest, steepest));
  return s;
}

/// Least value of the terms 1 - m.s - k m.e of an end: the contour is closed while it is positive.
double openness(const Snout& s, double shear_x, double shear_y) {
  const double h = s.height, slope = (double(s.top_radius) - s.bottom_radius) / h;
  const dvec2 m(std::tan(shear_x), std::tan(shear_y));
  return 1.0 - glm::dot(m, dvec2(s.offset_x, s.offset_y)) / h - std::abs(slope) * glm::length(m);
}

TEST(Primitive, EndRangesAreTheExtremesOfTheContours) {
  int closed = 0, beyond = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Snout s = random_slanted_snout(random, 1.2);
    const bool bottom_closed = openness(s, s.bottom_shear_x, s.bottom_shear_y) > 0.02;
    const bool top_closed = openness(s, s.top_shear_x, s.top_shear_y) > 0.02;
    double low_b = 1e300, high_b = -1e300, low_t = 1e300, high_t = -1e300;
    for (int i = 0; i < 720; ++i) {
      const Generator g(s, {std::cos(i * kPi / 360.0), std::sin(i * kPi / 360.0)});
      low_b = std::min(low_b, g.at_bottom * g.way.z);
      high_b = std::max(high_b, g.at_bottom * g.way.z);
      low_t = std::min(low_t, (g.at_top - 1.0) * g.way.z);
      high_t = std::max(high_t, (g.at_top - 1.0) * g.way.z);
    }
    const EndRange bottom = bottom_end_range(s), top = top_end_range(s);
    const double h = s.height;
    if (bottom_closed) {
      EXPECT_NEAR(bottom.min, low_b, 1e-2 * (1e-9 + high_b - low_b));
      EXPECT_NEAR(bottom.max, high_b, 1e-2 * (1e-9 + high_b - low_b));
    } else if (openness(s, s.bottom_shear_x, s.bottom_shear_y) <= 0.0) {
      EXPECT_EQ(bottom.min, -h);
      EXPECT_EQ(bottom.max, h);
    }
    if (top_closed) {
      EXPECT_NEAR(top.min, low_t, 1e-2 * (1e-9 + high_t - low_t));
      EXPECT_NEAR(top.max, high_t, 1e-2 * (1e-9 + high_t - low_t));
      ++closed;
      beyond += top.max > h;
    } else if (openness(s, s.top_shear_x, s.top_shear_y) <= 0.0) {
      EXPECT_EQ(top.min, -h);
      EXPECT_EQ(top.max, h);
    }
  }
  EXPECT_GT(closed, 500);
  EXPECT_GT(beyond, 100) << "short snouts whose slanted end reaches beyond their height were meant to occur";
}

TEST(Primitive, LevelEndsHaveNoRangeAndMitredShortPipesAllOfTheirs) {
  const Snout level{3, 2, 5, 1, 1, 0, 0, 0, 0};
  EXPECT_EQ(bottom_end_range(level).min, 0.0);
  EXPECT_EQ(top_end_range(level).max, 0.0);
  const Snout mitre{100, 100, 10, 0, 0, 0, 0, float(kPi / 4), 0};
  EXPECT_NEAR(top_end_range(mitre).max, 100.0, 1e-4);
  EXPECT_NEAR(top_end_range(mitre).min, -100.0, 1e-4);
  EXPECT_NEAR(support(mitre, {0, 0, 1}), 105.0, 1e-4);
}

TEST(Primitive, SlantedSnoutsLieWithinTheirSupport) {
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Snout s = random_slanted_snout(random, seed % 2 ? 0.5 : 1.5);
    const double h = s.height;
    const bool bottom_closed = openness(s, s.bottom_shear_x, s.bottom_shear_y) > 0.0;
    const bool top_closed = openness(s, s.top_shear_x, s.top_shear_y) > 0.0;
    const double apex = double(s.bottom_radius) / (double(s.bottom_radius) - s.top_radius);  // where the radius is 0
    std::vector<dvec3> points;
    for (int i = 0; i < 180; ++i) {
      const Generator g(s, {std::cos(i * kPi / 90.0), std::sin(i * kPi / 90.0)});
      // An end without a closed contour is cut one height beyond it.
      double from = bottom_closed ? g.at_bottom : std::max(-1.0, std::min(1.0, g.at_bottom));
      double to = top_closed ? g.at_top : std::min(2.0, std::max(0.0, g.at_top));
      if (apex < 0.0) from = std::max(from, apex);
      if (apex > 1.0) to = std::min(to, apex);
      if (!(from < to)) continue;
      if (!bottom_closed && from < -1.0) continue;
      for (const double t : {0.0, 0.3, 1.0}) points.push_back(g.from + (from + t * (to - from)) * g.way);
    }
    for (int d = 0; d < 30; ++d) {
      dvec3 u = tests::random_direction(random);
      if (d < 6) (u = dvec3(0.0))[d % 3] = d < 3 ? 1.0 : -1.0;
      const double limit = support(s, u);
      for (const dvec3& p : points) ASSERT_LE(glm::dot(u, p), limit + 1e-9 * (size_of(s) + glm::length(p))) << h;
    }
  }
}

TEST(Primitive, SlantedSnoutsAreTightWhereItMatters) {
  // Ordinary mitres: upwards the bound is the contour's own top.
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Snout s = random_slanted_snout(random, 0.4);
    s.offset_x = s.offset_y = 0.0f;
    s.top_radius = s.bottom_radius;
    double highest = -1e300;
    for (int i = 0; i < 720; ++i) {
      const Generator g(s, {std::cos(i * kPi / 360.0), std::sin(i * kPi / 360.0)});
      highest = std::max({highest, (g.from + g.at_top * g.way).z, (g.from + g.at_bottom * g.way).z});
    }
    EXPECT_NEAR(support(s, {0, 0, 1}), highest, 0.01 * std::abs(highest));
    EXPECT_NEAR(support(s, {1, 0, 0}), double(s.bottom_radius), 1e-12);
  }
}

TEST(Primitive, FlatSlantedSnoutsCoverBothTheirDiscs) {
  const Snout s{4, 3, 0, 2, 0, 0.5f, 0, -0.25f, 0.25f};
  const dvec2 slants[] = {{std::tan(0.5), 0.0}, {std::tan(-0.25), std::tan(0.25)}};
  Random random(8);
  for (int i = 0; i < 2000; ++i) {
    const dvec3 u = tests::random_direction(random);
    const double turn = uniform(random, 0, 2 * kPi), limit = support(s, u);
    const dvec2 e(std::cos(turn), std::sin(turn));
    ASSERT_LE(glm::dot(u, dvec3(dvec2(-1, 0) + 4.0 * e, 4.0 * glm::dot(slants[0], e))), limit + 1e-12);
    ASSERT_LE(glm::dot(u, dvec3(dvec2(1, 0) + 3.0 * e, 3.0 * glm::dot(slants[1], e))), limit + 1e-12);
    ASSERT_LE(glm::dot(u, dvec3(dvec2(-1, 0) + 4.0 * e, 0.0)), limit + 1e-12) << "shown level";
  }
}

// --- bounds ----------------------------------------------------------------------------------------------------------

/// The point's image in more precision than bounds() has.
long double image(const Affine& a, const dvec3& p, int axis) {
  long double sum = a.origin[axis];
  for (int c = 0; c < 3; ++c) sum += (long double)(a.linear[c][axis]) * p[c];
  return sum;
}

void expect_contains(const AabbD& box, const Affine& a, const dvec3& p) {
  for (int axis = 0; axis < 3; ++axis) {
    ASSERT_LE((long double)(box.min[axis]), image(a, p, axis)) << "axis " << axis;
    ASSERT_GE((long double)(box.max[axis]), image(a, p, axis)) << "axis " << axis;
  }
}

TEST(Primitive, BoundsContainEveryImagePoint) {
  for (int k = 0; k < kPrimitiveKindCount; ++k)
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      SCOPED_TRACE(testing::Message() << name_of(kind_at(k)) << " seed " << seed);
      Random random(seed * 100 + std::uint64_t(k));
      const Primitive p = tests::random_primitive(kind_at(k), random);
      const double far = seed % 3 == 0 ? 0.0 : std::pow(10.0, uniform(random, 0.0, 7.0));
      Affine a = tests::random_affine(random, 1.0, far);
      if (seed % 5 == 0) a.linear[int(seed / 5) % 3] = dvec3(0.0);  // flattened
      const AabbD box = bounds(p, a);
      ASSERT_FALSE(box.empty());
      for (int i = 0; i < 300; ++i) expect_contains(box, a, tests::random_point(p, random));
      // Tight: the support in the worst axis is at most a few ulps away.
      for (int axis = 0; axis < 3; ++axis) {
        const dvec3 row(a.linear[0][axis], a.linear[1][axis], a.linear[2][axis]);
        const double slack = 1e-14 * (std::abs(a.origin[axis]) + 3.0 * size_of(p));
        EXPECT_NEAR(box.max[axis], a.origin[axis] + support(p, row), slack);
        EXPECT_NEAR(box.min[axis], a.origin[axis] - support(p, -row), slack);
      }
    }
}

TEST(Primitive, BoundsContainPointsWhereLargeTermsCancel) {
  // The row is perpendicular to the lean: what remains of terms near 1e4 is a thin section of 1e-3.
  Random random(6);
  for (int i = 0; i < 3000; ++i) {
    const float far = float(uniform(random, 5e3, 1e4)), thin = 1e-3f;
    Affine a;
    a.linear = {{1, 0, 0}, {0, 1, 0}, {-1, 0.5, 1}};
    const Snout snout{thin, thin, far, far, 0.3f * far, 0, 0, 0, 0};
    const Pyramid pyramid{thin, thin, thin, thin, far, 0.3f * far, far};
    for (const Primitive& p : {Primitive(snout), Primitive(pyramid)}) {
      const AabbD box = bounds(p, a);
      for (int j = 0; j < 20; ++j) expect_contains(box, a, tests::random_point(p, random));
    }
  }
}

TEST(Primitive, BoundsOfABadParameterAreNotFinite) {
  Random random(10);
  for (int k = 0; k < kPrimitiveKindCount; ++k)
    for (int v = 0; v < parameter_count(kind_at(k)); ++v)
      for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        const Primitive good = tests::random_primitive(kind_at(k), random);
        const auto values = parameters(good);
        std::vector<float> broken(values.begin(), values.end());
        broken[std::size_t(v)] = bad;
        const AabbD box = bounds(make_primitive(kind_at(k), broken), {});
        for (int axis = 0; axis < 3; ++axis)
          EXPECT_FALSE(std::isfinite(box.min[axis]) && std::isfinite(box.max[axis])) << name_of(kind_at(k)) << " " << v;
      }
}

// --- degenerate ------------------------------------------------------------------------------------------------------

TEST(Primitive, DegenerateMeansNoVolume) {
  Random random(12);
  for (int k = 0; k < kPrimitiveKindCount; ++k)
    for (int i = 0; i < 50; ++i) EXPECT_FALSE(is_degenerate(tests::random_primitive(kind_at(k), random)));
  const Primitive flat[] = {Cylinder{1, 0},
                            Cylinder{0, 1},
                            Box{1, 0, 1},
                            Sphere{0},
                            Line{2, 2},
                            EllipticalDish{0, 1},
                            EllipticalDish{1, 0},
                            SphericalDish{1, 0},
                            Snout{1, 1, 0, 0, 0, 0, 0, 0, 0},
                            Snout{0, 0, 1, 0, 0, 0, 0, 0, 0},
                            CircularTorus{1, 0, 1},
                            CircularTorus{1, 1, 0},
                            RectangularTorus{1, 1, 1, 1},
                            RectangularTorus{-1, 1, 1, 1},
                            RectangularTorus{1, 2, 0, 1},
                            RectangularTorus{1, 2, 1, 0},
                            Pyramid{1, 1, 1, 1, 0, 0, 0},
                            Pyramid{1, 0, 1, 0, 0, 0, 1},
                            Pyramid{0, 0, 0, 0, 1, 1, 1},
                            Pyramid{0, 0, 1, 0, 0, 0, 1}};
  for (const Primitive& p : flat) EXPECT_TRUE(is_degenerate(p)) << name_of(kind_of(p));
  const Primitive solid[] = {Snout{0, 1, 1, 0, 0, 0, 0, 0, 0}, Snout{1, 1, -1, 0, 0, 0, 0, 0, 0},
                             Pyramid{1, 1, 0, 0, 0, 0, 1},     Pyramid{1, 1, 1, 0, 0, 0, 1},
                             Pyramid{1, 0, 0, 1, 0, 0, 1},     CircularTorus{0, 1, 1},
                             RectangularTorus{2, 1, 1, 1}};
  for (const Primitive& p : solid) EXPECT_FALSE(is_degenerate(p)) << name_of(kind_of(p));
}

TEST(Primitive, DegenerateOnesKeepTheirExtent) {
  const AabbD disc = bounds(Cylinder{2, 0}, translation({1, 1, 1}));
  EXPECT_NEAR(disc.max.x, 3.0, 1e-12);
  EXPECT_NEAR(disc.max.z, 1.0, 1e-12);
  EXPECT_GE(disc.max.z, 1.0);
  const AabbD point = bounds(Sphere{0}, translation({5, 6, 7}));
  EXPECT_FALSE(point.empty());
  EXPECT_NEAR(point.min.y, 6.0, 1e-12);
  EXPECT_NEAR(support(Snout{3, 2, 0, 4, 0, 0, 0, 0, 0}, {1, 0, 0}), 4.0, 1e-12) << "top disc about offset / 2";
  EXPECT_NEAR(support(Snout{3, 2, 0, 4, 0, 0, 0, 0, 0}, {-1, 0, 0}), 5.0, 1e-12) << "bottom disc about -offset / 2";
}

}  // namespace
}  // namespace sightline::core::primitive_test
