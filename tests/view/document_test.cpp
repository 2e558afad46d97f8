// Selection, visibility and undo, against a plain list of what each item should be.
#include "sightline/apps/view/document.h"

#include <random>

#include <gtest/gtest.h>

#include "sightline/apps/common/tree_walk.h"
#include "sightline/engine/pick.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::apps::document_test {
namespace {

using core::ItemId;

constexpr ItemId kItems{60};

class DocumentTest : public ::testing::Test {
 protected:
  /// A row of spheres, five on each node.
  void SetUp() override {
    core::NodeId node;
    for (ItemId i{0}; i < kItems; ++i) {
      if (to_index(i) % 5 == 0) nodes.push_back(node = scene.add_node(scene.root(), "node"));
      scene.add_primitive(node, core::Sphere{0.8f}, core::translation({double(i), 0.0, 0.0}));
    }
    engine = std::make_unique<engine::Engine>(*engine::Engine::create(scene));
    document = std::make_unique<Document>(scene, *engine);
  }
  /// Whether a ray along y finds an item: hidden ones and ghosts are not found.
  bool found(ItemId item) const {
    const auto hit = engine->pick(core::Ray{{double(item), -5.0, 0.0}, {0.0, 1.0, 0.0}});
    return *hit && (*hit)->item == item;
  }
  std::vector<ItemId> selection() const { return {document->selection().begin(), document->selection().end()}; }

  core::Scene scene;
  std::vector<core::NodeId> nodes;
  std::unique_ptr<engine::Engine> engine;
  std::unique_ptr<Document> document;
};

/// An item, then its part, then the part above; what is selected with its whole part shows that part's properties.
TEST_F(DocumentTest, SelectsWholeParts) {
  const core::NodeId above = scene.add_node(scene.root(), "above");
  ASSERT_TRUE(scene.reparent(nodes[0], above));
  ASSERT_TRUE(scene.reparent(nodes[1], above));
  EXPECT_FALSE(document->node_of_selection().valid());
  EXPECT_FALSE(document->selected_part().valid());
  const ItemId one[] = {ItemId{7}};
  ASSERT_TRUE(document->select(one));
  EXPECT_EQ(document->node_of_selection(), nodes[1]);
  EXPECT_FALSE(document->selected_part().valid());
  for (const core::NodeId part : {nodes[1], above, scene.root()}) {
    ASSERT_TRUE(document->select_part());
    EXPECT_EQ(selection(), items_below(scene, part));
    EXPECT_EQ(document->selected_part(), part);
  }
  const ItemId apart[] = {ItemId{1}, ItemId{6}};
  ASSERT_TRUE(document->select(apart));
  EXPECT_EQ(document->node_of_selection(), above);
  EXPECT_FALSE(document->selected_part().valid());
}

TEST_F(DocumentTest, SelectsInThreeWays) {
  const ItemId first[] = {ItemId{3}, ItemId{1}}, second[] = {ItemId{1}, ItemId{7}};
  ASSERT_TRUE(document->select(first));
  EXPECT_EQ(selection(), (std::vector<ItemId>{ItemId{1}, ItemId{3}}));
  ASSERT_TRUE(document->select(second, SelectMode::kToggle));
  EXPECT_EQ(selection(), (std::vector<ItemId>{ItemId{3}, ItemId{7}}));
  ASSERT_TRUE(document->select(second, SelectMode::kAdd));
  EXPECT_EQ(selection(), (std::vector<ItemId>{ItemId{1}, ItemId{3}, ItemId{7}}));
  ASSERT_TRUE(document->select(second));
  EXPECT_EQ(selection(), (std::vector<ItemId>{ItemId{1}, ItemId{7}}));
  EXPECT_EQ(items_below(scene, nodes[1]), (std::vector<ItemId>{ItemId{5}, ItemId{6}, ItemId{7}, ItemId{8}, ItemId{9}}));
  EXPECT_EQ(items_below(scene, scene.root()).size(), std::size_t(kItems));
  const core::AabbD box = document->bounds(second);
  EXPECT_NEAR(box.min.x, 0.6, 1e-6);
  EXPECT_NEAR(box.max.x, 7.4, 1e-6);
}

TEST_F(DocumentTest, HiddenItemsAreNotFoundAndNotSelected) {
  const ItemId some[] = {ItemId{2}, ItemId{4}}, more[] = {ItemId{4}, ItemId{5}};
  ASSERT_TRUE(document->select(more) && document->hide(some));
  EXPECT_EQ(selection(), (std::vector<ItemId>{ItemId{5}}));
  EXPECT_FALSE(found(ItemId{2}) || found(ItemId{4}));
  EXPECT_TRUE(found(ItemId{3}));
  ASSERT_TRUE(document->select(some));
  EXPECT_TRUE(selection().empty());
  ASSERT_TRUE(document->isolate(more));
  EXPECT_EQ(document->hidden(), std::size_t(to_index(kItems) - 2));
  EXPECT_TRUE(found(ItemId{4}) && found(ItemId{5}));
  ASSERT_TRUE(document->show_all() && document->ghost_others(more));
  EXPECT_EQ(document->ghosts(), std::size_t(to_index(kItems) - 2));
  EXPECT_TRUE(found(ItemId{4}) && !found(ItemId{6})) << "picks go through ghosts";
  ASSERT_TRUE(document->show_all());
  EXPECT_TRUE(found(ItemId{6}));
  EXPECT_EQ(document->hidden() + document->ghosts(), 0u);
}

TEST_F(DocumentTest, HoveringIsNoStepAndLeavesTheImage) {
  const std::uint64_t version = document->version();
  document->hovered = taken_at(scene, ItemId{3}, SelectionLevel::kItem);
  EXPECT_EQ(document->hovered->items, std::vector{ItemId{3}});
  EXPECT_EQ(document->version(), version);
  EXPECT_EQ(document->undo_steps(), 0u);
  ASSERT_TRUE(document->undo() && document->redo()) << "nothing to undo";
}

/// After any steps, undone and done again, flags, counts and what rays find are those of a list that is kept beside.
/// Whatever is hidden and shown meanwhile.
TEST_F(DocumentTest, WhatIsLeftOutStaysSoUntilItNoLongerIs) {
  const std::vector<ItemId> some{ItemId{2}, ItemId{4}}, more{ItemId{4}, ItemId{5}};
  ASSERT_TRUE(document->hide(std::vector<ItemId>{ItemId{2}}));
  const std::uint64_t version = document->version();
  const std::size_t steps = document->undo_steps();
  ASSERT_TRUE(document->leave_out(some));
  EXPECT_FALSE(found(ItemId{2}) || found(ItemId{4}));
  EXPECT_TRUE(document->left_out(ItemId{4}) && document->shown(ItemId{4}));
  EXPECT_EQ(document->version(), version);
  EXPECT_EQ(document->undo_steps(), steps);
  ASSERT_TRUE(document->select(some));
  EXPECT_EQ(selection(), std::vector<ItemId>{ItemId{4}});
  ASSERT_TRUE(document->show_all());
  EXPECT_FALSE(found(ItemId{2}) || found(ItemId{4})) << "left out, though no longer hidden";
  ASSERT_TRUE(document->hide(std::vector<ItemId>{ItemId{4}}));
  ASSERT_TRUE(document->leave_out(more));
  EXPECT_TRUE(found(ItemId{2}) && found(ItemId{3}));
  EXPECT_FALSE(found(ItemId{4}) || found(ItemId{5}));
  ASSERT_TRUE(document->leave_out({}));
  EXPECT_TRUE(found(ItemId{5}));
  EXPECT_FALSE(found(ItemId{4})) << "hidden";
  ASSERT_TRUE(document->undo());
  EXPECT_TRUE(found(ItemId{4}));
}

TEST_F(DocumentTest, UndoBringsBackEveryState) {
  constexpr unsigned kSeed = 11;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  constexpr Document::Flag kFlags[] = {Document::kSelected, Document::kHidden, Document::kGhost};
  const auto flags = [&] {
    std::vector<bool> all;
    for (ItemId item{0}; item < kItems; ++item)
      for (const Document::Flag flag : kFlags) all.push_back(document->is(item, flag));
    return all;
  };
  std::vector<std::vector<bool>> states{flags()};
  std::size_t now = 0;
  for (int step = 0; step < 400; ++step) {
    SCOPED_TRACE(step);
    std::vector<ItemId> some;
    for (ItemId item{0}; item < kItems; ++item)
      if (random() % 4 == 0) some.push_back(item);
    if (random() % 3 == 0)
      document->hovered = taken_at(scene, ItemId(random() % to_index(kItems)), SelectionLevel::kItem);
    const auto what = unsigned(random() % 9);
    if (what == 0 && now > 0) {
      ASSERT_TRUE(document->undo());
      --now;
    } else if (what == 1 && now + 1 < states.size()) {
      ASSERT_TRUE(document->redo());
      ++now;
    } else {
      const std::size_t steps = document->undo_steps();
      switch (what) {
        case 2:
          ASSERT_TRUE(document->hide(some));
          break;
        case 3:
          ASSERT_TRUE(document->isolate(some));
          break;
        case 4:
          ASSERT_TRUE(document->ghost_others(some));
          break;
        case 5:
          ASSERT_TRUE(document->show_all());
          break;
        default:
          ASSERT_TRUE(document->select(some, SelectMode(random() % 3)));
      }
      if (document->undo_steps() > steps || (steps == 100 && flags() != states[now])) {
        states.resize(now + 1);
        states.push_back(flags());
        ++now;
        if (states.size() > 101) {
          states.erase(states.begin());
          --now;
        }
      }
    }
    ASSERT_EQ(flags(), states[now]);
    std::size_t hidden = 0, ghosts = 0, selected = 0;
    for (ItemId item{0}; item < kItems; ++item) {
      hidden += document->is(item, Document::kHidden);
      ghosts += document->is(item, Document::kGhost);
      selected += document->is(item, Document::kSelected);
      const bool faint = document->is(item, Document::kGhost) && !document->is(item, Document::kSelected);
      ASSERT_EQ(found(item), !document->is(item, Document::kHidden) && !faint) << to_index(item);
    }
    ASSERT_EQ(document->hidden(), hidden);
    ASSERT_EQ(document->ghosts(), ghosts);
    ASSERT_EQ(document->selection().size(), selected);
  }
}

}  // namespace
}  // namespace sightline::apps::document_test
