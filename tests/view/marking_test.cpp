// Mark-ups from points of the image, and what scripts ask for.
#include "sightline/apps/view/marking.h"

#include <array>

#include <gtest/gtest.h>

#include "sightline/core/view.h"

namespace sightline::apps::marking_test {
namespace {

using Kind = Markup::Kind;

constexpr std::array<int, 2> kSize{300, 200};

core::View view_of(bool orthographic) {
  const core::Pose pose{{0, -10, 0}, {0, 0, 0}, {0, 0, 1}};
  return orthographic ? *core::View::orthographic(pose, 8.0, 1.5, 0.1, 100.0)
                      : *core::View::perspective(pose, 0.8, 1.5, 0.1);
}

core::dvec2 pixel_of(const core::View& view, const core::dvec3& point) {
  const core::dvec4 clip = view.clip_from_world() * core::dvec4(point, 1.0);
  return {0.5 * (clip.x / clip.w + 1.0) * kSize[0], 0.5 * (1.0 - clip.y / clip.w) * kSize[1]};
}

void expect_at(const core::dvec2& a, const core::dvec2& b) {
  EXPECT_NEAR(a.x, b.x, 1e-6);
  EXPECT_NEAR(a.y, b.y, 1e-6);
}

TEST(Marking, PointsLieBelowTheirPixelsOnOnePlane) {
  for (const bool orthographic : {false, true}) {
    const MarkupPlane plane{view_of(orthographic), kSize, {2, -3, 1}};
    const auto cloud = drawn_markup(Kind::kCloud, "", plane, {200, 150}, {40, 30});
    ASSERT_TRUE(cloud) << cloud.error().message;
    ASSERT_EQ(cloud->points.size(), 4u);
    const core::dvec2 corners[] = {{40, 30}, {200, 30}, {200, 150}, {40, 150}};
    for (std::size_t i = 0; i < 4; ++i) {
      expect_at(pixel_of(plane.view, cloud->points[i]), corners[i]);
      EXPECT_NEAR(cloud->points[i].y, -3.0, 1e-9) << "parallel to the image, through the point";
    }
    const auto arrow = drawn_markup(Kind::kArrow, "here", plane, {100, 100}, {20, 60});
    ASSERT_TRUE(arrow);
    expect_at(pixel_of(plane.view, arrow->points[0]), {20, 60});
    expect_at(pixel_of(plane.view, arrow->points[1]), {100, 100});
    EXPECT_EQ(arrow->words, "here");
    EXPECT_EQ(drawn_markup(Kind::kText, "words", plane, {100, 100}, {100, 100})->points.size(), 1u);
  }
}

TEST(Marking, SaysWhatCannotBeDrawn) {
  const MarkupPlane behind{view_of(false), kSize, {0, -11, 0}};
  EXPECT_FALSE(drawn_markup(Kind::kArrow, "", behind, {10, 10}, {20, 20}));
  const MarkupPlane before{view_of(false), kSize, {0, 0, 0}};
  EXPECT_FALSE(drawn_markup(Kind::kText, "", before, {10, 10}, {10, 10})) << "a text without words";
}

TEST(Marking, ReadsWhatScriptsAsk) {
  const auto arrow = parse_markup("arrow 10 20.5 30 40  two words ");
  ASSERT_TRUE(arrow) << arrow.error().message;
  EXPECT_EQ(arrow->kind, Kind::kArrow);
  EXPECT_EQ(arrow->from, core::dvec2(10, 20.5));
  EXPECT_EQ(arrow->to, core::dvec2(30, 40));
  EXPECT_EQ(arrow->words, "two words ");
  EXPECT_EQ(parse_markup("cloud 1 2 3 4")->words, "");
  const auto text = parse_markup("text 5 6 7 bolts");
  EXPECT_EQ(text->words, "7 bolts");
  EXPECT_EQ(text->from, text->to);
  for (const char* bad :
       {"", "line 1 2 3 4", "circle 1 2", "arrow 1 2 3", "arrow 1 2 x 4", "text 1", "cloud nan 1 2 3"})
    EXPECT_FALSE(parse_markup(bad)) << bad;
}

TEST(Marking, KeepsAList) {
  Marking marking;
  for (const char* words : {"a", "b", "c"}) marking.add({Kind::kText, {{0, 0, 0}}, words});
  marking.remove(1);
  ASSERT_EQ(marking.list().size(), 2u);
  EXPECT_EQ(marking.list()[1].words, "c");
  marking.clear();
  EXPECT_TRUE(marking.list().empty());
}

}  // namespace
}  // namespace sightline::apps::marking_test
