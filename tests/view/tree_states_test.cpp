// What shows below each node of a tree, against a count item by item.
#include "sightline/apps/view/tree_states.h"

#include <gtest/gtest.h>

#include "sightline/apps/common/tree_walk.h"
#include "sightline/tests/view/random_scene.h"

namespace sightline::apps::tree_states_test {
namespace {

using core::ItemId;

/// Counted by walking up from every item.
TreeStates::Below counted(const core::Scene& scene, const Document& document, core::NodeId node) {
  TreeStates::Below below;
  for (ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    for (core::NodeId up = scene.node_of(item); up.valid(); up = scene.parent(up)) {
      if (up != node) continue;
      ++below.items;
      below.shown += document.shown(item);
    }
  return below;
}

TEST(TreeStates, CountWhatShowsBelowEachNode) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    core::Scene scene;
    tests::Random random(seed);
    tests::grow(scene, random, 60);
    engine::Engine engine = *engine::Engine::create(scene);
    Document document(scene, engine);
    TreeRows rows;
    rows.reset(scene);
    TreeStates states;
    const auto check = [&](const char* when) {
      states.follow(rows, scene, document);
      for (const core::NodeId node : tests::nodes_of(scene)) {
        const auto below = states.below(rows, node), expected = counted(scene, document, node);
        EXPECT_EQ(below.items, expected.items) << when;
        EXPECT_EQ(below.shown, expected.shown) << when;
      }
    };
    check("at first");
    std::vector<ItemId> some;
    for (ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
      if (random() % 3 == 0) some.push_back(item);
    ASSERT_TRUE(document.hide(some));
    check("some hidden");
    ASSERT_TRUE(document.show(std::span(some).first(some.size() / 2)));
    check("half of them shown again");
    ASSERT_TRUE(document.undo());
    check("undone");
    ASSERT_TRUE(document.hide(apps::items_below(scene, scene.root())));
    check("all hidden");
    EXPECT_TRUE(states.below(rows, scene.root()).hidden());
  }
}

}  // namespace
}  // namespace sightline::apps::tree_states_test
