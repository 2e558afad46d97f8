// The rows of the tree panel, against rows that recursion lists.
#include "sightline/apps/view/tree_rows.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "sightline/tests/view/random_scene.h"

namespace sightline::tests::tree_rows_test {
namespace {

using apps::TreeRow;
using apps::TreeRows;
using core::NodeId;
using core::Scene;
using Nodes = std::vector<NodeId>;

struct Earlier {
  bool operator()(NodeId a, NodeId b) const {
    return a.index != b.index ? a.index < b.index : a.generation < b.generation;
  }
};
using NodeSet = std::set<NodeId, Earlier>;

/// Walks over all nodes for every answer.
struct SlowTree {
  const Scene& scene;
  NodeSet expanded, unfiltered_expanded, matches, members;
  bool filtered = false;

  bool member(NodeId node) const { return !filtered || members.contains(node); }
  bool has_children(NodeId node) const {
    for (NodeId c = scene.first_child(node); c.valid(); c = scene.next_sibling(c))
      if (member(c)) return true;
    return false;
  }
  void list(NodeId node, std::uint32_t depth, std::vector<TreeRow>& rows) const {
    if (!member(node)) return;
    std::uint32_t items = 0;
    for (core::ItemId i = scene.first_item(node); i != core::kNoItem; i = scene.next_item(i)) ++items;
    const bool children = has_children(node);
    rows.push_back({node, depth, items, children, children && expanded.contains(node), matches.contains(node)});
    if (!rows.back().expanded) return;
    for (NodeId c = scene.first_child(node); c.valid(); c = scene.next_sibling(c)) list(c, depth + 1, rows);
  }
  void expand_all(NodeId node) {
    if (!member(node)) return;
    if (has_children(node)) expanded.insert(node);
    for (NodeId c = scene.first_child(node); c.valid(); c = scene.next_sibling(c)) expand_all(c);
  }
  void reveal(NodeId node) {
    if (!member(node)) return;
    for (NodeId p = scene.parent(node); p.valid(); p = scene.parent(p)) expanded.insert(p);
  }
  void set_filter(const Nodes& nodes) {
    if (!filtered) unfiltered_expanded = expanded;
    filtered = true;
    matches = members = NodeSet(nodes.begin(), nodes.end());
    expanded.clear();
    for (NodeId node : nodes)
      for (NodeId p = scene.parent(node); p.valid(); p = scene.parent(p)) members.insert(p), expanded.insert(p);
  }
  void clear_filter() {
    if (filtered) expanded = unfiltered_expanded;
    filtered = false;
    matches.clear();
  }
};

void expect_same(const TreeRows& tree, const SlowTree& slow) {
  std::vector<TreeRow> rows;
  slow.list(slow.scene.root(), 0, rows);
  ASSERT_EQ(tree.row_count(), rows.size());
  NodeSet with_row;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    SCOPED_TRACE(i);
    const TreeRow row = tree.row(i), &expected = rows[i];
    ASSERT_EQ(row.node, expected.node);
    ASSERT_EQ(row.depth, expected.depth);
    ASSERT_EQ(row.items, expected.items);
    ASSERT_EQ(row.has_children, expected.has_children);
    ASSERT_EQ(row.expanded, expected.expanded);
    ASSERT_EQ(row.match, expected.match);
    ASSERT_EQ(tree.row_of(row.node), i);
    with_row.insert(row.node);
  }
  for (const NodeId node : nodes_of(slow.scene)) {
    ASSERT_TRUE(tree.contains(node));
    ASSERT_EQ(tree.row_of(node).has_value(), with_row.contains(node));
  }
}

/// One random operation on both.
void operate(TreeRows& tree, SlowTree& slow, const Nodes& nodes, Random& random) {
  const NodeId node = nodes[random() % nodes.size()];
  switch (random() % 16) {
    case 0:
      tree.expand_all_below(node);
      return slow.expand_all(node);
    case 1: {
      Nodes matches;
      for (auto n = random() % 6; n > 0; --n) matches.push_back(nodes[random() % nodes.size()]);
      tree.set_filter(matches);
      return slow.set_filter(matches);
    }
    case 2:
      tree.clear_filter();
      return slow.clear_filter();
    case 3:
    case 4:
      slow.reveal(node);
      EXPECT_EQ(tree.reveal(node).has_value(), slow.member(node));
      return;
    case 5:
    case 6:
    case 7:
    case 8:
    case 9:
      tree.collapse(node);
      slow.expanded.erase(node);
      return;
    default:
      tree.expand(node);
      if (slow.member(node) && slow.has_children(node)) slow.expanded.insert(node);
  }
}

/// Removes and reparents a few nodes.
void edit(Scene& scene, Random& random) {
  for (int i = 0; i < 5; ++i) {
    const Nodes nodes = nodes_of(scene);
    if (nodes.size() < 3) return;
    const NodeId node = nodes[1 + random() % (nodes.size() - 1)], to = nodes[random() % nodes.size()];
    if (i == 0) {
      scene.remove_node(node);
    } else {
      (void)scene.reparent(node, to);  // refused where `to` lies below `node`
    }
  }
}

TEST(TreeRows, AreThoseOfRecursionAfterRandomOperations) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Scene scene;
    grow(scene, random, seed % 4 == 0 ? 3000 : random() % 300);
    TreeRows tree;
    tree.reset(scene);
    SlowTree slow{scene, {scene.root()}, {}, {}, {}};
    for (int round = 0; round < 4; ++round) {
      const Nodes nodes = nodes_of(scene);
      for (int i = 0; i < 60; ++i) {
        operate(tree, slow, nodes, random);
        if (i % 5 == 0) expect_same(tree, slow);
        if (testing::Test::HasFatalFailure()) return;
      }
      edit(scene, random);
      grow(scene, random, random() % 20);
      tree.reset(scene);
      slow.clear_filter();
      std::erase_if(slow.expanded, [&](NodeId node) { return !scene.contains(node) || !slow.has_children(node); });
      expect_same(tree, slow);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(TreeRows, BeforeTheFirstResetThereAreNone) {
  const Scene scene;
  TreeRows tree;
  EXPECT_EQ(tree.row_count(), 0u);
  EXPECT_FALSE(tree.contains(scene.root()));
  EXPECT_EQ(tree.row_of(scene.root()), std::nullopt);
  EXPECT_EQ(tree.reveal(scene.root()), std::nullopt);
}

TEST(TreeRows, OfTheRootAlone) {
  const Scene scene;
  TreeRows tree;
  tree.reset(scene);
  tree.expand(scene.root());
  ASSERT_EQ(tree.row_count(), 1u);
  EXPECT_FALSE(tree.row(0).has_children);
  EXPECT_FALSE(tree.row(0).expanded);
}

TEST(TreeRows, AreStaleAfterEditsUntilReset) {
  Scene scene;
  TreeRows tree;
  EXPECT_TRUE(tree.stale(scene));
  tree.reset(scene);
  EXPECT_FALSE(tree.stale(scene));
  const NodeId node = scene.add_node(scene.root());
  EXPECT_TRUE(tree.stale(scene));
  EXPECT_FALSE(tree.contains(node));
  EXPECT_EQ(tree.reveal(node), std::nullopt);
  tree.reset(scene);
  EXPECT_EQ(tree.row_of(node), 1u);
  scene.add_primitive(node, core::Box{1, 1, 1});
  EXPECT_TRUE(tree.stale(scene));
}

TEST(TreeRows, KnowNoNodeThatTookTheIndexOfAnother) {
  Scene scene;
  const NodeId old = scene.add_node(scene.root());
  TreeRows tree;
  tree.reset(scene);
  scene.remove_node(old);
  const NodeId same_index = scene.add_node(scene.root());
  ASSERT_EQ(same_index.index, old.index);
  EXPECT_FALSE(tree.contains(same_index));
  tree.reset(scene);
  EXPECT_FALSE(tree.contains(old));
  EXPECT_TRUE(tree.contains(same_index));
}

TEST(TreeRows, OfAMillionNodesBelowEachOther) {
  Scene scene;
  NodeId deepest = scene.root();
  for (int i = 0; i < 1'000'000; ++i) deepest = scene.add_node(deepest);
  TreeRows tree;
  tree.reset(scene);
  EXPECT_EQ(tree.row_count(), 2u);
  EXPECT_EQ(tree.reveal(deepest), 1'000'000u);
  EXPECT_EQ(tree.row(1'000'000).depth, 1'000'000u);
  tree.collapse(tree.row(500'000).node);
  EXPECT_EQ(tree.row_count(), 500'001u);
  tree.set_filter(Nodes{deepest});
  EXPECT_EQ(tree.row_count(), 1'000'001u);
}

TEST(TreeLabel, NamesANodeOrItsFirstItem) {
  Scene scene;
  const NodeId empty = scene.add_node(scene.root()), named = scene.add_node(scene.root(), "/PIPE-100");
  const NodeId pipe = scene.add_node(named), elbow = scene.add_node(named);
  const core::ItemId cylinder = scene.add_primitive(pipe, core::Cylinder{1, 1});
  scene.add_primitive(pipe, core::Box{1, 1, 1});
  const core::ItemId torus = scene.add_primitive(elbow, core::CircularTorus{2, 1, 1});
  EXPECT_EQ(apps::label(scene, scene.root()), "Model");
  EXPECT_EQ(apps::label(scene, empty), "Group " + std::to_string(empty.index));
  EXPECT_EQ(apps::label(scene, named), "/PIPE-100");
  EXPECT_EQ(apps::label(scene, pipe), "Cylinder " + std::to_string(to_index(cylinder)));
  EXPECT_EQ(apps::label(scene, elbow), "Circular torus " + std::to_string(to_index(torus)));
  scene.set_name(scene.root(), "Site");
  EXPECT_EQ(apps::label(scene, scene.root()), "Site");
}

}  // namespace
}  // namespace sightline::tests::tree_rows_test
