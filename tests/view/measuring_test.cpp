#include "sightline/apps/view/measuring.h"

#include <array>

#include <gtest/gtest.h>

namespace sightline::apps::measuring_test {
namespace {

measure::Snap at(const core::dvec3& point) {
  return {{measure::FeatureKind::kCorner, core::Kind::kBox, "", point}, point, "a corner"};
}

std::string row(const Measuring& measuring, const std::string& what, const LengthFormat& lengths = {}) {
  for (const auto& [name, value] : measuring.rows(lengths))
    if (name == what) return value;
  return "none";
}

TEST(Measuring, AThirdMarkGivesTheAngleAtTheSecond) {
  Measuring measuring;
  measuring.set_angles(true);
  for (const core::dvec3& point : {core::dvec3(3, 0, 0), core::dvec3(0.0), core::dvec3(2, 2, 0)})
    measuring.add(core::ItemId{0}, at(point));
  EXPECT_EQ(row(measuring, "angle at the second"), "45.0000°");
  EXPECT_EQ(row(measuring, "third"), "a corner");
  ASSERT_EQ(measuring.list().size(), 2u);
  EXPECT_NEAR(measuring.list()[1].distance(), std::sqrt(8.0), 1e-12);
  EXPECT_EQ(measuring.list()[1].words, "the other leg, at 45.0000°");
  measuring.add(core::ItemId{0}, at({9, 9, 9}));
  EXPECT_EQ(measuring.marks().size(), 1u) << "a fourth one begins anew";
  measuring.set_angles(false);
  EXPECT_TRUE(measuring.marks().empty());
  for (int i = 0; i < 3; ++i) measuring.add(core::ItemId{0}, at({double(i), 0, 0}));
  EXPECT_EQ(measuring.marks().size(), 1u);
}

TEST(Measuring, WeighsItems) {
  core::Scene scene;
  const std::array items{scene.add_primitive(scene.root(), core::Box{1, 2, 3}),
                         scene.add_primitive(scene.root(), core::Box{0.1f, 0.1f, 0.1f}),
                         scene.add_primitive(scene.root(), core::Line{0, 1})};
  Measuring measuring;
  ASSERT_TRUE(measuring.weigh(scene, std::span(items).first(1), 7850.0));
  EXPECT_EQ(row(measuring, "area"), "22 m²");
  EXPECT_EQ(row(measuring, "volume"), "6 m³");
  EXPECT_EQ(row(measuring, "mass at 7850 kg/m³"), "47100 kg");
  EXPECT_EQ(row(measuring, "volume", {Units::kFeet}), "211.888 ft³");
  EXPECT_EQ(row(measuring, "without volume"), "none");
  ASSERT_TRUE(measuring.weigh(scene, items, 1000.0));
  EXPECT_EQ(row(measuring, "items"), "3");
  EXPECT_EQ(row(measuring, "without volume"), "1 open or flat");
  measuring.add(core::ItemId{0}, at({0, 0, 0}));
  EXPECT_EQ(row(measuring, "volume"), "none") << "marks take its place";
}

}  // namespace
}  // namespace sightline::apps::measuring_test
