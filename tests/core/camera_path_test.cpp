#include "sightline/core/camera_path.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "sightline/core/item_bounds.h"

namespace sightline::core::camera_path_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

std::vector<CameraKey> random_keys(unsigned seed, int count) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> place(-50.0, 50.0), step(0.2, 3.0), fovy(0.3, 2.0);
  std::vector<CameraKey> keys;
  double time = -5.0;
  for (int i = 0; i < count; ++i, time += step(rng)) {
    const dvec3 eye(place(rng), place(rng), place(rng));
    const dvec3 target = eye + dvec3(60.0, place(rng), place(rng));
    keys.push_back({time, {eye, target, {place(rng), place(rng), place(rng)}}, fovy(rng)});
  }
  return keys;
}

CameraPath must(std::vector<CameraKey> keys) {
  auto path = CameraPath::create(std::move(keys));
  EXPECT_TRUE(path.has_value()) << (path ? "" : path.error().message);
  return path ? *path : CameraPath();
}

std::string error_of(std::vector<CameraKey> keys) {
  auto path = CameraPath::create(std::move(keys));
  return path ? "" : path.error().message;
}

CameraKey key_at(double time, const dvec3& eye, const dvec3& target = dvec3(0.0)) {
  return {time, {eye, target, {0, 0, 1}}, 1.0};
}

/// Value, first and second derivative at t, from one side; exact for cubics up to rounding.
struct Jet {
  double value, first, second;
};
Jet one_sided(const std::function<double(double)>& f, double t, double h) {
  const double f0 = f(t), f1 = f(t + h), f2 = f(t + 2 * h), f3 = f(t + 3 * h);
  return {f0, (-11 * f0 + 18 * f1 - 9 * f2 + 2 * f3) / (6 * h), (2 * f0 - 5 * f1 + 4 * f2 - f3) / (h * h)};
}

/// The largest jump of any derivative up to the second over all inner keys.
Jet largest_jump(const std::function<double(double)>& f, const std::vector<CameraKey>& keys, double h) {
  Jet worst{0, 0, 0};
  for (std::size_t i = 1; i + 1 < keys.size(); ++i) {
    const double t = keys[i].time;
    const Jet before = one_sided(f, t, -h), after = one_sided(f, t, h);
    worst.first = std::max(worst.first, std::fabs(before.first - after.first));
    worst.second = std::max(worst.second, std::fabs(before.second - after.second));
    worst.value = std::max(worst.value, std::fabs(f(t - 1e-9) - f(t + 1e-9)));
  }
  return worst;
}

double channel(const CameraSample& s, int c) {
  if (c < 3) return s.pose.eye[c];
  if (c < 6) return s.pose.target[c - 3];
  return std::log(std::tan(0.5 * s.fovy));
}

TEST(CameraPath, MeetsItsKeysExactly) {
  const auto keys = random_keys(11, 12);
  const CameraPath path = must(keys);
  for (const CameraKey& key : keys) {
    const CameraSample s = path.sample(key.time);
    EXPECT_EQ(s.pose.eye, key.pose.eye);
    EXPECT_EQ(s.pose.target, key.pose.target);
    EXPECT_EQ(s.fovy, key.fovy);
    EXPECT_LT(glm::length(s.pose.up - glm::normalize(key.pose.up)), 1e-12);
  }
  EXPECT_EQ(path.begin(), keys.front().time);
  EXPECT_EQ(path.end(), keys.back().time);
}

TEST(CameraPath, ClampsOutsideItsKeys) {
  const auto keys = random_keys(12, 5);
  const CameraPath path = must(keys);
  for (const double t : {-kInf, -1e9, kNaN}) EXPECT_EQ(path.sample(t).pose.eye, keys.front().pose.eye);
  for (const double t : {kInf, 1e9}) EXPECT_EQ(path.sample(t).pose.eye, keys.back().pose.eye);
}

TEST(CameraPath, FramesAreEvenlySpacedFromBeginToEnd) {
  CameraPath path =
      *CameraPath::create({{2.0, {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}}, {6.0, {{4, 0, 0}, {9, 1, 0}, {0, 0, 1}}}});
  EXPECT_EQ(path.time_of(0, 5), 2.0);
  EXPECT_EQ(path.time_of(1, 5), 3.0);
  EXPECT_EQ(path.time_of(4, 5), 6.0);
  EXPECT_EQ(path.time_of(0, 1), 2.0);
  path.near = 0.25;
  path.far = 50.0;
  const CameraSample at = path.sample(3.5);
  const auto view = path.view(3.5, 1.5), same = View::perspective(at.pose, at.fovy, 1.5, 0.25, 50.0);
  ASSERT_TRUE(view && same);
  EXPECT_EQ(view->clip_from_world(), same->clip_from_world());
}

TEST(CameraPath, PositionSpeedAndAccelerationDoNotJump) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto keys = random_keys(seed, 9);
    const CameraPath path = must(keys);
    for (int c = 0; c < 7; ++c) {
      const Jet jump = largest_jump([&](double t) { return channel(path.sample(t), c); }, keys, 0.05);
      EXPECT_LT(jump.value, 1e-5) << "channel " << c;
      EXPECT_LT(jump.first, 1e-8) << "channel " << c;
      EXPECT_LT(jump.second, 1e-6) << "channel " << c;
    }
    for (int c = 0; c < 3; ++c) {
      const Jet jump = largest_jump([&](double t) { return path.sample(t).pose.up[c]; }, keys, 1e-4);
      EXPECT_LT(jump.first, 1e-3) << "up " << c;
      EXPECT_LT(jump.second, 1.0) << "up " << c;
    }
  }
}

TEST(CameraPath, TheJumpCheckSeesWhatACatmullRomSplineDoes) {
  const auto keys = random_keys(3, 9);
  const auto catmull_rom = [&](double t) {
    std::size_t i = 1;
    while (i + 3 < keys.size() && t >= keys[i + 1].time) ++i;
    const double h = keys[i + 1].time - keys[i].time, u = (t - keys[i].time) / h;
    const auto y = [&](std::size_t k) { return keys[k].pose.eye.x; };
    const auto slope = [&](std::size_t k) { return (y(k + 1) - y(k - 1)) / (keys[k + 1].time - keys[k - 1].time); };
    const double u2 = u * u, u3 = u2 * u;
    return (2 * u3 - 3 * u2 + 1) * y(i) + (u3 - 2 * u2 + u) * h * slope(i) + (3 * u2 - 2 * u3) * y(i + 1) +
           (u3 - u2) * h * slope(i + 1);
  };
  const std::vector<CameraKey> inner(keys.begin() + 1, keys.end() - 1);
  EXPECT_GT(largest_jump(catmull_rom, inner, 0.05).second, 1.0);
}

TEST(CameraPath, EndsAreNatural) {
  const auto keys = random_keys(5, 6);
  const CameraPath path = must(keys);
  for (int c = 0; c < 7; ++c) {
    const auto f = [&](double t) { return channel(path.sample(t), c); };
    EXPECT_NEAR(one_sided(f, path.begin(), 0.05).second, 0.0, 1e-6);
    EXPECT_NEAR(one_sided(f, path.end(), -0.05).second, 0.0, 1e-6);
  }
}

TEST(CameraPath, TwoKeysMakeALine) {
  const CameraPath path = must({key_at(0, {0, 0, 5}), key_at(2, {8, 0, 5})});
  EXPECT_LT(glm::length(path.sample(0.5).pose.eye - dvec3(2, 0, 5)), 1e-12);
}

TEST(CameraPath, OneKeyStandsStill) {
  const CameraPath path = must({key_at(3, {1, 2, 3})});
  for (const double t : {-10.0, 3.0, 10.0}) EXPECT_EQ(path.sample(t).pose.eye, dvec3(1, 2, 3));
}

TEST(CameraPath, CoincidentKeysCollapse) {
  const CameraPath path =
      must({key_at(0, {1, 0, 0}), key_at(1, {2, 0, 0}), key_at(1, {2, 0, 0}), key_at(2, {3, 0, 0})});
  EXPECT_EQ(path.keys().size(), 3u);
  EXPECT_LT(glm::length(path.sample(1.5).pose.eye - dvec3(2.5, 0, 0)), 1e-12);
}

TEST(CameraPath, RepeatedPosesAtRisingTimesAreAPause) {
  const CameraPath path = must({key_at(0, {5, 0, 0}), key_at(1, {5, 0, 0}), key_at(2, {5, 0, 0})});
  for (double t = 0; t <= 2; t += 0.1) EXPECT_EQ(path.sample(t).pose.eye, dvec3(5, 0, 0));
}

TEST(CameraPath, AntipodalUpsTurnAboutTheLineOfSight) {
  const Pose up{{0, -5, 0}, {0, 0, 0}, {0, 0, 1}}, down{{0, -5, 0}, {0, 0, 0}, {0, 0, -1}};
  const CameraPath path = must({{0, up, 1}, {1, down, 1}});
  for (double t = 0; t <= 1; t += 0.05) {
    const dvec3 u = path.sample(t).pose.up;
    EXPECT_NEAR(glm::length(u), 1.0, 1e-12);
    EXPECT_NEAR(u.y, 0.0, 1e-12) << "leaves the plane across the line of sight";
  }
  EXPECT_NEAR(std::fabs(path.sample(0.5).pose.up.x), 1.0, 1e-12);
}

TEST(CameraPath, AntipodalUpsAlongTheLineOfSightStayFinite) {
  const Pose a{{0, 0, -5}, {0, 0, 0}, {0, 0, 1}}, b{{0, 0, -5}, {0, 0, 0}, {0, 0, -1}};
  const CameraPath path = must({{0, a, 1}, {1, b, 1}});
  for (double t = 0; t <= 1; t += 0.05) EXPECT_NEAR(glm::length(path.sample(t).pose.up), 1.0, 1e-12);
}

TEST(CameraPath, UpTurnsAlongTheGreatCircle) {
  const Pose a{{5, 0, 0}, {0, 0, 0}, {0, 0, 3}}, b{{5, 0, 0}, {0, 0, 0}, {0, 2, 0}};
  const CameraPath path = must({{0, a, 1}, {1, b, 1}});
  EXPECT_LT(glm::length(path.sample(0.5).pose.up - glm::normalize(dvec3(0, 1, 1))), 1e-12);
  const CameraPath zero = must({{0, {{5, 0, 0}, {0, 0, 0}, {0, 0, 0}}, 1}, {1, a, 1}});
  EXPECT_EQ(zero.sample(0.5).pose.up, dvec3(0, 0, 1)) << "a zero up means z";
}

TEST(CameraPath, EyeThroughTargetKeepsTheLastLineOfSight) {
  const CameraPath path = must({key_at(0, {-4, 0, 0}), key_at(1, {4, 0, 0})});
  const CameraSample s = path.sample(0.5);
  EXPECT_NE(s.pose.eye, s.pose.target);
  EXPECT_LT(glm::length(glm::normalize(s.pose.target - s.pose.eye) - dvec3(1, 0, 0)), 1e-9);
  const dvec3 far(1e7, -1e7, 1e7);
  const CameraPath moved = must({key_at(0, far + dvec3(-4, 0, 0), far), key_at(1, far + dvec3(4, 0, 0), far)});
  const CameraSample m = moved.sample(0.5);
  EXPECT_LT(glm::length(glm::normalize(m.pose.target - m.pose.eye) - dvec3(1, 0, 0)), 1e-6);
}

TEST(CameraPath, ErrorsNameTheKeyAndWhatWasExpected) {
  const CameraKey good = key_at(0, {1, 0, 0});
  const auto second = [&](auto change) {
    CameraKey bad = key_at(1, {2, 0, 0});
    change(bad);
    return error_of({good, bad});
  };
  EXPECT_EQ(error_of({}), "camera path: needs at least one key");
  EXPECT_EQ(second([](CameraKey& k) { k.time = kNaN; }), "camera key 1: time must be a finite number");
  EXPECT_EQ(second([](CameraKey& k) { k.pose.eye.y = kInf; }), "camera key 1: eye must be three finite numbers");
  EXPECT_EQ(second([](CameraKey& k) { k.pose.target.z = kNaN; }), "camera key 1: target must be three finite numbers");
  EXPECT_EQ(second([](CameraKey& k) { k.pose.up.x = -kInf; }), "camera key 1: up must be three finite numbers");
  EXPECT_EQ(second([](CameraKey& k) { k.pose.eye = k.pose.target; }), "camera key 1: eye and target must differ");
  for (const double fovy : {0.0, -1.0, 3.2, kNaN, kInf})
    EXPECT_EQ(second([=](CameraKey& k) { k.fovy = fovy; }),
              "camera key 1: field of view must lie between 0 and pi radians (0 and 180 degrees)");
  EXPECT_EQ(second([](CameraKey& k) { k.time = -1; }),
            "camera key 1: time must not be earlier than that of the key before it");
  EXPECT_EQ(second([](CameraKey& k) { k.time = 0; }),
            "camera key 1: has the time of the key before it but another pose");
  EXPECT_EQ(error_of({key_at(0, {1, 0, 0}), key_at(5e-324, {1e300, 0, 0}), key_at(1, {2, 0, 0})}),
            "camera path: key times are too close together for the distance between their poses");
}

// --- tour ------------------------------------------------------------------------------------------------------------

void expect_flyable(const CameraPath& path, double least_distance) {
  ASSERT_GT(path.keys().size(), 10u);
  EXPECT_GT(path.near, 0.0);
  EXPECT_EQ(path.far, kInfiniteFar);
  for (int i = 0; i <= 1000; ++i) {
    const CameraSample s = path.sample(path.begin() + (path.end() - path.begin()) * i / 1000.0);
    ASSERT_TRUE(is_finite(s.pose.eye) && is_finite(s.pose.target) && is_finite(s.pose.up)) << "sample " << i;
    ASSERT_GT(glm::length(s.pose.target - s.pose.eye), least_distance) << "sample " << i;
    ASSERT_NEAR(glm::length(s.pose.up), 1.0, 1e-9);
    ASSERT_NEAR(s.fovy, path.keys().front().fovy, 1e-9);
    ASSERT_TRUE(View::perspective(s.pose, s.fovy, 1.5, path.near, path.far).has_value()) << "sample " << i;
  }
}

TEST(MakeTour, FliesThroughRandomBoxes) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0), exponent(-3.0, 6.0);
    AabbD box;
    const double far = seed % 3 == 0 ? 1e7 : 10.0, scale = std::pow(10.0, exponent(rng));
    const dvec3 centre = (dvec3(unit(rng), unit(rng), unit(rng)) - 0.5) * far;
    const dvec3 half = dvec3(unit(rng), unit(rng), unit(rng)) * scale;
    box.grow(centre - half);
    box.grow(centre + half);
    if (seed % 5 == 0) box.max[int(seed / 5 % 3)] = box.min[int(seed / 5 % 3)];
    std::vector<dvec3> places;
    for (unsigned i = 0; i < seed % 50; ++i)
      places.push_back(box.min + dvec3(unit(rng), unit(rng), unit(rng)) * box.size());
    const CameraPath path = make_tour(box, places, 10.0 + seed);
    EXPECT_NEAR(path.end() - path.begin(), 10.0 + seed, 1e-9);
    expect_flyable(path, 1e-3 * glm::length(half));
  }
}

TEST(MakeTour, WorksForDegenerateBounds) {
  const double e37 = 1e37;
  const AabbD boxes[] = {{},
                         {dvec3(0), dvec3(0)},
                         {dvec3(1e7), dvec3(1e7)},
                         {dvec3(-e37), dvec3(e37)},
                         {dvec3(-1e300), dvec3(1e300)},
                         {dvec3(e37), dvec3(e37)},
                         {dvec3(0), dvec3(1e-300)},
                         {dvec3(1e7), dvec3(1e7 + 1e-8)},
                         {dvec3(0), dvec3(0, 0, 5)},
                         {dvec3(0), dvec3(7, 3, 0)},
                         {dvec3(-kInf), dvec3(kInf)},
                         {dvec3(kNaN), dvec3(kNaN)}};
  int index = 0;
  for (const AabbD& box : boxes) {
    SCOPED_TRACE("box " + std::to_string(index++));
    expect_flyable(make_tour(box, {}), 0.0);
    expect_flyable(make_tour(box, {dvec3(kNaN), dvec3(1, 2, 3), dvec3(kInf)}), 0.0);
  }
}

TEST(MakeTour, BadDurationFallsBackToAMinute) {
  for (const double duration : {0.0, -1.0, kNaN, kInf}) EXPECT_NEAR(make_tour(AabbD(), {}, duration).end(), 60.0, 1e-9);
}

TEST(MakeTour, IsDeterministicAndVisitsDensePlaces) {
  AabbD box;
  box.grow(dvec3(0));
  box.grow(dvec3(400, 100, 60));
  std::vector<dvec3> places(1000, dvec3(333, 22, 11));
  places.insert(places.end(), 10, dvec3(50, 80, 40));
  const CameraPath a = make_tour(box, places), b = make_tour(box, places);
  ASSERT_EQ(a.keys().size(), b.keys().size());
  bool visits_dense = false, visits_sparse = false;
  for (std::size_t i = 0; i < a.keys().size(); ++i) {
    EXPECT_EQ(a.keys()[i].pose.eye, b.keys()[i].pose.eye);
    visits_dense = visits_dense || glm::length(a.keys()[i].pose.target - dvec3(333, 22, 11)) < 1e-6;
    visits_sparse = visits_sparse || glm::length(a.keys()[i].pose.target - dvec3(50, 80, 40)) < 1e-6;
  }
  EXPECT_TRUE(visits_dense);
  EXPECT_TRUE(visits_sparse);
  bool walks = false;
  for (const CameraKey& key : a.keys()) walks = walks || std::fabs(key.pose.eye.z - 1.7) < 1e-9;
  EXPECT_TRUE(walks) << "nobody walks at eye height";
}

TEST(MakeTour, NearFollowsTheSize) {
  const auto near_of = [](double size) { return make_tour({dvec3(0), dvec3(size, 0, 0)}, {}).near; };
  EXPECT_NEAR(near_of(1000.0), 0.1, 1e-9);
  EXPECT_NEAR(near_of(10.0), 0.01, 1e-9);
  EXPECT_NEAR(near_of(1e7), 10.0, 1e-9);
  EXPECT_NEAR(near_of(0.1), 0.001, 1e-9) << "a small model must not be cut away";
}

TEST(MakeTour, OfItemsStaysWithThemWhateverLiesFarOff) {
  ItemBounds items;
  items.origin = dvec3(1e6, 0.0, 0.0);
  items.resize(5000);
  for (std::size_t i = 0; i < 4990; ++i) {
    const vec3 p(float(i % 100), float(i / 100), 0.0f);
    items.set(i, {p, p + 1.0f});
  }
  const CameraPath near = make_tour(items, items.fitted_bounds(), 30.0);
  EXPECT_NEAR(near.end(), 30.0, 1e-9);
  std::vector<dvec3> places;
  for (std::size_t i = 0; i < 4990; ++i)
    places.push_back(items.origin + 0.5 * (dvec3(items.box(i).min) + dvec3(items.box(i).max)));
  const CameraPath twin = make_tour(items.world_bounds(), places, 30.0);
  ASSERT_EQ(near.keys().size(), twin.keys().size());
  for (std::size_t i = 0; i < twin.keys().size(); ++i) {
    EXPECT_EQ(near.keys()[i].pose.eye, twin.keys()[i].pose.eye);
    EXPECT_EQ(near.keys()[i].pose.target, twin.keys()[i].pose.target);
  }

  items.set(4999, {vec3(1e6f), vec3(1e6f)});
  const CameraPath far = make_tour(items, items.fitted_bounds(), 30.0);
  for (const CameraKey& key : far.keys()) EXPECT_LT(glm::length(key.pose.eye - items.origin), 1000.0);
  EXPECT_TRUE(make_tour(ItemBounds(), ItemBounds().fitted_bounds()).keys().size() > 10u);
}

}  // namespace
}  // namespace sightline::core::camera_path_test
