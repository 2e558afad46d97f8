#include "sightline/core/camera_path.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace sightline::core::camera_path_test
