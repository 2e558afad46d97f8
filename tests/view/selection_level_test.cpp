// What clicks take at each level, and the distance of two parts against that of each pair of their items.
#include "sightline/apps/view/selection_level.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "sightline/analysis/measure/distances.h"
#include "sightline/apps/view/measuring.h"

namespace sightline::apps::selection_level_test {
namespace {

using core::ItemId;
using core::NodeId;

bool any(ItemId) {
  return true;
}

/// plant.rvm / pipe / { flange / (no name): 0 1, bolt: 2 }, and bare.stl: 3 4.
class SelectionLevelTest : public ::testing::Test {
 protected:
  void SetUp() override {
    file = scene.add_node(scene.root(), "plant.rvm");
    pipe = scene.add_node(file, "pipe");
    flange = scene.add_node(pipe, "flange");
    const NodeId unnamed = scene.add_node(flange), bolt = scene.add_node(pipe, "bolt");
    bare = scene.add_node(scene.root(), "bare.stl");
    for (const NodeId node : {unnamed, unnamed, bolt, bare, bare}) scene.add_primitive(node, core::Sphere{1.0f});
  }
  std::vector<ItemId> taken(ItemId item, SelectionLevel level) const { return taken_at(scene, item, level).items; }

  core::Scene scene;
  NodeId file, pipe, flange, bare;
  const std::vector<ItemId> all{ItemId{0}, ItemId{1}, ItemId{2}, ItemId{3}, ItemId{4}};
};

TEST_F(SelectionLevelTest, TakesWhatTheLevelSays) {
  const std::vector two{ItemId{0}, ItemId{1}}, three{ItemId{0}, ItemId{1}, ItemId{2}};
  EXPECT_EQ(taken(ItemId{1}, SelectionLevel::kItem), std::vector{ItemId{1}});
  EXPECT_EQ(taken(ItemId{1}, SelectionLevel::kPart), two);
  EXPECT_EQ(taken(ItemId{1}, SelectionLevel::kAssembly), three);
  EXPECT_EQ(taken(ItemId{1}, SelectionLevel::kFile), three);
  EXPECT_EQ(taken_at(scene, ItemId{1}, SelectionLevel::kPart).node, flange);
  EXPECT_EQ(taken_at(scene, ItemId{1}, SelectionLevel::kAssembly).node, pipe);
  EXPECT_EQ(taken_at(scene, ItemId{1}, SelectionLevel::kFile).node, file);
}

TEST_F(SelectionLevelTest, AnItemOfNoPartIsOneByItself) {
  for (const SelectionLevel level : {SelectionLevel::kPart, SelectionLevel::kAssembly})
    EXPECT_EQ(taken(ItemId{3}, level), std::vector{ItemId{3}});
  EXPECT_EQ(taken(ItemId{3}, SelectionLevel::kFile), (std::vector{ItemId{3}, ItemId{4}}));
  const ItemId of_root = scene.add_primitive(scene.root(), core::Sphere{1.0f});
  EXPECT_EQ(taken(of_root, SelectionLevel::kPart), std::vector{of_root});
}

/// As rectangles select: from left to right what lies wholly in them, otherwise what has any part in them.
TEST_F(SelectionLevelTest, GroupsAreWholeOrAny) {
  const std::vector some{ItemId{1}, ItemId{2}, ItemId{4}};
  const auto groups = [&](bool whole, const std::function<bool(ItemId)>& counts) {
    return taken_by(scene, some, SelectionLevel::kPart, whole, counts);
  };
  using Groups = std::vector<std::vector<ItemId>>;
  EXPECT_EQ(groups(true, any), (Groups{{ItemId{2}}, {ItemId{4}}}));
  EXPECT_EQ(groups(false, any), (Groups{{ItemId{0}, ItemId{1}}, {ItemId{2}}, {ItemId{4}}}));
  EXPECT_EQ(groups(true, [](ItemId item) { return item != ItemId{0}; }),
            (Groups{{ItemId{1}}, {ItemId{2}}, {ItemId{4}}}))
      << "what is hidden does not count";
}

TEST_F(SelectionLevelTest, GroupsHaveTheItemsThatAreGiven) {
  const std::vector some{ItemId{0}, ItemId{1}, ItemId{2}, ItemId{4}};
  const auto items_of = [&](SelectionLevel level, std::size_t most) {
    std::vector<std::vector<ItemId>> items;
    for (const Taken& group : groups_of(scene, some, level, most)) items.push_back(group.items);
    return items;
  };
  using Groups = std::vector<std::vector<ItemId>>;
  EXPECT_EQ(items_of(SelectionLevel::kPart, 9), (Groups{{ItemId{0}, ItemId{1}}, {ItemId{2}}, {ItemId{4}}}));
  EXPECT_EQ(items_of(SelectionLevel::kFile, 9), (Groups{{ItemId{0}, ItemId{1}, ItemId{2}}, {ItemId{4}}}));
  EXPECT_EQ(items_of(SelectionLevel::kPart, 2), (Groups{{ItemId{0}, ItemId{1}}, {ItemId{2}}}));
}

TEST(MeasuringParts, FindsTheNearestOfAllPairs) {
  std::mt19937 random{5};
  const auto length = [&](double most) { return std::uniform_real_distribution<double>(0.1, most)(random); };
  for (int round = 0; round < 40; ++round) {
    SCOPED_TRACE(testing::Message() << "round " << round << " of seed 5");
    core::Scene scene;
    std::vector<ItemId> parts[2];
    for (int i = 0; i < 14; ++i) {
      const double x = length(9.0) + (i % 2) * length(12.0), y = length(9.0);
      const core::Affine place = core::translation({x, y, length(9.0)});
      const float size = float(length(1.5));
      const ItemId made = i % 3 == 0 ? scene.add_primitive(scene.root(), core::Sphere{size}, place)
                                     : scene.add_primitive(scene.root(), core::Cylinder{0.5f * size, 2.0f}, place);
      parts[i % 2].push_back(made);
    }
    double least = std::numeric_limits<double>::infinity();
    for (const ItemId a : parts[0])
      for (const ItemId b : parts[1])
        least = std::min(least, measure::distance(*measure::Item::create(scene, a), *measure::Item::create(scene, b)).distance);
    Measuring measuring;
    ASSERT_TRUE(measuring.between(scene, parts[0], parts[1]));
    EXPECT_EQ(measuring.distance()->distance, least);
    EXPECT_LE(measuring.distance()->error, 1e-8);
  }
}

TEST(MeasuringParts, TooManyPairsAreRefused) {
  core::Scene scene;
  const std::vector<ItemId> many(20'000, scene.add_primitive(scene.root(), core::Sphere{1.0f}));
  Measuring measuring;
  EXPECT_FALSE(measuring.between(scene, many, many));
  EXPECT_FALSE(measuring.distance());
  EXPECT_TRUE(measuring.between(scene, many, {many.data(), 1}));
}

}  // namespace
}  // namespace sightline::apps::selection_level_test
