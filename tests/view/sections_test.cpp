// Sections: which points they keep, moved, flipped and around a box.
#include "sightline/apps/view/sections.h"

#include <gtest/gtest.h>

namespace sightline::apps::sections_test {
namespace {

bool kept(const Sections& sections, const core::dvec3& point) {
  for (const core::Plane& plane : sections.planes())
    if (core::evaluate(plane, point) < 0.0) return false;
  return true;
}

TEST(SectionsTest, CutAwayWhatLiesInFront) {
  Sections sections;
  ASSERT_TRUE(sections.add({1e6, 2.0, 3.0}, {0.0, 2.0, 0.0}));
  EXPECT_TRUE(kept(sections, {1e6, 1.9, 3.0}));
  EXPECT_FALSE(kept(sections, {1e6, 2.1, 3.0}));
  sections.all()[0].offset = 0.5;
  EXPECT_TRUE(kept(sections, {1e6, 2.4, 3.0}));
  EXPECT_FALSE(kept(sections, {1e6, 2.6, 3.0}));
  Sections::flip(sections.all()[0]);
  EXPECT_FALSE(kept(sections, {1e6, 2.4, 3.0}));
  EXPECT_TRUE(kept(sections, {1e6, 2.6, 3.0}));
  sections.all()[0].on = false;
  EXPECT_TRUE(kept(sections, {1e6, 2.4, 3.0}));
  sections.remove(0);
  EXPECT_TRUE(sections.planes().empty());
}

TEST(SectionsTest, ABoxKeepsItsInside) {
  Sections sections;
  sections.add({0, 0, 0}, {1, 0, 0});
  sections.box({{1, 2, 3}, {4, 5, 6}});
  EXPECT_EQ(sections.planes().size(), 6u);
  EXPECT_TRUE(kept(sections, {1, 2, 3}) && kept(sections, {4, 5, 6}) && kept(sections, {2, 3, 4}));
  for (const core::dvec3& outside :
       {core::dvec3(0.9, 3, 4), {4.1, 3, 4}, {2, 1.9, 4}, {2, 5.1, 4}, {2, 3, 2.9}, {2, 3, 6.1}})
    EXPECT_FALSE(kept(sections, outside));
}

TEST(SectionsTest, PlanesComeBack) {
  Sections sections;
  const std::vector<core::Plane> planes{{{0, 0, 2}, -6e6}, {{0, 0, 0}, 1.0}, {{-1, 1, 0}, 4.0}};
  sections.set(planes);
  ASSERT_EQ(sections.planes().size(), 2u) << "one cuts nothing";
  for (const core::dvec3& point : {core::dvec3(0, 0, 3e6 + 1e-6), {0, 0, 3e6 - 1e-6}, {4.1, 0, 4e6}, {3.9, 0, 4e6}}) {
    bool wanted = true;
    for (const core::Plane& plane : planes) wanted = wanted && core::evaluate(plane, point) >= 0.0;
    EXPECT_EQ(kept(sections, point), wanted) << point.x << ' ' << point.z;
  }
  while (sections.planes().size() < Sections::kMost) ASSERT_TRUE(sections.add({0, 0, 0}, {1, 0, 0}));
  EXPECT_FALSE(sections.add({0, 0, 0}, {1, 0, 0}));
}

TEST(SectionsTest, PointsLieInTheMiddleOfWhatIsShown) {
  const core::AabbD model{{1e7, 0, 0}, {1e7 + 100, 60, 30}}, part{{1e7 + 10, 20, 5}, {1e7 + 14, 30, 8}};
  Sections box, again;
  box.box(part);
  again.set(box.planes(), model);
  ASSERT_EQ(again.all().size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const core::dvec3 at = box.all()[i].place();
    EXPECT_NEAR(std::abs(glm::dot(at - part.centre(), box.all()[i].normal)),
                0.5 * glm::dot(part.size(), glm::abs(box.all()[i].normal)), 1e-9);
    EXPECT_NEAR(glm::length(again.all()[i].place() - at), 0.0, 1e-6) << i;
  }
  const core::Plane alone{{0, 3, 0}, -120.0}, outside{{1, 0, 0}, 0.0}, slanting{{1, -1, 0}, -1e7};
  Sections one;
  one.set({&alone, 1}, model);
  EXPECT_NEAR(glm::length(one.all()[0].place() - core::dvec3(1e7 + 50, 40, 15)), 0.0, 1e-6);
  one.set({&outside, 1}, model);
  EXPECT_NEAR(one.all()[0].place().x, 0.0, 1e-6) << "on the plane, although the model is elsewhere";
  one.set({&slanting, 1}, model);
  EXPECT_NEAR(glm::length(one.all()[0].place() - core::dvec3(1e7 + 30, 30, 15)), 0.0, 1e-6);
}

TEST(SectionsTest, TheSelectedOneStaysSelected) {
  Sections sections;
  for (double x : {1.0, 2.0, 3.0}) ASSERT_TRUE(sections.add({x, 0, 0}, {1, 0, 0}));
  EXPECT_FALSE(sections.selected());
  sections.select(1);
  sections.remove(2);
  EXPECT_EQ(sections.selected(), 1u);
  sections.remove(0);
  EXPECT_EQ(sections.selected(), 0u);
  sections.remove(0);
  EXPECT_FALSE(sections.selected());
  sections.add({0, 0, 0}, {1, 0, 0});
  sections.select(0);
  sections.box({{0, 0, 0}, {1, 1, 1}});
  EXPECT_FALSE(sections.selected());
}

TEST(SectionsTest, SayWhatTheyKeep) {
  const LengthFormat lengths{Units::kMillimetres, 0};
  const auto words = [&](const core::dvec3& point, const core::dvec3& out, const core::dvec3& origin = {}) {
    return section_words({point, glm::normalize(out)}, origin, lengths);
  };
  EXPECT_EQ(words({1, 2, 12.3}, {0, 0, 1}), "below elevation 12,300 mm");
  EXPECT_EQ(words({1, 2, 12.3}, {0, 0, -2}), "above elevation 12,300 mm");
  EXPECT_EQ(words({-1, 2, 3}, {1, 0, 0}), "west of X -1,000 mm");
  EXPECT_EQ(words({-1, 2, 3}, {0, -1, 0}, {0, 1, 0}), "north of Y 1,000 mm");
  EXPECT_EQ(words({0, 0, 0}, {1, 1, 0}), "behind an upright plane, askew");
  EXPECT_EQ(words({0, 0, 0}, {1, 0, 1}), "behind a plane, 45° steep");
  Sections sections;
  ASSERT_TRUE(sections.add_middle(2, {{0, 0, 2}, {8, 8, 6}}));
  EXPECT_EQ(section_words(sections.all()[0], {}, lengths), "below elevation 4,000 mm");
}

/// A box is found however its sides came about, as long as they are at right angles.
TEST(SectionsTest, SixOfThemAreABox) {
  Sections sections;
  ASSERT_TRUE(sections.add({9, 9, 9}, {1, 1, 1}));
  EXPECT_FALSE(sections.box());
  const core::AabbD bounds{{1, 2, 3}, {4, 6, 8}};
  sections.box(bounds);
  ASSERT_TRUE(sections.add({0, 0, 5}, {0, 0, 1}));
  const auto sides = sections.box();
  ASSERT_TRUE(sides);
  const auto corners = box_corners(sections, *sides);
  EXPECT_EQ(corners[0], bounds.min);
  EXPECT_EQ(corners[7], bounds.max);
  EXPECT_EQ(corners[1], core::dvec3(4, 2, 3));
  sections.all()[(*sides)[0]].normal = glm::normalize(core::dvec3(1, 0.1, 0));
  EXPECT_FALSE(sections.box()) << "one was turned";
  sections.box(bounds);
  const std::vector<core::Plane> planes = sections.planes();
  Sections read;
  read.set(planes, bounds);
  EXPECT_TRUE(read.box()) << "out of a view file";
  read.remove(5);
  EXPECT_FALSE(read.box());
}

}  // namespace
}  // namespace sightline::apps::sections_test
