// Viewpoints as files: what is written comes back, and other readers of views see the same.
#include "sightline/apps/viewpoints/viewpoint.h"

#include <gtest/gtest.h>

#include "sightline/apps/view/camera.h"
#include "sightline/importers/view_json.h"

namespace sightline::apps::viewpoint_test {
namespace {

constexpr double kAspect = 1.5;

Camera camera_at(bool orthographic) {
  Camera camera({{3e6, 7e6, 100.0}, {3e6 + 80.0, 7e6 + 48.0, 136.0}}, 0.7, kAspect);
  camera.orbit({0.3, 0.1}, camera.pose().target);
  camera.set_orthographic(orthographic);
  return camera;
}

Viewpoint viewpoint_of(const Camera& camera) {
  Viewpoint viewpoint;
  viewpoint.pose = camera.pose();
  viewpoint.fovy = camera.fovy();
  viewpoint.orthographic = camera.orthographic();
  viewpoint.near = camera.near();
  viewpoint.sections = {{{0, 0, 1}, -110.0}, {{1, 0, 0}, -3e6}};
  viewpoint.colour_by = "System";
  return viewpoint;
}

TEST(ViewpointTest, ComesBack) {
  for (const bool orthographic : {false, true}) {
    const Viewpoint written = viewpoint_of(camera_at(orthographic));
    const auto list = parse_viewpoints(format_viewpoint(written), "view");
    ASSERT_TRUE(list) << list.error().message;
    ASSERT_EQ(list->size(), 1u);
    const Viewpoint* const read = list->data();
    EXPECT_EQ(read->pose.eye, written.pose.eye);
    EXPECT_EQ(read->pose.target, written.pose.target);
    EXPECT_EQ(read->pose.up, written.pose.up);
    EXPECT_EQ(read->orthographic, orthographic);
    EXPECT_EQ(read->colour_by, "System");
    EXPECT_NEAR(read->fovy, written.fovy, 1e-12);
    ASSERT_EQ(read->sections.size(), 2u);
    EXPECT_EQ(read->sections[0].offset, -110.0);
    EXPECT_EQ(read->sections[1].normal, core::dvec3(1, 0, 0));
  }
}

/// What other tools draw with --view is what the viewer shows: points lie where they lay.
TEST(ViewpointTest, IsAViewForOtherTools) {
  for (const bool orthographic : {false, true}) {
    const Camera camera = camera_at(orthographic);
    const auto read = importers::parse_view(format_viewpoint(viewpoint_of(camera)), kAspect);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->orthographic(), orthographic);
    EXPECT_EQ(read->sections.size(), 2u);
    for (const core::dvec3& offset : {core::dvec3(0, 0, 0), {10, -5, 3}, {-20, 8, 1}}) {
      const core::dvec4 point(camera.pose().target + offset, 1.0);
      const core::dvec4 a = camera.view(kAspect)->clip_from_world() * point, b = read->clip_from_world() * point;
      EXPECT_NEAR(a.x / a.w, b.x / b.w, 1e-9);
      EXPECT_NEAR(a.y / a.w, b.y / b.w, 1e-9);
    }
  }
}

TEST(ViewpointTest, MovesWithTheModel) {
  const Viewpoint here = viewpoint_of(camera_at(false)), there = translated(here, {-3e6, -7e6, 5});
  EXPECT_EQ(there.pose.eye, here.pose.eye + core::dvec3(-3e6, -7e6, 5));
  const core::dvec3 point(3e6 + 1, 7e6, 111);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NEAR(core::evaluate(here.sections[i], point),
                core::evaluate(there.sections[i], point + core::dvec3(-3e6, -7e6, 5)), 1e-9);
}

TEST(ViewpointTest, SaysWhatIsWrong) {
  const auto bad = parse_viewpoints("{\"eye\":[0,0,0],\"target\":[0,1]}", "file.json");
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().message.find("file.json: /target: expected"), 0u) << bad.error().message;
  EXPECT_FALSE(parse_viewpoints("", "file.json"));
}

}  // namespace
}  // namespace sightline::apps::viewpoint_test
