#include "sightline/core/find_nodes.h"

#include <gtest/gtest.h>

namespace sightline::core::find_nodes_test {
namespace {

TEST(FindNodes, ByNameAndAttribute) {
  Scene scene;
  const NodeId pipe = scene.add_node(scene.root(), "/PIPE-100"), valve = scene.add_node(pipe, "/Valve-7");
  const NodeId other = scene.add_node(scene.root(), "/OTHER");
  scene.set_attribute(pipe, "Type", "PIPE");
  scene.set_attribute(valve, "Type", "VALV");
  scene.set_attribute(valve, "Description", "gate valve of pipe-100");
  scene.set_attribute(other, "Type", "pipe rack");

  using Nodes = std::vector<NodeId>;
  const auto find = [&](std::vector<NodeCondition> conditions) { return find_nodes(scene, scene.root(), conditions); };
  EXPECT_EQ(find({{"", "pipe-100"}}), (Nodes{pipe, valve})) << "name of one, attribute of the other; any case";
  EXPECT_EQ(find({{"type", "PIPE"}}), (Nodes{pipe, other}));
  EXPECT_EQ(find({{"Type", ""}}), (Nodes{pipe, valve, other})) << "has the attribute";
  EXPECT_EQ(find({{"", "pipe"}, {"Type", "VALV"}}), (Nodes{valve})) << "both hold";
  EXPECT_EQ(find({{"Nothing", ""}}), Nodes{});
  EXPECT_EQ(find({{"", "VALVEX"}}), Nodes{});
  EXPECT_EQ(find({}).size(), scene.node_count());
  EXPECT_EQ(find_nodes(scene, pipe, std::vector<NodeCondition>{{"Type", ""}}), (Nodes{pipe, valve}));
}

}  // namespace
}  // namespace sightline::core::find_nodes_test
