// Names of items: what they find again in the same model read anew, against lists of items.
#include "sightline/apps/viewpoints/item_names.h"

#include <gtest/gtest.h>

#include "sightline/tests/view/random_scene.h"

namespace sightline::apps::item_names_test {
namespace {

using core::ItemId;

/// Trees with names that repeat, are empty, and look like what names end with.
void build(core::Scene& scene, std::uint64_t seed) {
  tests::Random random{seed};
  tests::grow(scene, random, 80);
  const char* names[] = {"", "a", "a", "b/c", "c", "x?", "x?nth=2", "#1", "\xc3\xb6 <&>\""};
  for (const core::NodeId node : tests::nodes_of(scene))
    if (node != scene.root()) scene.set_name(node, names[random() % std::size(names)]);
}

std::vector<ItemId> items_of(const core::Scene& scene) {
  std::vector<ItemId> items;
  for (const core::NodeId node : tests::nodes_of(scene))
    for (ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item))
      items.push_back(item);
  std::sort(items.begin(), items.end());
  return items;
}

TEST(ItemNamesTest, FindTheSameItemsInTheModelReadAgain) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    core::Scene scene, again;
    build(scene, seed);
    build(again, seed);
    const ItemNames names(scene), names_again(again);
    const std::vector<ItemId> all = items_of(scene);
    tests::Random random{seed};
    for (const unsigned share : {0u, 1u, 50u, 95u, 100u}) {
      std::vector<ItemId> some;
      for (const ItemId item : all)
        if (random() % 100 < share) some.push_back(item);
      for (const bool others : {false, true}) {
        PartSet set = names.name(some, others);
        EXPECT_TRUE(others || !set.all_but);
        for (PartName& part : set.parts) part = part_of(to_text(part));
        const ItemNames::Found found = names_again.find(set);
        EXPECT_EQ(found.items, some);
        EXPECT_EQ(found.missing, 0u);
      }
    }
  }
}

TEST(ItemNamesTest, PathsAreThoseOfTheScene) {
  core::Scene scene;
  build(scene, 7);
  const ItemNames names(scene);
  for (const ItemId item : items_of(scene)) {
    const PartSet set = names.name(std::vector<ItemId>{item}, false);
    ASSERT_EQ(set.parts.size(), 1u);
    if (set.parts[0].item) {
      EXPECT_EQ(set.parts[0].node, scene.path(scene.node_of(item)));
    }
  }
}

TEST(ItemNamesTest, WholeSubtreesHaveOneName) {
  core::Scene scene;
  const core::NodeId pipe = scene.add_node(scene.root(), "pipe"), valve = scene.add_node(scene.root(), "valve");
  std::vector<ItemId> of_pipe;
  for (int i = 0; i < 100; ++i)
    of_pipe.push_back(scene.add_primitive(scene.add_node(pipe, "part"), core::Sphere{1.0f}));
  scene.add_primitive(valve, core::Sphere{1.0f});
  const ItemNames names(scene);
  EXPECT_EQ(names.name(of_pipe, true), (PartSet{false, {{"pipe", 0, {}, {}}}}));
  of_pipe.erase(of_pipe.begin() + 7);
  EXPECT_EQ(to_text(names.name(std::vector<ItemId>{of_pipe[7]}, false).parts[0]), "pipe/part?nth=9");
  EXPECT_EQ(names.name(of_pipe, true).parts.size(), 2u) << "all but one part and the valve";
}

TEST(ItemNamesTest, WhatIsMissingIsCountedAndHidesNothing) {
  core::Scene scene;
  const core::NodeId node = scene.add_node(scene.root(), "a");
  const ItemId item = scene.add_primitive(node, core::Sphere{1.0f});
  scene.set_attribute(node, "IfcGuid", "0123456789abcdefghijkl");
  const ItemNames names(scene);
  const PartName known{"elsewhere", 0, {}, "0123456789abcdefghijkl"}, unknown{"b", 0, {}, {}}, beyond{"a", 0, 5, {}};
  EXPECT_EQ(names.find({false, {known}}).items, std::vector<ItemId>{item}) << "by its GUID";
  EXPECT_EQ(names.find({false, {unknown, beyond}}).missing, 2u);
  EXPECT_TRUE(names.find({true, {unknown}}).items.empty()) << "of all but nothing known";
  EXPECT_EQ(names.find({true, {}}).items, std::vector<ItemId>{item});
  EXPECT_EQ(names.find({false, {{"", 0, {}, "none"}}}).missing, 1u) << "not the whole model";
}

}  // namespace
}  // namespace sightline::apps::item_names_test
