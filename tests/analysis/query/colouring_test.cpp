#include "sightline/analysis/query/colouring.h"

#include <cmath>

#include <glm/gtc/matrix_access.hpp>

#include "sightline/core/internal/srgb.h"
#include "sightline/tests/analysis/query/plant.h"

namespace sightline::query::colouring_test {
namespace {

using core::ItemId;
using ColouringTest = tests::QueryTest;

std::string words(const core::Expected<Colouring>& colouring) {
  if (!colouring) return colouring.error().message;
  std::string text;
  for (const ColourGroup& group : colouring->groups)
    text += (text.empty() ? "" : ", ") + group.label + " " + std::to_string(group.items);
  return text;
}

TEST_F(ColouringTest, NumbersRiseAndWhatHasNoneIsLast) {
  const auto colouring = colour_by(scene, "DN");
  EXPECT_EQ(words(colouring), "80 mm 2, 150 mm 1, 300 1, no value 1");
  EXPECT_EQ(colouring->of_item[to_index(pipe)], 1);
  EXPECT_EQ(colouring->of_item[to_index(other)], 3);
  EXPECT_EQ(words(colour_by(scene, "System")), "CW 3, HW 1, no value 1");
  EXPECT_EQ(words(colour_by(scene, "@kind")), "box 3, sphere 2");
  EXPECT_FALSE(colour_by(scene, "nothing"));
}

/// A scene in which item i has the value `value(i)`.
template <class ValueOf>
core::Scene scene_of(int items, const ValueOf& value) {
  core::Scene scene;
  for (int i = 0; i < items; ++i) {
    const core::NodeId node = scene.add_node(scene.root());
    scene.set_attribute(node, "key", value(i));
    scene.add_primitive(node, core::Sphere{1.0f});
  }
  return scene;
}

TEST(Colouring, ManyNumbersHaveSevenRangesOfEquallyManyItems) {
  const auto even = colour_by(scene_of(700, [](int i) { return std::to_string(i); }), "key");
  EXPECT_EQ(words(even),
            "0 – 99 100, 100 – 199 100, 200 – 299 100, 300 – 399 100, 400 – 499 100, 500 – 599 100, 600 – 699 100");
  // Half of the items share a number, which is a range of its own.
  const auto skewed = colour_by(scene_of(1400, [](int i) { return std::to_string(i < 700 ? 5 : i); }), "key");
  ASSERT_TRUE(skewed);
  EXPECT_EQ(skewed->groups.size(), 7u);
  EXPECT_EQ(skewed->groups[0].label, "5");
  EXPECT_EQ(skewed->groups[0].items, 700u);
  for (std::size_t i = 1; i < 7; ++i) EXPECT_NEAR(double(skewed->groups[i].items), 700.0 / 6.0, 1.0);
}

TEST(Colouring, AFewTextsAmongNumbersAreOthers) {
  EXPECT_EQ(words(colour_by(scene_of(40, [](int i) { return i == 7 ? "n/a" : std::to_string(i % 2); }), "key")),
            "0 20, 1 19, n/a 1");
  EXPECT_EQ(words(colour_by(scene_of(4, [](int i) { return i == 2 ? "n/a" : std::to_string(i); }), "key")),
            "0 1, 1 1, 3 1, n/a 1");
  EXPECT_EQ(words(colour_by(scene_of(4, [](int) { return "7"; }), "key")), "7 4");
}

TEST(Colouring, TheMostFrequentTextsHaveColours) {
  const auto colouring =
      colour_by(scene_of(210, [](int i) { return "v" + std::to_string(int(std::sqrt(2.0 * i))); }), "key");
  ASSERT_TRUE(colouring);
  ASSERT_EQ(colouring->groups.size(), 10u);
  EXPECT_EQ(colouring->groups[9].label, "12 other values");
  std::uint32_t items = 0;
  for (const ColourGroup& group : colouring->groups) items += group.items;
  EXPECT_EQ(items, 210u);
}

/// CIE L*a*b* of a colour under D65.
core::dvec3 lab(const core::dvec3& linear) {
  const core::dvec3 xyz = core::dvec3(glm::dot(core::dvec3(0.4124, 0.3576, 0.1805), linear) / 0.9505,
                                      glm::dot(core::dvec3(0.2126, 0.7152, 0.0722), linear),
                                      glm::dot(core::dvec3(0.0193, 0.1192, 0.9505), linear) / 1.089);
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116.0; };
  return {116.0 * f(xyz.y) - 16.0, 500.0 * (f(xyz.x) - f(xyz.y)), 200.0 * (f(xyz.y) - f(xyz.z))};
}

/// How a person sees a colour who lacks long, middle or short cones, and one who has all: G. Machado, M. Oliveira,
/// L. Fernandes, "A Physiologically-based Model for Simulation of Color Vision Deficiency", 2009.
const core::dmat3 kEyes[] = {glm::transpose(core::dmat3(0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216,
                                                        -0.003882, -0.048116, 1.051998)),
                             glm::transpose(core::dmat3(0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413,
                                                        -0.011820, 0.042940, 0.968881)),
                             glm::transpose(core::dmat3(1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602,
                                                        0.004733, 0.691367, 0.303900)),
                             core::dmat3(1.0)};

double least_difference(const std::vector<ColourGroup>& groups, const core::dmat3& eyes) {
  double least = 1e9;
  const auto seen = [&](const core::vec3& colour) {
    core::dvec3 linear;
    for (int i = 0; i < 3; ++i)
      linear[i] = colour[i] <= 0.04045f ? colour[i] / 12.92 : std::pow((colour[i] + 0.055) / 1.055, 2.4);
    return lab(glm::clamp(eyes * linear, 0.0, 1.0));
  };
  for (std::size_t i = 0; i < groups.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      least = std::min(least, glm::length(seen(groups[i].colour) - seen(groups[j].colour)));
  return least;
}

TEST(Colouring, ColourBlindPeopleTellAllGroupsApart) {
  // All groups there can be, with and without numbers.
  auto texts = scene_of(40, [](int i) { return i < 20 ? "v" + std::to_string(i % 10) : "w" + std::to_string(i % 9); });
  auto numbers = scene_of(60, [](int i) { return i == 7 ? "n/a" : std::to_string(i); });
  for (core::Scene* scene : {&texts, &numbers}) {
    scene->add_primitive(scene->root(), core::Sphere{1.0f});
    const auto colouring = colour_by(*scene, "key");
    ASSERT_TRUE(colouring);
    for (const core::dmat3& eyes : kEyes)
      EXPECT_GT(least_difference(colouring->groups, eyes), 13.0) << words(colouring);
  }
}

}  // namespace
}  // namespace sightline::query::colouring_test
