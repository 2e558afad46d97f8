// Walks through scenes of boxes: floors, stairs, walls, doors, holes, beams, and random mazes at any frame rate.
#include "sightline/apps/view/walking.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/tests/support/effort.h"

namespace sightline::apps::walking_test {
namespace {

using core::dvec2;
using core::dvec3;

struct Box {
  dvec3 min, max;
};

/// Both sides of every face are hit.
std::optional<double> hit(const Box& box, const dvec3& origin, const dvec3& direction, double reach) {
  double enter = -std::numeric_limits<double>::infinity(), leave = -enter;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (origin[axis] < box.min[axis] || origin[axis] > box.max[axis]) return std::nullopt;
      continue;
    }
    const double a = (box.min[axis] - origin[axis]) / direction[axis],
                 b = (box.max[axis] - origin[axis]) / direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave || leave < 0.0) return std::nullopt;
  const double t = enter >= 0.0 ? enter : leave;
  return t <= reach ? std::optional(t) : std::nullopt;
}

class World {
 public:
  World& add(const Box& box) {
    boxes_.push_back(box);
    return *this;
  }
  const std::vector<Box>& boxes() const { return boxes_; }
  Walker walker() const {
    return Walker([this](const dvec3& origin, const dvec3& direction, double reach) {
      std::optional<double> nearest;
      for (const Box& box : boxes_)
        if (const auto t = hit(box, origin, direction, nearest.value_or(reach))) nearest = t;
      return nearest;
    });
  }

 private:
  std::vector<Box> boxes_;
};

constexpr double kEye = Walker::kEyeHeight;
const Box kFloor{{-20, -20, -0.2}, {20, 20, 0}};

/// Walks for some seconds, a frame of 20 ms at a time.
dvec3 walk(Walker& walker, dvec3 eye, const dvec2& velocity, double seconds) {
  for (int i = 0; i < int(std::lround(seconds / 0.02)); ++i) eye = walker.move(eye, velocity, 0.02);
  return eye;
}
dvec3 walk(const World& world, const dvec3& eye, const dvec2& velocity, double seconds) {
  Walker walker = world.walker();
  return walk(walker, eye, velocity, seconds);
}

TEST(WalkingTest, FallsToTheFloorAndStaysThere) {
  const World world = World().add(kFloor);
  Walker walker = world.walker();
  dvec3 eye = walker.move({0, 0, 10 + kEye}, {0, 0}, 0.02);
  EXPECT_TRUE(walker.falling());
  double seconds = 0.02;
  for (; walker.falling() && seconds < 10.0; seconds += 0.02) eye = walker.move(eye, {0, 0}, 0.02);
  EXPECT_NEAR(seconds, std::sqrt(2 * 10 / 9.81), 0.05);
  EXPECT_EQ(eye, dvec3(0, 0, kEye));
  EXPECT_EQ(walk(walker, eye, {0, 0}, 1.0), eye);
  EXPECT_EQ(walk(world, {0, 0, kEye - 0.3}, {0, 0}, 0.02).z, kEye) << "lifted out of the floor";
}

TEST(WalkingTest, WithoutAFloorStaysAtItsHeight) {
  const dvec3 there = walk(World(), {1, 2, 3}, {1.5, 0}, 2.0);
  EXPECT_NEAR(glm::length(there - dvec3(4, 2, 3)), 0.0, 1e-9);
}

TEST(WalkingTest, StairsAreWalkedUpAndDownButNoHigherSteps) {
  World stair = World().add(kFloor);
  for (int i = 0; i < 10; ++i) stair.add({{1 + 0.28 * i, -1, 0}, {15, 1, 0.18 * (i + 1)}});
  const dvec3 top = walk(stair, {0, 0, kEye}, {1.5, 0}, 4.0);
  EXPECT_NEAR(top.x, 6.0, 1e-6);
  EXPECT_NEAR(top.z, 1.8 + kEye, 1e-9);
  const dvec3 bottom = walk(stair, top, {-1.5, 0}, 5.0);
  EXPECT_NEAR(bottom.x, -1.5, 1e-6);
  EXPECT_NEAR(bottom.z, kEye, 1e-9);
  for (const double height : {0.39, 0.5, 0.9}) {
    const World step = World().add(kFloor).add({{1, -1, 0}, {15, 1, height}});
    const dvec3 there = walk(step, {0, 0, kEye}, {1.5, 0}, 2.0);
    if (height < Walker::kHighestStep)
      EXPECT_NEAR(there.z, height + kEye, 1e-9);
    else
      EXPECT_LE(there.x, 1.0 - 0.97 * Walker::kRadius) << height;
  }
}

TEST(WalkingTest, WallsStopAndLetSlide) {
  const World world = World().add(kFloor).add({{1, -20, 0}, {1.02, 20, 3}});
  const dvec3 straight = walk(world, {0, 0, kEye}, {4.5, 0}, 3.0);
  EXPECT_NEAR(straight.x, 1.0 - Walker::kRadius, 0.01);
  const dvec3 aslant = walk(world, {0, 0, kEye}, {1.0, 1.0}, 5.0);
  EXPECT_NEAR(aslant.x, 1.0 - Walker::kRadius, 0.01);
  EXPECT_GT(aslant.y, 4.0) << "slides along the wall";
}

TEST(WalkingTest, DoorsArePassedWhereTheBodyFits) {
  for (const double width : {0.8, 0.62, 0.5, 0.2}) {
    const World world =
        World().add(kFloor).add({{1, -20, 0}, {1.2, -width / 2, 3}}).add({{1, width / 2, 0}, {1.2, 20, 3}});
    for (const double y : {0.0, 0.05}) {
      const dvec3 there = walk(world, {0, y, kEye}, {1.5, 0}, 3.0);
      EXPECT_EQ(there.x > 2.0, width > 2.0 * Walker::kRadius) << width << " from " << y << " gets to " << there.x;
    }
  }
}

TEST(WalkingTest, FallsIntoHolesAndStepsOverGaps) {
  for (const double width : {0.1, 0.35, 1.5}) {
    const World world = World()
                            .add({{-20, -20, -0.2}, {1, 20, 0}})
                            .add({{1 + width, -20, -0.2}, {20, 20, 0}})
                            .add({{-20, -20, -5}, {20, 20, -4}});
    const dvec3 there = walk(world, {0, 0, kEye}, {1.5, 0}, 4.0);
    EXPECT_NEAR(there.z, (width > 1.0 ? -4.0 : 0.0) + kEye, 1e-9) << width;
  }
}

/// Rungs of 2 cm, 0.28 m apart, between two stiles, from the floor to 0.9 m over a platform of 5 m.
World with_ladder() {
  World world = World().add(kFloor).add({{1.2, -2, 4.9}, {8, 2, 5}});
  for (const double y : {-0.25, 0.22}) world.add({{1.0, y, 0}, {1.03, y + 0.03, 5.9}});
  for (int i = 1; i <= 17; ++i) world.add({{1.0, -0.25, 0.28 * i}, {1.02, 0.25, 0.28 * i + 0.02}});
  return world;
}

TEST(WalkingTest, LaddersAreClimbedUpAndDown) {
  const World world = with_ladder();
  Walker walker = world.walker();
  dvec3 eye = walk(walker, {0, 0, kEye}, {1.5, 0}, 4.0);
  EXPECT_LT(eye.x, 1.0);
  EXPECT_NEAR(eye.z, kEye + 0.7 * (4.0 - 0.7 / 1.5), 0.3) << "at 0.7 m/s";
  EXPECT_EQ(walk(walker, eye, {0, 0}, 2.0), eye) << "stays on it";
  EXPECT_FALSE(walker.falling());
  eye = walk(walker, eye, {1.5, 0}, 8.0);
  EXPECT_GT(eye.x, 1.5);
  EXPECT_NEAR(eye.z, 5.0 + kEye, 1e-9) << "on the platform";
  // Back over the edge: down at 0.7 m/s, not in a fall.
  double fastest = 0.0;
  for (int i = 0; i < 1000 && eye.z > kEye; ++i) {
    const dvec3 before = eye;
    eye = walker.move(eye, {-1.5, 0}, 0.02);
    fastest = std::max(fastest, (before.z - eye.z) / 0.02);
  }
  EXPECT_NEAR(eye.z, kEye, 1e-9);
  EXPECT_NEAR(fastest, Walker::kClimb, 1e-6);
}

TEST(WalkingTest, WallsAndRailsAreNoLadders) {
  const World wall = World().add(kFloor).add({{1, -5, 0}, {1.2, 5, 6}});
  const World rail = World().add(kFloor).add({{1, -5, 0.5}, {1.05, 5, 0.55}}).add({{1, -5, 1.05}, {1.05, 5, 1.1}});
  for (const World* world : {&wall, &rail}) {
    const dvec3 there = walk(*world, {0, 0, kEye}, {1.5, 0}, 4.0);
    EXPECT_EQ(there.z, kEye);
    EXPECT_LT(there.x, 1.0);
  }
}

TEST(WalkingTest, FindsTheNearestFloor) {
  const World world = World().add({{5, -2, 0}, {9, 2, 0.1}}).add({{-30, -2, 4}, {-20, 2, 4.1}});
  const Walker walker = world.walker();
  const core::AabbD model{{-30, -2, 0}, {9, 2, 4.1}};
  const auto below = walker.nearest_floor({6, 0, 9}, model);
  ASSERT_TRUE(below);
  EXPECT_NEAR(glm::length(*below - dvec3(6, 0, 0.1 + kEye)), 0.0, 1e-9);
  const auto beside = walker.nearest_floor({0, 0, 9}, model);
  ASSERT_TRUE(beside);
  EXPECT_NEAR(beside->z, 0.1 + kEye, 1e-9);
  EXPECT_LT(beside->x, 6.0) << "little beyond its edge";
  const auto from_beneath = walker.nearest_floor({6, 0, -50}, model);
  ASSERT_TRUE(from_beneath) << "no floor lies below, but one above";
  EXPECT_NEAR(from_beneath->z, 0.1 + kEye, 1e-9);
  const auto far_away = walker.nearest_floor({-500, 300, 80}, model);
  ASSERT_TRUE(far_away);
  EXPECT_NEAR(far_away->z, 4.1 + kEye, 1e-9);
  EXPECT_FALSE(World().walker().nearest_floor({0, 0, 0}, model));
}

TEST(WalkingTest, LowBeamsStop) {
  for (const double bottom : {0.9, 1.2, 1.45, 1.5, 1.75, 1.85, 2.0}) {
    const World world = World().add(kFloor).add({{1, -20, bottom}, {1.15, 20, bottom + 0.15}});
    const dvec3 there = walk(world, {0, 0, kEye}, {1.5, 0}, 3.0);
    EXPECT_EQ(there.x < 1.0, bottom < kEye + 0.1) << bottom << " gets to " << there.x;
  }
}

/// Walks in mazes of full-height boxes, in steps of any time. The axis never is in a box, nor crosses one.
TEST(WalkingTest, NeverPassesThroughAWall) {
  for (int seed = 1; seed <= tests::repeated(60); ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random{std::uint64_t(seed)};
    const auto between = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    World world = World().add(kFloor);
    for (int i = 0; i < 40; ++i) {
      const dvec2 at(between(-8, 8), between(-8, 8));
      const bool thin = random() % 2 == 0;
      const dvec2 half(between(0.01, thin ? 0.05 : 1.5), between(0.01, 1.5));
      if (glm::length(at) < 2.5 + glm::length(half)) continue;
      world.add({{at - half, 0.0}, {at + half, between(1.8, 4.0)}});
    }
    Walker walker = world.walker();
    dvec3 eye(0, 0, kEye);
    double heading = between(0.0, 6.3), walked = 0.0;
    for (int frame = 0; frame < 400; ++frame) {
      heading += between(-0.5, 0.5);
      const double seconds = std::exp(between(std::log(0.001), std::log(0.25))), speed = random() % 4 ? 4.5 : 0.3;
      const dvec3 next = walker.move(eye, speed * dvec2(std::cos(heading), std::sin(heading)), seconds);
      const double length = glm::length(next - eye);
      walked += length;
      ASSERT_LE(length, speed * seconds + 0.3) << "frame " << frame;
      for (std::size_t i = 1; i < world.boxes().size(); ++i) {
        const Box& box = world.boxes()[i];
        ASSERT_FALSE(next.x > box.min.x && next.x < box.max.x && next.y > box.min.y && next.y < box.max.y)
            << "frame " << frame << " is in box " << i;
        if (seconds < 0.02 && length > 0.0) {
          ASSERT_FALSE(hit(box, eye - dvec3(0, 0, 0.5), (next - eye) / length, length)) << "frame " << frame;
        }
      }
      ASSERT_NEAR(next.z, kEye, 1e-9);
      eye = next;
    }
    EXPECT_GT(walked, 10.0);
  }
}

/// Poles so thin that the feelers miss most of them: what turns the body aside must not send its axis through one.
TEST(WalkingTest, TheAxisCrossesNoPoleHoweverThin) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(-2.0, 2.0), turn(-0.5, 0.5);
    World world = World().add(kFloor);
    for (int i = 0; i < 60; ++i) {
      const dvec2 at(place(random), place(random));
      if (glm::length(at) > 0.4) world.add({{at - 0.02, 0.0}, {at + 0.02, 3.0}});
    }
    Walker walker = world.walker();
    dvec3 eye(0, 0, kEye);
    double heading = turn(random) * 6.0;
    for (int frame = 0; frame < 400; ++frame) {
      heading += turn(random);
      const dvec3 next = walker.move(eye, 4.5 * dvec2(std::cos(heading), std::sin(heading)), 0.02);
      const double length = glm::length(next - eye);
      for (std::size_t i = 1; length > 0.0 && i < world.boxes().size(); ++i)
        ASSERT_FALSE(hit(world.boxes()[i], eye - dvec3(0, 0, 0.5), (next - eye) / length, length))
            << "frame " << frame << ", pole " << i;
      eye = next;
    }
  }
}

}  // namespace
}  // namespace sightline::apps::walking_test
