// What a checked build says before it aborts. Compiled with its own scene.cpp, so that release builds test it, too.
#include <gtest/gtest.h>

#include "sightline/core/scene.h"

namespace sightline::core::contract_test {
namespace {

#if GTEST_HAS_DEATH_TEST

class ContractDeathTest : public testing::Test {
 protected:
  void SetUp() override { testing::FLAGS_gtest_death_test_style = "threadsafe"; }
  Scene scene;
};

TEST_F(ContractDeathTest, StaleNodes) {
  const NodeId node = scene.add_node(scene.root()), child = scene.add_node(node);
  EXPECT_DEATH(scene.remove_node(scene.root()), "sightline: remove_node: expected a node other than the root");
  EXPECT_DEATH((void)scene.reparent(scene.root(), node), "sightline: reparent: expected a node other than the root");
  scene.remove_node(node);
  const NodeId again = scene.add_node(scene.root());
  ASSERT_EQ(again.index, child.index);
  const char* expected = "sightline: live: expected a node handle that is neither stale nor invalid";
  EXPECT_DEATH((void)scene.name(node), expected);
  EXPECT_DEATH((void)scene.name(NodeId{}), expected);
  EXPECT_DEATH(scene.set_visible(child, false), expected);
  EXPECT_DEATH(scene.add_primitive(node, Sphere{1.0f}), expected);
  EXPECT_DEATH(scene.add_node(node), expected);
  EXPECT_DEATH((void)scene.reparent(again, child), expected);
}

TEST_F(ContractDeathTest, RemovedItems) {
  const ItemId item = scene.add_primitive(scene.root(), Sphere{1.0f});
  EXPECT_DEATH((void)scene.mesh_of(item), "expected an item with a mesh");
  scene.remove_item(item);
  const char* expected = "sightline: live: expected an item that is neither removed nor unknown";
  EXPECT_DEATH(scene.remove_item(item), expected);
  EXPECT_DEATH((void)scene.primitive(item), expected);
  EXPECT_DEATH(scene.set_placement(ItemId{to_index(item) + 1}, {}), expected);
}

TEST_F(ContractDeathTest, StaleMeshes) {
  const MeshId gone = scene.add_mesh({}).value(), used = scene.add_mesh({}).value();
  scene.add_mesh_instance(scene.root(), used);
  EXPECT_DEATH(scene.remove_mesh(used), "sightline: remove_mesh: expected a mesh that no item uses");
  scene.remove_mesh(gone);
  for (const MeshId mesh : {gone, MeshId{}, MeshId{used.index, used.generation + 1}}) {
    EXPECT_DEATH((void)scene.mesh(mesh), "sightline: mesh: expected a mesh handle that is neither stale nor invalid");
    EXPECT_DEATH((void)scene.mesh_bounds(mesh), "mesh_bounds: expected a mesh handle");
    EXPECT_DEATH(scene.add_mesh_instance(scene.root(), mesh), "expected a mesh handle");
  }
}

TEST_F(ContractDeathTest, StaleMaterials) {
  const MaterialId gone = scene.add_material({});
  const ItemId item = scene.add_primitive(scene.root(), Sphere{1.0f});
  scene.remove_material(gone);
  EXPECT_DEATH((void)scene.material(gone), "material: expected a material handle that is neither stale nor invalid");
  EXPECT_DEATH((void)scene.material(MaterialId{}), "expected a material handle that is neither stale nor invalid");
  const char* expected = "sightline: index_of: expected a material handle that is not stale";
  EXPECT_DEATH(scene.set_material(item, gone), expected);
  EXPECT_DEATH(scene.set_material(scene.root(), gone), expected);
  EXPECT_DEATH(scene.add_primitive(scene.root(), Sphere{1.0f}, {}, gone), expected);
  EXPECT_DEATH(scene.update_material(gone, {}), "expected a material handle");
  EXPECT_DEATH(scene.remove_material(MaterialId{}), "expected a material handle");
}

#endif

}  // namespace
}  // namespace sightline::core::contract_test
