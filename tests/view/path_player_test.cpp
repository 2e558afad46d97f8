// Plays camera paths: times, loops, and stops where somebody else moves the camera.
#include "sightline/apps/view/path_player.h"

#include <gtest/gtest.h>

namespace sightline::apps::path_player_test {
namespace {

/// Two metres a second along x, from second 10 to 14.
core::CameraPath straight() {
  std::vector<core::CameraKey> keys;
  for (int i = 0; i <= 4; ++i) keys.push_back({10.0 + i, {{2.0 * i, 0, 0}, {2.0 * i, 1, 0}, {0, 0, 1}}, 1.0});
  return *core::CameraPath::create(std::move(keys));
}

class PathPlayerTest : public testing::Test {
 protected:
  PathPlayerTest() { player.set_path(straight()); }
  /// Moves the camera; x, or -1 where nothing plays.
  double at(double now) {
    const auto sample = player.next(now, camera);
    if (!sample) return -1.0;
    camera = sample->pose;
    return camera.eye.x;
  }
  PathPlayer player;
  core::Pose camera;
};

TEST_F(PathPlayerTest, PlaysInTheTimeOfThePath) {
  EXPECT_EQ(at(5.0), -1.0) << "nobody has said so";
  player.play();
  EXPECT_EQ(at(100.0), 0.0);
  EXPECT_NEAR(at(101.5), 3.0, 1e-9);
  EXPECT_TRUE(player.playing());
  player.speed = 0.5;
  EXPECT_NEAR(at(102.5), 4.0, 1e-9);
  player.speed = 2.0;
  EXPECT_NEAR(at(103.0), 6.0, 1e-9);
  EXPECT_EQ(at(110.0), 8.0) << "the last place is shown";
  EXPECT_FALSE(player.playing());
  EXPECT_EQ(at(111.0), -1.0);
  player.play();
  EXPECT_EQ(at(200.0), 0.0) << "from its beginning";
}

TEST_F(PathPlayerTest, Loops) {
  player.loop = true;
  player.play();
  EXPECT_EQ(at(0.0), 0.0);
  EXPECT_NEAR(at(5.0), 2.0, 1e-9);
  EXPECT_NEAR(at(4005.5), 3.0, 1e-6);
  player.loop = false;
  EXPECT_EQ(at(4009.0), 8.0);
  EXPECT_FALSE(player.playing());
}

TEST_F(PathPlayerTest, StopsWhereTheCameraIsMoved) {
  for (const core::dvec3& by : {core::dvec3(1e-9, 0, 0), core::dvec3(0, 0, 3)}) {
    player.play();
    EXPECT_EQ(at(0.0), 0.0);
    EXPECT_NEAR(at(1.0), 2.0, 1e-9);
    camera.target += by;
    EXPECT_EQ(at(2.0), -1.0);
    EXPECT_FALSE(player.playing());
  }
  player.play();
  player.set_path(straight());
  EXPECT_FALSE(player.playing());
}

TEST_F(PathPlayerTest, AnInstantIsShownOnce) {
  player.set_path(*core::CameraPath::create({{3.0, {{7, 0, 0}, {7, 1, 0}, {0, 0, 1}}, 1.0}}));
  player.loop = true;
  player.play();
  EXPECT_EQ(at(0.0), 7.0);
  EXPECT_FALSE(player.playing());
}

TEST_F(PathPlayerTest, EvenlySpacedFrames) {
  player.play();
  EXPECT_EQ(player.next_frame(0, 3)->pose.eye.x, 0.0);
  EXPECT_NEAR(player.next_frame(1, 3)->pose.eye.x, 4.0, 1e-9);
  EXPECT_EQ(player.next_frame(2, 3)->pose.eye.x, 8.0);
  EXPECT_FALSE(player.playing());
  EXPECT_FALSE(player.next_frame(3, 3));
  player.play();
  EXPECT_EQ(player.next_frame(0, 1)->pose.eye.x, 0.0);
  EXPECT_FALSE(player.playing());
}

}  // namespace
}  // namespace sightline::apps::path_player_test
