#include "sightline/core/find_nodes.h"

#include <gtest/gtest.h>

namespace sightline::core::find_nodes_test {
namespace {

using Nodes = std::vector<NodeId>;

/// A plant as importers make it: names with and without slashes, one that begins another, one that two nodes have.
class FindNodes : public testing::Test {
 protected:
  NodeId add(NodeId parent, const char* name) { return scene.add_node(parent, name); }
  Nodes find(const std::string& text, NodeMatch expected) {
    const auto found = find_nodes(scene, scene.root(), std::vector<NodeCondition>{{"", text}});
    EXPECT_TRUE(found) << text;
    if (found && !found->nodes.empty()) {
      EXPECT_EQ(words_of(found->match), words_of(expected)) << text;
    }
    return found ? found->nodes : Nodes{};
  }
  Nodes find_all(const std::vector<NodeCondition>& conditions, NodeId top) {
    const auto found = find_nodes(scene, top, conditions);
    EXPECT_TRUE(found);
    return found ? found->nodes : Nodes{};
  }
  Nodes find_all(const std::vector<NodeCondition>& conditions) { return find_all(conditions, scene.root()); }

  Scene scene;
  NodeId file = add(scene.root(), "plant.rvm");
  NodeId site = add(file, "/SITE");
  NodeId rack = add(site, "/ZONE-RACK"), a1 = add(site, "/ZONE-A1"), a10 = add(site, "/ZONE-A10");
  NodeId pipe = add(rack, "/PIPE-21"), pipe0 = add(rack, "/PIPE-210"), pipe1 = add(rack, "/PIPE-211");
  NodeId branch = add(pipe, "/PIPE-21/B1"), unnamed = add(branch, ""), second = add(branch, "");
  NodeId flange = add(unnamed, "FLANGE 1 of BRANCH /PIPE-21/B1");
  NodeId tank = add(a1, "Tank"), other_tank = add(a10, "Tank"), lower_tank = add(a10, "tank");
  NodeId boiler = add(a1, "W\u00e4rme-Boiler 3");
};

TEST_F(FindNodes, ANameIsNoBeginningOfAnother) {
  EXPECT_EQ(find("/PIPE-21", NodeMatch::kName), (Nodes{pipe}));
  EXPECT_EQ(find("PIPE-21", NodeMatch::kName), (Nodes{pipe}));
  EXPECT_EQ(find("pipe-21", NodeMatch::kName), (Nodes{pipe}));
  EXPECT_EQ(find("ZONE-A1", NodeMatch::kName), (Nodes{a1}));
  EXPECT_EQ(find("Name=PIPE-21", NodeMatch::kValue), (Nodes{pipe}));
  EXPECT_EQ(find("name=/pipe-21", NodeMatch::kValue), (Nodes{pipe}));
  EXPECT_EQ(find("PIPE-2", NodeMatch::kName), Nodes{});
  EXPECT_EQ(find("Name=PIPE", NodeMatch::kName), Nodes{});
}

TEST_F(FindNodes, ByPathsAsTheyArePrintedAndByTheirEnds) {
  const auto all = find("", NodeMatch::kPattern);
  EXPECT_EQ(all.size(), scene.node_count());
  for (const NodeId node : all) {
    const auto match = scene.parent(node) == scene.root() ? NodeMatch::kName : NodeMatch::kPath;
    if (node != scene.root()) {
      EXPECT_EQ(find(scene.path(node), match), (Nodes{node}));
    }
  }
  EXPECT_EQ(find("/SITE/ZONE-RACK/PIPE-21", NodeMatch::kPath), (Nodes{pipe}));
  EXPECT_EQ(find("SITE/ZONE-RACK/PIPE-21/", NodeMatch::kPath), (Nodes{pipe}));
  EXPECT_EQ(find("zone-rack/pipe-21", NodeMatch::kPath), (Nodes{pipe}));
  EXPECT_EQ(find("ZONE-A10/Tank", NodeMatch::kPath), (Nodes{other_tank}));
  EXPECT_EQ(find("ZONE-A1/Tank", NodeMatch::kPath), (Nodes{tank}));
  EXPECT_EQ(find("PIPE-21/B1/#1", NodeMatch::kPath), (Nodes{second})) << "without a name, by its place";
  EXPECT_EQ(find("/PIPE-21/B1", NodeMatch::kName), (Nodes{branch})) << "a name with a slash";
  EXPECT_EQ(find("SITE/PIPE-21", NodeMatch::kPath), Nodes{}) << "not a child";
  EXPECT_EQ(find("E-RACK/PIPE-21", NodeMatch::kPath), Nodes{}) << "half of a name";
}

TEST_F(FindNodes, ExactCaseComesFirst) {
  EXPECT_EQ(find("Tank", NodeMatch::kName), (Nodes{tank, other_tank}));
  EXPECT_EQ(find("tank", NodeMatch::kName), (Nodes{lower_tank}));
  EXPECT_EQ(find("TANK", NodeMatch::kName), (Nodes{tank, other_tank, lower_tank}));
  EXPECT_EQ(find("ZONE-A10/tank", NodeMatch::kPath), (Nodes{lower_tank}));
}

TEST_F(FindNodes, ByValuesOfAttributes) {
  scene.set_attribute(pipe, "Type", "PIPE");
  scene.set_attribute(pipe0, "Type", "PIPE RACK");
  scene.set_attribute(a1, "Owner", "PIPE");
  scene.set_attribute(a10, "Ref", "=16401/23");
  EXPECT_EQ(find("Type=PIPE", NodeMatch::kValue), (Nodes{pipe}));
  EXPECT_EQ(find("type=pipe", NodeMatch::kValue), (Nodes{pipe}));
  EXPECT_EQ(find("PIPE", NodeMatch::kValue), (Nodes{pipe, a1}));
  EXPECT_EQ(find("Ref==16401/23", NodeMatch::kValue), (Nodes{a10}));
  EXPECT_EQ(find("=16401/23", NodeMatch::kValue), (Nodes{a10}));
  EXPECT_EQ(find("Type=", NodeMatch::kPattern), (Nodes{pipe, pipe0})) << "has the attribute";
  EXPECT_EQ(find("Type=RACK", NodeMatch::kValue), Nodes{}) << "values of one attribute are exact";
  EXPECT_EQ(find("Type=PIPE*", NodeMatch::kPattern), (Nodes{pipe, pipe0}));
  scene.set_attribute(tank, "Line", "PIPE-21");
  EXPECT_EQ(find("PIPE-21", NodeMatch::kName), (Nodes{pipe})) << "names before values";
  EXPECT_EQ(find_all({{"Line", "pipe-21"}}), (Nodes{tank}));
  EXPECT_EQ(find_all({{"Line", "pipe"}}), Nodes{});
  const NodeId odd = add(site, "a=b");
  EXPECT_EQ(find("a=b", NodeMatch::kName), (Nodes{odd}));
}

TEST_F(FindNodes, ByWholeWords) {
  EXPECT_EQ(find("FLANGE", NodeMatch::kWords), (Nodes{flange}));
  EXPECT_EQ(find("branch /pipe-21", NodeMatch::kWords), (Nodes{flange}));
  EXPECT_EQ(find("ANGE", NodeMatch::kWords), Nodes{});
  EXPECT_EQ(find("PIPE-", NodeMatch::kWords), Nodes{}) << "a digit follows";
  EXPECT_EQ(find("Boiler", NodeMatch::kWords), (Nodes{boiler}));
  EXPECT_EQ(find("rme", NodeMatch::kWords), Nodes{}) << "letters that are not ASCII are letters";
  EXPECT_EQ(find("w\u00e4rme-boiler 3", NodeMatch::kName), (Nodes{boiler}));
  EXPECT_EQ(find("PIPE", NodeMatch::kWords), (Nodes{pipe, branch, flange, pipe0, pipe1}));
  EXPECT_EQ(find("B1", NodeMatch::kWords), (Nodes{branch, flange}));
}

TEST_F(FindNodes, PatternsOnlyWhereTheyArePatterns) {
  EXPECT_EQ(find("PIPE-21?", NodeMatch::kPattern), (Nodes{pipe0, pipe1}));
  EXPECT_EQ(find("/pipe-21*", NodeMatch::kPattern), (Nodes{pipe, branch, pipe0, pipe1}));
  EXPECT_EQ(find("W?rme*", NodeMatch::kPattern), (Nodes{boiler})) << "? is a character";
  EXPECT_EQ(find("SITE/*/Tank", NodeMatch::kPattern), (Nodes{tank, other_tank, lower_tank}));
  EXPECT_EQ(find("re:^/PIPE-2\\d+$", NodeMatch::kPattern), (Nodes{pipe, pipe0, pipe1}));
  EXPECT_EQ(find("Name=re:A1$", NodeMatch::kPattern), (Nodes{a1}));
  EXPECT_EQ(find("ZONE-.1", NodeMatch::kPattern), Nodes{});
  EXPECT_EQ(find("*", NodeMatch::kPattern).size(), scene.node_count() - 3) << "all that have a name";
  const NodeId star = add(site, "PIPE-2*");
  EXPECT_EQ(find("PIPE-2*", NodeMatch::kName), (Nodes{star})) << "a name with a star";
  const auto wrong = find_nodes(scene, scene.root(), std::vector<NodeCondition>{{"", "re:a("}});
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().message, "regular expression, after byte 2: a closing parenthesis is missing");
}

TEST_F(FindNodes, ThatFulfilAllConditions) {
  scene.set_attribute(flange, "Type", "FLAN");
  scene.set_attribute(tank, "Type", "FLAN");
  EXPECT_EQ(find_all({{"", "Type=FLAN"}, {"", "PIPE-21/B1"}}), (Nodes{flange})) << "words, though there is such a name";
  EXPECT_EQ(find_all({{"Type", ""}, {"", "tank"}}), (Nodes{tank}));
  EXPECT_EQ(find_all({{"Nothing", ""}}), Nodes{});
  EXPECT_EQ(find_all({}).size(), scene.node_count());
  EXPECT_EQ(find_all({{"Type", ""}}, pipe), (Nodes{flange})) << "below a node";
  EXPECT_EQ(find_all({{"", "SITE/ZONE-RACK/PIPE-21"}}, pipe), (Nodes{pipe})) << "paths begin at the root all the same";
}

TEST_F(FindNodes, SimilarNames) {
  scene.set_attribute(pipe, "Type", "VALVE");
  const auto similar = [&](const char* text) { return similar_names(scene, scene.root(), {"", text}, 2); };
  using Names = std::vector<std::string>;
  EXPECT_EQ(similar("PIPE-2"), (Names{"/PIPE-21", "/PIPE-210"}));
  EXPECT_EQ(similar("SITE/ZONE-B1"), (Names{"/ZONE-A1", "/ZONE-A10"}));
  EXPECT_EQ(similar("Type=VALF"), (Names{})) << "two letters of four differ";
  EXPECT_EQ(similar("Type=VALFE"), (Names{"VALVE"}));
  EXPECT_EQ(similar("something else"), (Names{}));
}

TEST(FindNodesLarge, ManyNodesWithoutANameTakeOneStepEach) {
  Scene scene;
  constexpr int kMany = 100'000;
  NodeId last;
  for (int i = 0; i < kMany; ++i) last = scene.add_node(scene.root(), "");
  const auto found = find_nodes(scene, scene.root(), std::vector<NodeCondition>{{"", "#" + std::to_string(kMany - 1)}});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->nodes, (Nodes{last}));
}

}  // namespace
}  // namespace sightline::core::find_nodes_test
