// The walkthrough's camera: every motion against what it means, and recorded paths.
#include "sightline/apps/common/camera_control.h"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace sightline::apps {
namespace {

using core::dvec2;
using core::dvec3;

constexpr double kPi = std::numbers::pi;
constexpr double kFieldOfView = kPi / 4;

/// 100 m long, in coordinates of a survey.
core::AabbD plant() {
  return {{3e6, 7e6, 100.0}, {3e6 + 80.0, 7e6 + 48.0, 136.0}};
}

double distance(const core::Pose& pose) {
  return glm::length(pose.target - pose.eye);
}
dvec3 forward(const core::Pose& pose) {
  return (pose.target - pose.eye) / distance(pose);
}

class CameraControlTest : public ::testing::Test {
 protected:
  static void expect_near(const dvec3& a, const dvec3& b, double tolerance = 1e-6) {
    EXPECT_LE(glm::length(a - b), tolerance)
        << a.x << ' ' << a.y << ' ' << a.z << " and " << b.x << ' ' << b.y << ' ' << b.z;
  }
  /// Looks north from 10 m south of the centre.
  void look_north() { camera.set_pose({{3e6, 7e6, 110.0}, {3e6, 7e6 + 10.0, 110.0}, {0, 0, 1}}); }

  CameraControl camera{plant(), kFieldOfView, 1.5};
};

TEST_F(CameraControlTest, FittingShowsEveryCorner) {
  for (const core::AabbD& box : {plant(), core::AabbD{{0, 0, 0}, {0, 0, 1e5}}, core::AabbD{{5, 5, 5}, {5, 5, 5}}})
    for (const double aspect : {0.2, 1.0, 3.0}) {
      CameraControl fitted(box, kFieldOfView, aspect);
      const auto view = core::View::perspective(fitted.pose(), 1.01 * kFieldOfView, aspect, 1e-4);
      ASSERT_TRUE(view);
      for (int corner = 0; corner < 8; ++corner) {
        const dvec3 p(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                      corner & 4 ? box.max.z : box.min.z);
        const core::dvec4 clip = view->clip_from_world() * core::dvec4(p, 1.0);
        EXPECT_LE(std::abs(clip.x), clip.w);
        EXPECT_LE(std::abs(clip.y), clip.w);
      }
    }
}

TEST_F(CameraControlTest, AnEmptyModelHasACamera) {
  CameraControl empty({}, kFieldOfView, 1.5);
  EXPECT_TRUE(core::View::perspective(empty.pose(), kFieldOfView, 1.5, 0.1));
  EXPECT_GT(empty.speed(), 0.0);
}

TEST_F(CameraControlTest, KeysFlyAtTheSpeedOfTheModelsSize) {
  EXPECT_NEAR(camera.speed(), 12.5, 1e-9);
  look_north();
  const core::Pose before = camera.pose();
  const std::pair<dvec3, dvec3> steps[] = {{{1, 0, 0}, {1, 0, 0}}, {{0, 1, 0}, {0, 1, 0}}, {{0, 0, -1}, {0, 0, -1}}};
  for (const auto& [held, direction] : steps) {
    camera.set_pose(before);
    camera.apply({.seconds = 0.2, .move = held});
    expect_near(camera.pose().eye, before.eye + 2.5 * direction);
    expect_near(camera.pose().target, before.target + 2.5 * direction);
  }
}

TEST_F(CameraControlTest, TheWheelChangesTheSpeedOrZooms) {
  look_north();
  camera.apply({.wheel = 3.0});
  EXPECT_NEAR(camera.speed(), 12.5 * 1.25 * 1.25 * 1.25, 1e-9);
  EXPECT_NEAR(distance(camera.pose()), 10.0, 1e-9);
  camera.set_orbiting(true);
  const dvec3 centre = camera.pose().target;
  camera.apply({.wheel = 2.0});
  EXPECT_NEAR(distance(camera.pose()), 6.4, 1e-6);
  camera.apply({.wheel = -2.0});
  EXPECT_NEAR(distance(camera.pose()), 10.0, 1e-6);
  expect_near(camera.pose().target, centre, 0.0);
  for (const double wheel : {1e6, -1e6}) {  // has ends, both ways
    camera.apply({.wheel = wheel});
    EXPECT_TRUE(core::View::perspective(camera.pose(), kFieldOfView, 1.5, 1e-3));
    camera.set_orbiting(false);
    camera.apply({.wheel = wheel});
    EXPECT_GT(camera.speed(), 0.0);
    EXPECT_LE(camera.speed(), 1000.0 + 1e-9);
    camera.set_orbiting(true);
  }
}

TEST_F(CameraControlTest, LookingTurnsTheHead) {
  look_north();
  const dvec3 eye = camera.pose().eye;
  camera.apply({.look = {kPi / 2, 0.0}});
  expect_near(forward(camera.pose()), {1, 0, 0}, 1e-9);  // east
  camera.apply({.look = {0.0, kPi / 4}});
  expect_near(forward(camera.pose()), {std::sqrt(0.5), 0, std::sqrt(0.5)}, 1e-9);
  expect_near(camera.pose().eye, eye, 0.0);
  EXPECT_NEAR(distance(camera.pose()), 10.0, 1e-6);
}

TEST_F(CameraControlTest, OrbitingMovesTheEyeAboutTheCentre) {
  look_north();
  const dvec3 centre = camera.pose().target;
  camera.apply({.orbit = {kPi / 2, 0.0}});
  expect_near(camera.pose().eye, centre + dvec3(-10, 0, 0));  // the model's near side has gone to the right
  camera.apply({.orbit = {0.0, -kPi / 4}});
  expect_near(camera.pose().eye, centre + 10.0 * dvec3(-std::sqrt(0.5), 0, std::sqrt(0.5)));
  expect_near(camera.pose().target, centre, 0.0);

  look_north();
  camera.set_orbiting(true);
  camera.apply({.look = {kPi / 2, 0.0}});
  expect_near(camera.pose().eye, centre + dvec3(-10, 0, 0));
}

TEST_F(CameraControlTest, TheCentreLiesWhereItIsPut) {
  look_north();
  const core::Pose before = camera.pose();
  camera.set_centre(25.0);
  expect_near(camera.pose().eye, before.eye, 0.0);
  expect_near(camera.pose().target, before.eye + dvec3(0, 25, 0));
}

/// Whatever the user does, there is a view: no roll, never upside down, nothing lost.
TEST_F(CameraControlTest, RandomInputsLeaveAUsableCamera) {
  constexpr unsigned kSeed = 3;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  std::uniform_real_distribution<double> around(-1.0, 1.0);
  const auto sometimes = [&](double scale) { return random() % 3 == 0 ? scale * around(random) : 0.0; };
  for (int i = 0; i < 20000; ++i) {
    SCOPED_TRACE(i);
    CameraInput input;
    input.seconds = 0.05;
    input.move = {sometimes(1), sometimes(1), sometimes(1)};
    input.look = {sometimes(4), sometimes(4)};
    input.orbit = {sometimes(4), sometimes(4)};
    input.wheel = sometimes(3);
    camera.set_orbiting(random() % 2 == 0);
    if (random() % 50 == 0) camera.set_centre(std::abs(sometimes(1e9)));
    if (random() % 50 == 0) camera.fit(kFieldOfView, 1.5);
    if (random() % 50 == 0) camera.set_pose({{3e6, 7e6, 200}, {3e6, 7e6, 100}, {0, 1, 0}});  // straight down
    camera.apply(input);
    ASSERT_TRUE(core::View::perspective(camera.pose(), kFieldOfView, 1.5, 1e-3));
    ASSERT_LE(std::abs(forward(camera.pose()).z), 1.0);
  }
}

TEST_F(CameraControlTest, IdleMeansThatNothingMoves) {
  EXPECT_TRUE((CameraInput{.seconds = 1.0}.idle()));
  EXPECT_FALSE((CameraInput{.wheel = 1.0}.idle()));
  EXPECT_FALSE((CameraInput{.move = {0, 0, 1}}.idle()));
  const core::Pose before = camera.pose();
  camera.apply({.seconds = 1.0});
  expect_near(camera.pose().eye, before.eye, 0.0);
  expect_near(camera.pose().target, before.target, 0.0);
}

TEST(PathRecorderTest, KeepsAKeyEachQuarterSecondAndTheLast) {
  PathRecorder recorder;
  EXPECT_FALSE(recorder.path(0.1, 100.0));
  const auto camera_at = [](double time) {
    return core::CameraSample{{{3e6 + time, 7e6, 10}, {3e6 + time, 7e6 + 5.0 + time, 9}, {0, 0, 1}}, 0.5 + 0.01 * time};
  };
  constexpr double kBegin = 1000.0, kStep = 1.0 / 64;
  constexpr int kLast = 200;
  for (int i = 0; i <= kLast; ++i) {
    recorder.add(kBegin + i * kStep, camera_at(i * kStep));
    const auto so_far = recorder.path(0.1, 100.0);
    ASSERT_TRUE(so_far) << so_far.error().message;
    EXPECT_EQ(so_far->end(), i * kStep);
  }
  const auto path = recorder.path(0.1, 100.0);
  ASSERT_TRUE(path);
  EXPECT_EQ(path->begin(), 0.0);
  EXPECT_EQ(path->keys().size(), 14u);  // 0, 0.25 … 3, and 3.125
  EXPECT_EQ(path->near, 0.1);
  EXPECT_EQ(path->far, 100.0);
  for (int i = 0; i <= kLast; ++i) {
    const core::CameraSample there = path->sample(i * kStep), expected = camera_at(i * kStep);
    EXPECT_LE(glm::length(there.pose.eye - expected.pose.eye), 1e-6);
    EXPECT_LE(glm::length(there.pose.target - expected.pose.target), 1e-6);
    EXPECT_NEAR(there.fovy, expected.fovy, 1e-5);
  }
}

}  // namespace
}  // namespace sightline::apps
