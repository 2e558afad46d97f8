// The viewer's camera: every motion against what it means, and recorded paths.
#include "sightline/apps/view/camera.h"

#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace sightline::apps::camera_test {
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

class CameraTest : public ::testing::Test {
 protected:
  static void expect_near(const dvec3& a, const dvec3& b, double tolerance = 1e-6) {
    EXPECT_LE(glm::length(a - b), tolerance)
        << a.x << ' ' << a.y << ' ' << a.z << " and " << b.x << ' ' << b.y << ' ' << b.z;
  }
  /// Looks north from 10 m south of the centre.
  void look_north() { camera.set_pose({{3e6, 7e6, 110.0}, {3e6, 7e6 + 10.0, 110.0}, {0, 0, 1}}); }
  /// Where a point shows: -1 … 1.
  dvec2 place(const dvec3& point) const {
    const core::dvec4 clip = camera.view(1.5)->clip_from_world() * core::dvec4(point, 1.0);
    return {clip.x / clip.w, clip.y / clip.w};
  }

  Camera camera{plant(), kFieldOfView, 1.5};
};

TEST_F(CameraTest, FittingShowsEveryCorner) {
  for (const core::AabbD& box : {plant(), core::AabbD{{0, 0, 0}, {0, 0, 1e5}}, core::AabbD{{5, 5, 5}, {5, 5, 5}}})
    for (const double aspect : {0.2, 1.0, 3.0})
      for (const dvec3& direction : {core::kOverviewDirection, dvec3(0, 0, -1), dvec3(1, 0, 0)}) {
        Camera fitted(box, kFieldOfView, aspect);
        core::ItemBounds items;
        items.origin = box.centre();
        items.resize(1);
        items.set(0, {core::vec3(box.min - items.origin), core::vec3(box.max - items.origin)});
        for (const bool orthographic : {false, true}) {
          fitted.set_orthographic(orthographic);
          fitted.set_fovy(kFieldOfView);
          fitted.show_all(items, direction, aspect);
          expect_near(forward(fitted.pose()), glm::normalize(direction));
          fitted.set_fovy(1.01 * kFieldOfView);
          const auto view = fitted.view(aspect);
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
}

TEST_F(CameraTest, AnEmptyModelHasACamera) {
  Camera empty({}, kFieldOfView, 1.5);
  EXPECT_TRUE(empty.view(1.5));
  EXPECT_GT(empty.speed(), 0.0);
}

TEST_F(CameraTest, FliesAtTheSpeedOfTheModelsSize) {
  EXPECT_NEAR(camera.speed(), 12.5, 1e-9);
  look_north();
  const core::Pose before = camera.pose();
  const std::pair<dvec3, dvec3> steps[] = {{{1, 0, 0}, {1, 0, 0}}, {{0, 1, 0}, {0, 1, 0}}, {{0, 0, -1}, {0, 0, -1}}};
  for (const auto& [held, direction] : steps) {
    camera.set_pose(before);
    camera.fly(held, 0.2);
    expect_near(camera.pose().eye, before.eye + 2.5 * direction);
    expect_near(camera.pose().target, before.target + 2.5 * direction);
  }
}

TEST_F(CameraTest, LookingTurnsTheHead) {
  look_north();
  const dvec3 eye = camera.pose().eye;
  camera.look({kPi / 2, 0.0});
  expect_near(forward(camera.pose()), {1, 0, 0}, 1e-9);  // east
  camera.look({0.0, kPi / 4});
  expect_near(forward(camera.pose()), {std::sqrt(0.5), 0, std::sqrt(0.5)}, 1e-9);
  expect_near(camera.pose().eye, eye, 1e-9);
  EXPECT_NEAR(distance(camera.pose()), 10.0, 1e-6);
}

TEST_F(CameraTest, OrbitingKeepsThePointInTheImage) {
  look_north();
  const dvec3 centre = camera.pose().target;
  camera.orbit({kPi / 2, 0.0}, centre);
  expect_near(camera.pose().eye, centre + dvec3(-10, 0, 0));  // the model's near side has gone to the right
  camera.orbit({0.0, -kPi / 4}, centre);
  expect_near(camera.pose().eye, centre + 10.0 * dvec3(-std::sqrt(0.5), 0, std::sqrt(0.5)));
  for (const bool orthographic : {false, true}) {
    camera.set_orthographic(orthographic);
    for (const dvec3& about : {centre + dvec3(2, 3, 1), centre + dvec3(-1, 4, 2)})
      for (const dvec2& by : {dvec2(0.3, 0.0), dvec2(-1.0, 0.2), dvec2(0.1, -3.0)}) {
        look_north();
        const dvec2 before = place(about);
        camera.orbit(by, about);
        const dvec2 after = place(about);
        EXPECT_LE(glm::length(after - before), 1e-6);
      }
  }
}

TEST_F(CameraTest, PanningAndZoomingFollowThePoint) {
  for (const bool orthographic : {false, true}) {
    camera.set_orthographic(orthographic);
    look_north();
    const dvec3 point = camera.pose().target + dvec3(1, 5, -0.5);
    const dvec2 before = place(point);
    camera.pan({0.1, -0.05}, point);
    EXPECT_LE(glm::length(place(point) - (before + dvec2(0.2 / 1.5, -0.1))), 1e-6) << "parts of the height";
    const dvec2 panned = place(point);
    const double far_away = distance(camera.pose());
    camera.zoom(4.0, point);
    EXPECT_LE(glm::length(place(point) - panned), 1e-6);
    EXPECT_LT(distance(camera.pose()), 0.5 * far_away);
    camera.zoom(-4.0, point);
    EXPECT_NEAR(distance(camera.pose()), far_away, 1e-6);
    for (const double wheel : {1e6, -1e6}) {  // has ends, both ways
      camera.zoom(wheel, point);
      EXPECT_TRUE(camera.view(1.5));
    }
  }
}

TEST_F(CameraTest, OrthographicViewsHaveTheSizeOfPerspectiveOnesAtTheTarget) {
  look_north();
  const dvec3 beside = camera.pose().target + dvec3(2, 0, 1);
  const dvec2 before = place(beside);
  camera.set_orthographic(true);
  EXPECT_LE(glm::length(place(beside) - before), 1e-9);
}

/// Whatever the user does, there is a view: no roll, never upside down, nothing lost.
TEST_F(CameraTest, RandomInputsLeaveAUsableCamera) {
  constexpr unsigned kSeed = 3;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  std::uniform_real_distribution<double> around(-1.0, 1.0);
  const auto sometimes = [&](double scale) { return random() % 3 == 0 ? scale * around(random) : 0.0; };
  for (int i = 0; i < 20000; ++i) {
    SCOPED_TRACE(i);
    const dvec3 at = plant().centre() + dvec3(sometimes(50), sometimes(50), sometimes(50));
    camera.fly({sometimes(1), sometimes(1), sometimes(1)}, 0.05);
    camera.look({sometimes(4), sometimes(4)});
    camera.orbit({sometimes(4), sometimes(4)}, at);
    camera.pan({sometimes(1), sometimes(1)}, at);
    camera.zoom(sometimes(3), at);
    camera.set_orthographic(random() % 2 == 0);
    if (random() % 50 == 0) camera.fit(plant(), 1.5);
    if (random() % 50 == 0) camera.set_pose({{3e6, 7e6, 200}, {3e6, 7e6, 100}, {0, 1, 0}});  // straight down
    ASSERT_TRUE(camera.view(1.5));
    ASSERT_LE(std::abs(forward(camera.pose()).z), 1.0);
  }
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
}  // namespace sightline::apps::camera_test
