// Viewpoints as files: what is written comes back, and other readers of views see the same.
#include "sightline/apps/viewpoints/viewpoint.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

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

std::vector<Markup> one_of_each() {
  using Kind = Markup::Kind;
  return {{Kind::kArrow, {{1, 2, 3}, {1.1, 2, 4}}, "here"},
          {Kind::kCloud, {{0, 0, 0}, {4, 0, 0}, {4, 0, 1}, {0, 0, 1}}, ""},
          {Kind::kText, {{3e6 + 0.1, 7e6, 5}}, "Prüfen \"Ø 12\""},
          {Kind::kLine, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1}}, ""}};
}

TEST(ViewpointTest, MarkUpsComeBackAndMoveWithTheModel) {
  Viewpoint written = viewpoint_of(camera_at(false));
  written.markups = one_of_each();
  const auto read = parse_viewpoints(format_viewpoint(written), "view");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->front().markups, written.markups);
  EXPECT_TRUE(importers::parse_view(format_viewpoint(written), kAspect)) << "a view for other tools, too";
  const core::dvec3 offset(10, -20, 30);
  const Viewpoint moved = translated(written, offset);
  for (std::size_t i = 0; i < written.markups.size(); ++i)
    for (std::size_t k = 0; k < written.markups[i].points.size(); ++k)
      EXPECT_EQ(moved.markups[i].points[k], written.markups[i].points[k] + offset);
  const std::vector<Viewpoint> list{written};
  const auto all = parse_viewpoints(format_viewpoints(list), "views");
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_EQ(all->front().markups, written.markups);
}

TEST(ViewpointTest, BadMarkUpsAreErrors) {
  const std::string camera = R"({"eye":[0,0,0],"target":[0,1,0],"fovy_deg":60,"near":1,"markups":)";
  for (const auto& [markups, message] : std::vector<std::pair<std::string, std::string>>{
           {"3", "f: /markups: expected an array of mark-ups, found number"},
           {"[3]", "f: /markups/0: expected {"},
           {R"([{"kind":"text"}])", "f: /markups/0: expected {"},
           {R"([{"kind":"circle","points":[]}])", "f: /markups/0: expected arrow, cloud, text or line"},
           {R"([{"kind":"arrow","points":[[0,0,0]]}])", "f: /markups/0: expected points"},
           {R"([{"kind":"text","points":[[0,0]]}])", "f: /markups/0: expected points"},
           {R"([{"kind":"text","points":[[0,0,"x"]]}])", "f: /markups/0: expected points"},
           {R"([{"kind":"text","points":[[0,0,0]],"words":7}])", "f: /markups/0: /words: expected a string"}}) {
    const auto read = parse_viewpoints(camera + markups + "}", "f");
    ASSERT_FALSE(read) << markups;
    EXPECT_EQ(read.error().message.find(message), 0u) << read.error().message;
  }
}

/// Lines stay in the mark-up's plane, and begin and end where it does.
TEST(ViewpointTest, MarkUpsAreLines) {
  const std::vector<Markup> all = one_of_each();
  const auto arrow = strokes({Markup::Kind::kArrow, {{0, 0, 0}, {10, 0, 0}}, ""}, {0, 1, 0});
  ASSERT_EQ(arrow.size(), 2u);
  EXPECT_EQ(arrow[1][1], core::dvec3(10, 0, 0));
  EXPECT_NEAR(glm::length(arrow[1][0] - arrow[1][2]), 1.8, 1e-9) << "the head is as wide as that";
  EXPECT_NEAR(arrow[1][0].y, 0.0, 1e-12) << "across the direction of sight";
  const auto cloud = strokes(all[1], {0, 1, 0});
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud[0].front(), cloud[0].back());
  double highest = 0.0;
  for (const core::dvec3& point : cloud[0]) {
    EXPECT_NEAR(point.y, 0.0, 1e-12);
    highest = std::max(highest, point.z);
  }
  EXPECT_GT(highest, 1.05) << "bows go outward";
  EXPECT_EQ(strokes(all[2], {0, 1, 0}).size(), 0u);
  EXPECT_EQ(strokes(all[3], {0, 1, 0}), std::vector<std::vector<core::dvec3>>{all[3].points});
  EXPECT_EQ(strokes({Markup::Kind::kArrow, {{1, 1, 1}, {1, 1, 1}}, ""}, {0, 1, 0}).size(), 1u) << "no length";
}

TEST(ViewpointTest, SaysWhatIsWrong) {
  const auto bad = parse_viewpoints("{\"eye\":[0,0,0],\"target\":[0,1]}", "file.json");
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().message.find("file.json: /target: expected"), 0u) << bad.error().message;
  EXPECT_FALSE(parse_viewpoints("", "file.json"));
}

}  // namespace
}  // namespace sightline::apps::viewpoint_test
