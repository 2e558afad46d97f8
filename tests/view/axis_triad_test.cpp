// The axes in the corner: their ends lie as a view shows them, and each leads to its view.
#include "sightline/apps/view/axis_triad.h"

#include <random>
#include <string>

#include <gtest/gtest.h>

namespace sightline::apps::axis_triad_test {
namespace {

constexpr core::dvec2 kCentre(100.0, 200.0);

const AxisTriad::End& end_of(const AxisTriad& triad, int axis, bool positive) {
  for (const AxisTriad::End& end : triad.ends())
    if (end.axis == axis && end.positive == positive) return end;
  throw std::logic_error("an end is missing");
}

TEST(AxisTriadTest, EndsLieAsAViewShowsThem) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    const core::Pose pose{
        {normal(random), normal(random), normal(random)}, {normal(random), normal(random), normal(random)}, {0, 0, 1}};
    const AxisTriad triad(pose, kCentre, 2.0);
    const auto view = core::View::orthographic(pose, 2.0, 1.0, -10.0, 10.0);
    ASSERT_TRUE(view);
    const core::dvec4 middle = view->clip_from_world() * core::dvec4(pose.target, 1.0);
    double length = 0.0, before = -1.0;
    for (const AxisTriad::End& end : triad.ends()) {
      EXPECT_GE(end.depth, before) << "the farthest first";
      before = end.depth;
      core::dvec3 axis(0.0);
      axis[end.axis] = end.positive ? 1.0 : -1.0;
      const core::dvec4 seen = view->clip_from_world() * core::dvec4(pose.target + axis, 1.0) - middle;
      const core::dvec2 off = end.at - kCentre;
      length = glm::length(core::dvec3(off, 0.0)) / std::max(1e-12, glm::length(core::dvec2(seen.x, seen.y)));
      EXPECT_NEAR(off.x, length * seen.x, 1e-9);
      EXPECT_NEAR(off.y, -length * seen.y, 1e-9);
      EXPECT_NEAR(length, 72.0, 1e-6);
      EXPECT_LE(glm::length(off) + triad.end_radius(), AxisTriad::reach(2.0));
      const auto hit = triad.end_at(end.at);
      ASSERT_TRUE(hit);
      EXPECT_GE(hit->depth, end.depth);
    }
  }
}

TEST(AxisTriadTest, EndsLeadToViews) {
  const AxisTriad slanting({{5, -4, 3}, {0, 0, 0}, {0, 0, 1}}, kCentre, 1.0);
  const auto view = [](const AxisTriad& triad, int axis, bool positive) {
    return std::string(AxisTriad::view_from(end_of(triad, axis, positive)));
  };
  EXPECT_EQ(view(slanting, 0, true), "right");
  EXPECT_EQ(view(slanting, 0, false), "left");
  EXPECT_EQ(view(slanting, 1, true), "back");
  EXPECT_EQ(view(slanting, 1, false), "front");
  EXPECT_EQ(view(slanting, 2, true), "top");
  EXPECT_EQ(view(slanting, 2, false), "bottom");
  const AxisTriad front({{0, -4, 0}, {0, 0, 0}, {0, 0, 1}}, kCentre, 1.0);
  const auto facing = front.end_at(kCentre);
  ASSERT_TRUE(facing);
  EXPECT_FALSE(facing->positive);
  EXPECT_STREQ(AxisTriad::view_from(*facing), "back") << "the other side of what is seen";
  EXPECT_EQ(view(front, 0, true), "right");
  EXPECT_FALSE(front.end_at(kCentre + core::dvec2(20.0, 20.0)));
}

}  // namespace
}  // namespace sightline::apps::axis_triad_test
