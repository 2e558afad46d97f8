// The stability suite's reference against crossings worked out by hand and against marching, and its judgement of wrong
// answers.
#include "sightline/apps/bench/stability/reference.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "sightline/apps/bench/stability/cases.h"
#include "sightline/apps/bench/stability/measure.h"

namespace sightline::bench::reference_test {
namespace {

using core::dmat3;
using core::dvec3;
using core::Primitive;
using core::Ray;

constexpr float kWhole = 6.2831855f;

std::vector<Crossing> cross_at(const Primitive& primitive, const Ray& ray, const core::Affine& frame = {}) {
  return reference_crossings(primitive, in_item_frame(frame, ray));
}

/// Each crossing's t to 1e-30 and its normal.
struct Expected {
  Quad t;
  dvec3 normal;
};
void expect_crossings(const std::vector<Crossing>& found, const std::vector<Expected>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_LE(double(fabsq(found[i].t - expected[i].t)), 1e-30) << "t of crossing " << i << ": " << double(found[i].t);
    EXPECT_LE(angle_between(found[i].normal, expected[i].normal), 1e-15) << "normal of crossing " << i;
  }
}

TEST(Polynomial, RootsAreThoseOfItsFactors) {
  // (s - 1)(s + 2)(s - 0.5)(s - 3), its double and its missing roots.
  const Polynomial p = Polynomial(-1, 1) * Polynomial(2, 1) * Polynomial(-0.5, 1) * Polynomial(-3, 1);
  const Roots found = roots(p, -10, 10);
  ASSERT_EQ(found.count, 4);
  const double expected[] = {-2.0, 0.5, 1.0, 3.0};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LE(double(fabsq(found.at[i] - expected[i])), 1e-32);
  EXPECT_EQ(roots(p, -1, 2).count, 2) << "outside the interval";
  const Roots touch = roots(Polynomial(-1, 1) * Polynomial(-1, 1), -10, 10);  // none, or two that rounding made
  EXPECT_TRUE(touch.count == 0 || (touch.count == 2 && touch.at[1] - touch.at[0] < 1e-16));
  EXPECT_EQ(roots(Polynomial(0, 1) * Polynomial(0, 1) + 1, -10, 10).count, 0);
  EXPECT_EQ(roots(Polynomial(0), -1, 1).count, 0);
}

TEST(Reference, CylinderThroughWallAndCaps) {
  const Quad chord = sqrtq(1 - Quad(0.25));
  expect_crossings(cross_at(core::Cylinder{1.0f, 2.0f}, {{-4.0, 0.5, 0.25}, {2.0, 0.0, 0.0}}),
                   {{(4 - chord) / 2, {-std::sqrt(0.75), 0.5, 0.0}}, {(4 + chord) / 2, {std::sqrt(0.75), 0.5, 0.0}}});
  expect_crossings(cross_at(core::Cylinder{1.0f, 2.0f}, {{0.25, 0.5, -3.0}, {0.0, 0.0, 1.0}}),
                   {{2, {0, 0, -1}}, {4, {0, 0, 1}}});
  expect_crossings(cross_at(core::Cylinder{1.0f, 2.0f}, {{1.5, 0.0, -3.0}, {0.0, 0.0, 1.0}}), {});
}

TEST(Reference, SnoutIsOneNappeBetweenSlantedEnds) {
  // A cone of 45 degrees from its apex (0, 0, 1) down; the ray at z = 0.5 meets a circle of radius 0.5.
  const core::Snout cone{2.0f, 0.0f, 2.0f, 0, 0, 0, 0, 0, 0};
  const double s = std::sqrt(0.5);
  expect_crossings(cross_at(cone, {{-3.0, 0.0, 0.5}, {1.0, 0.0, 0.0}}), {{2.5, {-s, 0.0, s}}, {3.5, {s, 0.0, s}}});
  // The other nappe, which a steep end leaves room for.
  expect_crossings(cross_at(core::Snout{2, 0, 2, 0, 0, 0, 0, 0.9f, 0}, {{-3.0, 0.0, 1.5}, {1.0, 0.0, 0.0}}), {});
  // An end slanted by 45 degrees: at x = 0.5 the top plane lies at 1 + 0.5.
  core::Snout slanted{1.0f, 1.0f, 2.0f, 0, 0, 0, 0, float(std::numbers::pi / 4), 0};
  const std::vector<Crossing> found = cross_at(slanted, {{0.5, 0.0, 5.0}, {0.0, 0.0, -1.0}});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(double(found[0].t), 3.5, 1e-7) << "the slant is pi/4 as a float";
  EXPECT_NEAR(angle_between(found[0].normal, {-s, 0.0, s}), 0.0, 1e-7);
  EXPECT_EQ(found[0].face, kTop);
  EXPECT_EQ(double(found[1].t), 6.0);
}

TEST(Reference, TorusRingHornSpindleAndSlice) {
  const Ray across{{-5.0, 0.0, 0.0}, {1.0, 0.0, 0.0}};
  expect_crossings(cross_at(core::CircularTorus{2.0f, 0.5f, kWhole}, across),
                   {{2.5, {-1, 0, 0}}, {3.5, {1, 0, 0}}, {6.5, {-1, 0, 0}}, {7.5, {1, 0, 0}}});
  // A spindle has no inner wall: through it, in once and out once.
  expect_crossings(cross_at(core::CircularTorus{0.5f, 1.0f, kWhole}, across), {{3.5, {-1, 0, 0}}, {6.5, {1, 0, 0}}});
  // Down its axis the dents of a spindle: (rho - R)^2 + z^2 = r^2 at rho = 0.
  const Quad dent = sqrtq(Quad(0.75));
  const std::vector<Crossing> down = cross_at(core::CircularTorus{0.5f, 1.0f, kWhole}, {{0, 0, 5}, {0, 0, -1}});
  ASSERT_EQ(down.size(), 2u);
  EXPECT_LE(double(fabsq(down[0].t - (5 - dent))), 1e-15) << "two sheets of the surface meet there: half the digits";
  // A float short of a full turn, it is closed.
  EXPECT_EQ(cross_at(core::CircularTorus{2.0f, 0.5f, 6.283185f}, {{2.0, -1.0, 0.0}, {0.0, 1.0, 0.0}}).size(), 2u);
  EXPECT_EQ(cross_at(core::CircularTorus{2.0f, 0.5f, 6.2831845f}, {{2.0, -1.0, 0.0}, {0.0, 1.0, 0.0}}).size(), 4u);
  // A quarter: from +X to +Y. Along y = -x + c through both ends' planes.
  const core::CircularTorus quarter{2.0f, 0.5f, float(std::numbers::pi / 2)};
  const std::vector<Crossing> ends = cross_at(quarter, {{2.0, -1.0, 0.0}, {0.0, 1.0, 0.0}});
  ASSERT_EQ(ends.size(), 2u);
  EXPECT_EQ(double(ends[0].t), 1.0);
  EXPECT_EQ(ends[0].face, kBottom);
  EXPECT_NEAR(double(ends[1].t), 1.0 + 1.5, 1e-12);
  EXPECT_EQ(ends[1].face, kSide);
  EXPECT_TRUE(cross_at(quarter, {{-2.0, -5.0, 0.0}, {0.0, 1.0, 0.0}}).empty()) << "not swept";
}

TEST(Reference, BallsAndDishes) {
  expect_crossings(cross_at(core::Sphere{3.0f}, {{0, 0, -4}, {0, 0, 2}}), {{1.25, {0, 0, -1}}, {2.75, {0, 0, 1}}});
  expect_crossings(cross_at(core::EllipticalDish{2.0f, 0.5f}, {{0, 0, -4}, {0, 0, 1}}),
                   {{4, {0, 0, -1}}, {4.5, {0, 0, 1}}});
  // Base 2, height 1: sphere radius 2.5 about z = -1.5.
  const Quad side = sqrtq(Quad(2.5) * 2.5 - 4);
  expect_crossings(cross_at(core::SphericalDish{2.0f, 1.0f}, {{-4, 0, 0.5}, {1, 0, 0}}),
                   {{4 - side, {-0.6, 0, 0.8}}, {4 + side, {0.6, 0, 0.8}}});
  expect_crossings(cross_at(core::SphericalDish{2.0f, 1.0f}, {{-4, 0, -0.5}, {1, 0, 0}}), {});
}

TEST(Reference, FlatSided) {
  expect_crossings(cross_at(core::Box{2, 4, 6}, {{-5, 1, 1}, {1, 0, 0}}), {{4, {-1, 0, 0}}, {6, {1, 0, 0}}});
  // Half-widths 1 below, 0 above, over a height of 2: at z = 0 it is 0.5, and the side leans by 1 : 2.
  const core::Pyramid p{2, 2, 0, 0, 0, 0, 2};
  const double a = 2.0 / std::sqrt(5.0), b = 1.0 / std::sqrt(5.0);
  expect_crossings(cross_at(p, {{-5, 0.1, 0}, {1, 0, 0}}), {{4.5, {-a, 0, b}}, {5.5, {a, 0, b}}});
  expect_crossings(cross_at(core::RectangularTorus{1, 2, 1, kWhole}, {{-5, 0, 0.25}, {1, 0, 0}}),
                   {{3, {-1, 0, 0}}, {4, {1, 0, 0}}, {6, {-1, 0, 0}}, {7, {1, 0, 0}}});
}

TEST(Reference, FlatFormsHaveTwoSidesAndOthersNothing) {
  const Ray down{{0.2, 0.1, 3.0}, {0.0, 0.0, -1.0}};
  for (const Primitive& flat :
       {Primitive(core::Cylinder{1, 0}), Primitive(core::Box{1, 1, 0}),
        Primitive(core::Snout{1, 0.5f, 0, 0, 0, 0, 0, 0, 0}), Primitive(core::EllipticalDish{1, 0}),
        Primitive(core::SphericalDish{1, 0}), Primitive(core::RectangularTorus{0, 1, 0, kWhole})})
    expect_crossings(cross_at(flat, down), {{3, {0, 0, 1}}, {3, {0, 0, -1}}});
  EXPECT_TRUE(cross_at(core::Cylinder{0, 1}, down).empty());
  EXPECT_TRUE(cross_at(core::Sphere{0}, down).empty());
  EXPECT_TRUE(cross_at(core::Cylinder{1, std::numeric_limits<float>::infinity()}, down).empty());
  EXPECT_TRUE(cross_at(core::Cylinder{1, 1}, {{0, 0, 3}, {0, 0, 0}}).empty());
  EXPECT_TRUE(cross_at(core::Cylinder{1, 1}, down, {dmat3(0.0), {}}).empty()) << "singular";
}

TEST(Reference, FramesKeepTheParameter) {
  const dmat3 sheared = {{2, 0, 0}, {1, -3, 0}, {0, 0.5, 0.25}};
  const core::Affine frame{sheared, {1e7, -2e7, 3e6}};
  const Ray local{{-4, 0.5, 0.25}, {2, 0, 0}};
  const Ray world{core::transform_point(frame, local.origin), sheared * local.direction};
  const std::vector<Crossing> a = cross_at(core::Cylinder{1, 2}, local),
                              b = cross_at(core::Cylinder{1, 2}, world, frame);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LE(double(fabsq(a[i].t - b[i].t)), 1e-30);
}

/// Marching in long double: t at which membership changes, by the smallest step of a thousand across the solid.
using LVec = glm::vec<3, long double>;
bool inside(const Primitive& primitive, const LVec& p) {
  const long double rho = std::hypot(p.x, p.y);
  const auto in_sweep = [&](float angle) {
    long double phi = std::atan2(p.y, p.x);
    if (phi < 0) phi += 2.0L * std::numbers::pi_v<long double>;
    return phi <= (long double)angle;
  };
  struct Visitor {
    const LVec& p;
    long double rho;
    const decltype(in_sweep)& swept;
    bool operator()(const core::Cylinder& c) const { return rho <= c.radius && std::fabs(p.z) <= 0.5L * c.height; }
    bool operator()(const core::Snout& s) const {
      const long double part = p.z / s.height, h = 0.5L * s.height;
      const long double radius =
          0.5L * (s.bottom_radius + (long double)s.top_radius) + part * ((long double)s.top_radius - s.bottom_radius);
      const auto above = [&](long double sign, float mx, float my) {
        return p.z - sign * h - std::tan((long double)mx) * (p.x - sign * 0.5L * s.offset_x) -
               std::tan((long double)my) * (p.y - sign * 0.5L * s.offset_y);
      };
      return radius >= 0 && std::hypot(p.x - part * s.offset_x, p.y - part * s.offset_y) <= radius &&
             above(-1, s.bottom_shear_x, s.bottom_shear_y) >= 0 && above(1, s.top_shear_x, s.top_shear_y) <= 0;
    }
    bool operator()(const core::CircularTorus& t) const {
      return std::hypot(rho - t.major_radius, p.z) <= t.tube_radius && swept(t.angle);
    }
    bool operator()(const core::RectangularTorus& t) const {
      return rho <= t.outer_radius && rho >= t.inner_radius && std::fabs(p.z) <= 0.5L * t.height && swept(t.angle);
    }
    bool operator()(const core::Sphere& s) const { return std::hypot(rho, p.z) <= 0.5L * s.diameter; }
    bool operator()(const core::EllipticalDish& d) const {
      return p.z >= 0 && std::hypot(rho / d.base_radius, p.z / d.height) <= 1;
    }
    bool operator()(const core::SphericalDish& d) const {
      const long double h = d.height, radius = ((long double)d.base_radius * d.base_radius + h * h) / (2 * h);
      return p.z >= 0 && std::hypot(rho, p.z - (h - radius)) <= radius;
    }
    bool operator()(const core::Box& b) const {
      return std::fabs(p.x) <= 0.5L * b.size_x && std::fabs(p.y) <= 0.5L * b.size_y &&
             std::fabs(p.z) <= 0.5L * b.size_z;
    }
    bool operator()(const core::Pyramid& q) const {
      const long double up = p.z / q.height + 0.5L;
      const auto within = [&](long double v, float bottom, float top, float offset) {
        return std::fabs(v - (up - 0.5L) * offset) <= 0.5L * (bottom + up * ((long double)top - bottom));
      };
      return std::fabs(p.z) <= 0.5L * q.height && within(p.x, q.bottom_x, q.top_x, q.offset_x) &&
             within(p.y, q.bottom_y, q.top_y, q.offset_y);
    }
    bool operator()(const core::Line&) const { return false; }
  };
  return std::visit(Visitor{p, rho, in_sweep}, primitive);
}

TEST(Reference, AgreesWithMarching) {
  int crossings = 0;
  for (int seed = 0; seed < 450; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random{std::uint64_t(seed)};
    const Primitive primitive = plain_shape(core::Kind(seed % 9), random);
    const SurfacePoint aim = surface_point(primitive, random);
    const dvec3 direction = random.direction();
    const Ray ray{aim.point - 0.3 * aim.normal - 4.0 * direction, direction};
    const std::vector<Crossing> found = cross_at(primitive, ray);
    crossings += int(found.size());

    const auto at = [&](long double t) { return LVec(ray.origin) + t * LVec(ray.direction); };
    std::vector<long double> marched;
    constexpr int kSteps = 4000;
    for (int i = 0; i < kSteps; ++i) {
      long double low = 16.0L * i / kSteps - 4.0L, high = 16.0L * (i + 1) / kSteps - 4.0L;
      const bool within = inside(primitive, at(low));
      if (within == inside(primitive, at(high))) continue;
      for (int k = 0; k < 60; ++k) {
        const long double middle = 0.5L * (low + high);
        (inside(primitive, at(middle)) == within ? low : high) = middle;
      }
      marched.push_back(0.5L * (low + high));
    }
    // A step passes over what is thinner; whatever it finds must be there.
    ASSERT_LE(marched.size(), found.size());
    std::size_t known = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const bool thin =
          (i > 0 && found[i].t - found[i - 1].t < 0.01) || (i + 1 < found.size() && found[i + 1].t - found[i].t < 0.01);
      const bool next = known < marched.size() && std::fabs(double(marched[known] - found[i].t)) < 1e-15;
      ASSERT_TRUE(next || thin) << "crossing " << i << " at " << double(found[i].t);
      known += next;
    }
    ASSERT_EQ(known, marched.size());
  }
  EXPECT_GT(crossings, 600);
}

TEST(Reference, KnowsTies) {
  const Primitive cylinder = core::Cylinder{1, 2};
  const auto tie = [&](const Ray& ray, double band) {
    const QuadRay local = in_item_frame({}, ray);
    return near_tie(reference_crossings(cylinder, local), neighbours(cylinder, local, band));
  };
  const Ray grazing{{-5, 1.0 - 1e-9, 0}, {1, 0, 0}}, rim{{-5, 0, 1.0 - 1e-9}, {1, 0, 0}},
      plain{{-5, 0.5, 0}, {1, 0.02, 0}};
  EXPECT_TRUE(tie(grazing, 1e-8));
  EXPECT_FALSE(tie(grazing, 1e-10));
  EXPECT_TRUE(tie(rim, 1e-8));
  EXPECT_FALSE(tie(rim, 1e-10));
  EXPECT_FALSE(tie(plain, 1e-2));
}

/// Rays at a cylinder, and the right answers to them.
struct Exam {
  std::vector<Sample> samples;
  std::vector<Truth> truths;
  std::vector<Answer> answers;
  Limits limits{1e-9, 1e-9, 1e-12, 0.0};

  Exam() {
    for (const double y : {0.0, 0.5, -0.9, 1.5})
      samples.push_back({core::Cylinder{1, 2}, {}, {{-5, y, 0}, {2, 0, 0}}, 1.0});
    for (const Sample& sample : samples) {
      truths.push_back(find_truth(sample));
      Answer answer;
      for (const Crossing& c : truths.back().crossings) answer.hits.insert({double(c.t), 3.0 * c.normal, c.face});
      answers.push_back(answer);
    }
  }
  CaseErrors judged() const { return judge(samples, truths, answers, limits); }
};

TEST(Judge, PassesRightAnswers) {
  const CaseErrors f = Exam().judged();
  EXPECT_TRUE(f.ok());
  EXPECT_EQ(f.rays, 4);
  EXPECT_EQ(f.hits, 3);
  EXPECT_LE(f.max_t, 1e-15);
}

TEST(Judge, SeesEveryWrongAnswer) {
  Exam exam;
  exam.answers[1].hits.hit[1].t += 1e-3;
  EXPECT_NEAR(exam.judged().max_t, 2e-3, 1e-12) << "radii, not t";
  EXPECT_FALSE(exam.judged().ok());

  exam = Exam();
  exam.answers[0].hits.hit[0].normal = {-1, 1e-3, 0};
  EXPECT_NEAR(exam.judged().max_normal, 1e-3, 1e-8);
  EXPECT_FALSE(exam.judged().ok());

  exam = Exam();
  exam.answers[2].hits.count = 0;
  EXPECT_EQ(exam.judged().false_misses, 1);
  EXPECT_FALSE(exam.judged().ok());

  exam = Exam();
  exam.answers[3] = exam.answers[2];
  EXPECT_EQ(exam.judged().false_hits, 1);
  EXPECT_FALSE(exam.judged().ok());

  exam = Exam();
  exam.answers[0].hits.hit[1].normal.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(exam.judged().not_finite, 1);
  EXPECT_FALSE(exam.judged().ok());
}

TEST(Judge, ForgivesTiesOnly) {
  Exam exam;
  exam.limits.band = 0.2;  // 0.9 and its neighbours at 1.1
  exam.answers[2].hits.count = 0;
  EXPECT_TRUE(exam.judged().ok());
  EXPECT_EQ(exam.judged().ties, 1);
}

TEST(Cases, AimWell) {
  // A good part of the rays of every case has crossings: a suite that misses measures nothing.
  for (const Case& c : stability_cases()) {
    if (c.family == "singular") continue;
    SCOPED_TRACE(std::string(core::name_of(c.kind)) + " " + c.name());
    int hits = 0;
    const std::vector<Sample> samples = make_samples(c, 40, 7);
    for (const Sample& sample : samples) hits += !find_truth(sample).crossings.empty();
    EXPECT_GE(hits, 6);
  }
}

}  // namespace
}  // namespace sightline::bench::reference_test
