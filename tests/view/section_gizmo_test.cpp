// Handles of sections: what is dragged stays under the cursor, in any view, against brute force.
#include "sightline/apps/view/section_gizmo.h"

#include <random>

#include <gtest/gtest.h>

namespace sightline::apps::section_gizmo_test {
namespace {

using core::dvec2;
using core::dvec3;
using Part = SectionGizmo::Part;

constexpr int kWidth = 800, kHeight = 600;
constexpr double kAspect = double(kWidth) / kHeight;
constexpr Part kParts[] = {Part::kMiddle, Part::kOut, Part::kIn, Part::kRight, Part::kLeft, Part::kUp, Part::kDown};

ImageFrame frame_of(const core::View& view) {
  return *ImageFrame::create(view, kWidth, kHeight);
}

core::View looking(const dvec3& eye, const dvec3& target, bool parallel) {
  const core::Pose pose{eye, target, {0, 0, 1}};
  const double distance = glm::length(target - eye);
  return parallel ? *core::View::orthographic(pose, 0.8 * distance, kAspect, -10.0 * distance, 10.0 * distance)
                  : *core::View::perspective(pose, 0.8, kAspect, 1e-3 * distance, core::kInfiniteFar);
}

struct Case {
  core::View view;
  Sections::Section section;
  double reach;  // from eye to target
};

/// Views of a section from everywhere, perspective and parallel, `far` from the origin.
class SectionGizmoTest : public testing::TestWithParam<double> {
 protected:
  double uniform(double low, double high) { return low + (high - low) * double(random_()) / 4294967296.0; }
  dvec3 direction() { return glm::normalize(dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1) + 1e-3)); }
  Case next(int i) {
    const dvec3 centre = GetParam() * dvec3(1.0, -0.6, 0.2);
    const double reach = std::pow(10.0, uniform(-1.0, 3.0));
    dvec3 normal = direction();
    if (i % 5 == 0) normal = dvec3(0, 0, i % 2 ? 1.0 : -1.0);
    Case made{looking(centre + reach * direction(), centre, i % 3 == 0), {}, reach};
    made.section.point = centre + 0.1 * reach * direction();
    made.section.normal = normal;
    made.section.offset = uniform(-0.05, 0.05) * reach;
    return made;
  }
  double slack(double reach) const { return 1e-9 * reach + 2e-8 * (GetParam() > 0.0 ? 1.0 : 0.0); }

  std::mt19937 random_{11};
};
INSTANTIATE_TEST_SUITE_P(, SectionGizmoTest, testing::Values(0.0, 1e7),
                         [](const auto& place) { return "m" + std::to_string(long(place.param)); });

TEST_P(SectionGizmoTest, PixelsAndPointsAreOfOneKind) {
  for (int i = 0; i < 300; ++i) {
    const Case c = next(i);
    const ImageFrame frame = frame_of(c.view);
    const dvec2 at(uniform(0, kWidth), uniform(0, kHeight));
    const core::Ray ray = frame.ray(at);
    const dvec3 point = ray.origin + uniform(0.5, 3.0) * c.reach * ray.direction;
    const auto back = frame.project(point);
    ASSERT_TRUE(back);
    EXPECT_NEAR(glm::length(*back - at), 0.0, 1e-6 + slack(c.reach) / frame.pixel_at(point)) << i;
    const auto beside = frame.ray(at + dvec2(0.0, 1.0));
    const dvec3 there = beside.origin + glm::dot(point - beside.origin, beside.direction) * beside.direction;
    EXPECT_NEAR(glm::length(there - point) / frame.pixel_at(point), 1.0, 0.35) << i;
    if (c.view.orthographic()) continue;
    EXPECT_FALSE(frame.project(ray.origin - c.reach * ray.direction)) << "behind the eye";
  }
}

/// The twin tries points of the axis, ever closer.
TEST_P(SectionGizmoTest, FindsThePointOfAnAxisNearestToARay) {
  int found = 0;
  for (int i = 0; i < 400; ++i) {
    const Case c = next(i);
    const ImageFrame frame = frame_of(c.view);
    const dvec2 at(uniform(0, kWidth), uniform(0, kHeight));
    const auto along = frame.along_axis(at, c.section.point, c.section.normal);
    if (!along) continue;
    const core::Ray ray = frame.ray(at);
    const auto distance = [&](double s) {
      const dvec3 to = c.section.point + s * c.section.normal - ray.origin;
      return glm::length(glm::cross(to, ray.direction));
    };
    if (std::abs(*along) > 100.0 * c.reach) continue;  // near the horizon
    ++found;
    double best = 0.0, width = 200.0 * c.reach;
    for (int round = 0; round < 60; ++round, width *= 0.5)
      for (const double s : {best - width, best + width})
        if (distance(s) < distance(best)) best = s;
    EXPECT_LE(distance(*along), distance(best) + slack(c.reach)) << i;
    const dvec3 point = c.section.point + *along * c.section.normal;
    EXPECT_TRUE(c.view.orthographic() || glm::dot(point - ray.origin, ray.direction) > 0.0) << i;
  }
  EXPECT_GT(found, 200);
}

/// The point of the arrow that is grabbed stays nearest to the cursor, and its plane through it.
TEST_P(SectionGizmoTest, WhatIsGrabbedFollows) {
  int moved = 0, turned = 0;
  for (int i = 0; i < 400; ++i) {
    SCOPED_TRACE(i);
    const Case c = next(i);
    const ImageFrame frame = frame_of(c.view);
    const auto gizmo = SectionGizmo::create(frame, c.section, true, 1.0);
    if (!gizmo) continue;
    for (const SectionGizmo::Handle& handle : gizmo->handles()) {
      ASSERT_TRUE(gizmo->part_at(handle.at)) << "a handle lies under itself, or under another";
      const auto none = gizmo->dragged(handle.part, handle.at, handle.at);
      ASSERT_TRUE(none);
      EXPECT_NEAR(*none, 0.0, 1e-12);
      const dvec2 to = handle.at + dvec2(uniform(-40, 40), uniform(-40, 40));
      const auto by = gizmo->dragged(handle.part, handle.at, to);
      if (!by) continue;
      const Sections::Section after = gizmo->moved(handle.part, *by);
      EXPECT_NEAR(glm::length(after.normal), 1.0, 1e-12);
      const auto anchor = frame.on_plane(gizmo->middle(), c.section.place(), c.section.normal);
      if (!anchor) continue;
      const dvec3 sight = frame.ray(gizmo->middle()).direction;
      if (!SectionGizmo::turns(handle.part)) {
        EXPECT_EQ(after.normal, c.section.normal);
        EXPECT_NEAR(after.offset, c.section.offset + *by, slack(c.reach));
        if (std::abs(glm::dot(sight, c.section.normal)) > 0.96) continue;
        const auto from_axis = frame.along_axis(handle.at, *anchor, c.section.normal),
                   to_axis = frame.along_axis(to, *anchor, c.section.normal);
        ASSERT_TRUE(from_axis && to_axis);
        // The axis shows as a line. What was on it next to the cursor is there again.
        EXPECT_NEAR(*to_axis - *from_axis, *by, 1e-6 * c.reach + slack(c.reach) / 0.05);
        ++moved;
        continue;
      }
      // The square's side has turned about the middle by as much, and the plane still holds the middle.
      EXPECT_NEAR(core::evaluate(after.plane(), *anchor), 0.0, 1e-6 * c.reach + slack(c.reach) / 0.05);
      EXPECT_NEAR(std::acos(std::clamp(glm::dot(after.normal, c.section.normal), -1.0, 1.0)), std::abs(*by), 1e-7);
      ++turned;
      const dvec3 axis = glm::normalize(glm::cross(c.section.normal, after.normal));
      if (std::abs(*by) < 1e-3 || std::abs(glm::dot(sight, axis)) < 0.31) continue;
      const auto p = frame.on_plane(handle.at, *anchor, axis), q = frame.on_plane(to, *anchor, axis);
      ASSERT_TRUE(p && q);
      const dvec3 before = *p - *anchor, then = *q - *anchor;
      const double angle = std::atan2(glm::dot(axis, glm::cross(before, then)), glm::dot(before, then));
      EXPECT_NEAR(std::remainder(angle - std::abs(*by), 6.283185307179586), 0.0, 1e-5);
    }
  }
  EXPECT_GT(moved, 300);
  EXPECT_GT(turned, 300);
}

/// From its end an arrow still has a direction, and a pixel along it is a pixel's metres.
TEST_P(SectionGizmoTest, WorksAlongTheLineOfSight) {
  const dvec3 centre = GetParam() * dvec3(1.0, -0.6, 0.2);
  for (const bool parallel : {false, true})
    for (const dvec3& normal : {dvec3(0, -1, 0), dvec3(0, 1, 0), glm::normalize(dvec3(1e-4, -1, 2e-4))}) {
      const ImageFrame frame = frame_of(looking(centre + dvec3(0, -20, 0), centre, parallel));
      const auto gizmo = SectionGizmo::create(frame, {centre, normal, 0.0, true}, true, 1.5);
      ASSERT_TRUE(gizmo);
      const dvec2 arrow = gizmo->handles()[1].at - gizmo->middle();
      EXPECT_GT(glm::length(arrow), 40.0);
      const dvec2 along = glm::normalize(arrow);
      EXPECT_NEAR(*gizmo->dragged(Part::kOut, {0, 0}, 10.0 * along), 10.0 * gizmo->pixel(), 1e-9);
      EXPECT_NEAR(*gizmo->dragged(Part::kOut, {0, 0}, {-7.0 * along.y, 7.0 * along.x}), 0.0, 1e-9);
      for (const Part part : kParts) EXPECT_TRUE(gizmo->dragged(part, gizmo->middle(), {0, 0})) << int(part);
    }
}

/// Where the place is outside, the handles are at another point of the plane that has room; a plane that is not shown
/// has none.
TEST_P(SectionGizmoTest, HandlesHaveRoomInTheImage) {
  int shown = 0;
  for (int i = 0; i < 400; ++i) {
    SCOPED_TRACE(i);
    Case c = next(i);
    c.section.point += uniform(0.0, 8.0) * c.reach * direction();
    const ImageFrame frame = frame_of(c.view);
    const auto gizmo = SectionGizmo::create(frame, c.section, i % 2 == 0, 1.0);
    if (!gizmo) continue;
    ++shown;
    const dvec2 at = gizmo->middle();
    EXPECT_TRUE(at.x > 27.9 && at.y > 27.9 && at.x < kWidth - 27.9 && at.y < kHeight - 27.9) << at.x << ' ' << at.y;
    const auto point = frame.on_plane(at, c.section.place(), c.section.normal);
    ASSERT_TRUE(point);
    EXPECT_GT(frame.pixel_at(*point), 0.0);
  }
  EXPECT_GT(shown, 200);
  const dvec3 centre = GetParam() * dvec3(1.0, -0.6, 0.2);
  const ImageFrame frame = frame_of(looking(centre + dvec3(0, -20, 0), centre, false));
  EXPECT_FALSE(SectionGizmo::create(frame, {centre + dvec3(0, -21, 0), {0, 1, 0}, 0.0, true}, true, 1.0)) << "behind";
  const auto floor = SectionGizmo::create(frame, {centre + dvec3(0, -30, -2), {0, 0, 1}, 0.0, true}, true, 1.0);
  ASSERT_TRUE(floor) << "its point is behind the eye, but below there is more of it";
  EXPECT_GT(floor->middle().y, 0.5 * kHeight);
}

/// Beyond the horizon nothing is under the cursor.
TEST(SectionGizmo, EndsAtTheHorizon) {
  const ImageFrame frame = frame_of(looking({0, -20, 0}, {0, 0, 0}, false));
  const dvec3 axis = glm::normalize(dvec3(0.3, 1.0, 0.0));
  const auto horizon = frame.project(dvec3(0, -20, 0) + 1e6 * axis);
  ASSERT_TRUE(horizon);
  EXPECT_GT(*frame.along_axis(*horizon - dvec2(5.0, 0.0), {0, 0, 0}, axis), 100.0);
  EXPECT_FALSE(frame.along_axis(*horizon + dvec2(5.0, 0.0), {0, 0, 0}, axis));
  EXPECT_FALSE(frame.along_axis(*frame.project({0, 0, 0}), {0, 0, 0}, {0, 1, 0})) << "parallel";
}

TEST(SectionGizmo, UnselectedOnesHaveOneArrow) {
  const ImageFrame frame = frame_of(looking({4, -20, 6}, {0, 0, 0}, false));
  const auto gizmo = SectionGizmo::create(frame, {{0, 0, 0}, {0, -1, 0}, 0.0, true}, false, 2.0);
  ASSERT_TRUE(gizmo);
  ASSERT_EQ(gizmo->handles().size(), 2u);
  for (const dvec2& off : {dvec2(0, 0), dvec2(0.2, 0.1), dvec2(9, 0), dvec2(-7, 7), dvec2(0, -9)})
    EXPECT_EQ(gizmo->part_at(gizmo->middle() + off), Part::kMiddle) << off.x << ' ' << off.y;
  EXPECT_EQ(gizmo->part_at(gizmo->handles()[1].at), Part::kOut);
  EXPECT_EQ(gizmo->part_at(0.5 * (gizmo->middle() + gizmo->handles()[1].at)), Part::kOut) << "the shaft";
  EXPECT_FALSE(gizmo->part_at(2.0 * gizmo->middle() - gizmo->handles()[1].at));
}

}  // namespace
}  // namespace sightline::apps::section_gizmo_test
