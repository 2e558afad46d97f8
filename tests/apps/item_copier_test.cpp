// Copies of parts of scenes, against the scenes.
#include "sightline/apps/common/item_copier.h"

#include <map>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "sightline/apps/common/tree_walk.h"
#include "sightline/importers/import.h"

namespace sightline::apps::item_copier_test {
namespace {

using core::ItemId;
using core::NodeId;
using core::Scene;
using Random = std::mt19937_64;

core::Mesh triangle(float size) {
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}};
  mesh.indices = {0, 1, 2};
  return mesh;
}

/// Two files with groups of unlike names, attributes, transforms, materials and layers.
Scene random_scene(Random& random) {
  Scene scene;
  scene.set_transform(scene.root(), core::translation({5.0, 0.0, 0.0}));
  std::vector<NodeId> nodes{scene.add_node(scene.root(), "a"), scene.add_node(scene.root(), "b")};
  std::vector<core::MaterialId> materials{{}};
  for (int i = 0; i < 4; ++i)
    materials.push_back(scene.add_material({"m" + std::to_string(i), {0.2f * float(i), 0, 1}}));
  const core::MeshId mesh = scene.add_mesh(triangle(1.0f)).value(), other = scene.add_mesh(triangle(2.0f)).value();
  const auto any = [&](const auto& list) { return list[random() % list.size()]; };
  for (int i = 0; i < 60; ++i) {
    const double at = double(random() % 100);
    nodes.push_back(
        scene.add_node(any(nodes), random() % 3 ? "n" + std::to_string(i) : "", core::translation({at, 1.0, 0.0})));
    const NodeId node = nodes.back();
    scene.set_material(node, any(materials));
    scene.set_visible(node, random() % 8 != 0);
    if (random() % 4 == 0) scene.set_layers(node, 1u << random() % 3);
    for (auto n = random() % 3; n > 0; --n) scene.set_attribute(node, "k" + std::to_string(n), std::to_string(i));
    for (auto n = random() % 4; n > 0; --n) {
      const core::Affine place = core::translation({0.0, double(random() % 9), 0.0});
      const ItemId item = random() % 2
                              ? scene.add_primitive(node, core::Sphere{1.0f + float(i)}, place, any(materials))
                              : scene.add_mesh_instance(node, random() % 2 ? mesh : other, place, any(materials));
      scene.set_visible(item, random() % 8 != 0);
    }
  }
  return scene;
}

/// All that there is to know of an item, of its shape and of the nodes above it.
std::string facts(const Scene& scene, ItemId item) {
  const auto state = scene.state(item);
  std::string text = std::string(core::name_of(scene.kind(item))) + " layers " + std::to_string(state.layers);
  if (const core::MaterialId material = scene.material_at(state.material); material.valid())
    text += " " + scene.material(material).name + " " + std::to_string(scene.material(material).colour.r);
  const core::AabbD bounds = scene.bounds_under(item, state.world_from_item);
  for (int axis = 0; axis < 3; ++axis)
    text += " " + std::to_string(bounds.min[axis]) + " " + std::to_string(bounds.max[axis]);
  for (NodeId node = scene.node_of(item); node.valid(); node = scene.parent(node)) {
    text.append(" / ").append(scene.name(node));
    for (const auto& [key, value] : scene.attributes(node)) text += " " + key + "=" + value;
  }
  return text;
}

/// In tree order.
std::vector<ItemId> items_in_order(const Scene& scene) {
  std::vector<ItemId> items;
  walk(
      scene,
      [&](NodeId node) {
        for (ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item))
          items.push_back(item);
      },
      [](NodeId) {});
  return items;
}

TEST(ItemCopier, CopiesWhatIsWantedAndNothingElse) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random{seed};
    const Scene scene = random_scene(random);
    const std::vector<NodeId> tops = children_of(scene, scene.root());
    std::vector<bool> wanted(scene.item_slots());
    for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = random() % 3 == 0;
    wanted[0] = true;
    std::vector<std::string> expected, found;
    for (const ItemId item : items_in_order(scene))
      if (wanted[to_index(item)]) expected.push_back(facts(scene, item));
    const auto part = copy_of_part(scene, tops, &wanted, {});
    ASSERT_TRUE(part);
    for (const ItemId item : items_in_order(*part)) found.push_back(facts(*part, item));
    EXPECT_EQ(found, expected);
    walk(
        *part,
        [&](NodeId node) {
          EXPECT_TRUE(node == part->root() || !items_below(*part, node).empty()) << "a group of nothing";
        },
        [](NodeId) {});
    EXPECT_LE(part->mesh_slots(), scene.mesh_slots()) << "each mesh once";
  }
}

TEST(ItemCopier, AllOfSomeFilesIsCopiedWithEmptyGroups) {
  Random random{3};
  const Scene scene = random_scene(random);
  const std::vector<NodeId> tops = children_of(scene, scene.root());
  const auto all = copy_of_part(scene, tops, nullptr, {}), first = copy_of_part(scene, {tops.data(), 1}, nullptr, {});
  ASSERT_TRUE(all && first);
  EXPECT_EQ(all->node_count(), scene.node_count());
  EXPECT_EQ(all->item_count(), scene.item_count());
  EXPECT_EQ(first->item_count(), items_below(scene, tops[0]).size());
  EXPECT_EQ(children_of(*first, first->root()).size(), 1u);
}

TEST(ItemCopier, NothingAndACancelledCopyFail) {
  Random random{3};
  Scene scene = random_scene(random);
  const std::vector<bool> none(scene.item_slots());
  const std::vector<NodeId> tops = children_of(scene, scene.root());
  const auto nothing = copy_of_part(scene, tops, &none, {});
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().message, "there are no items to write");
  for (int i = 0; i < 2000; ++i) scene.add_node(tops[1]);
  const auto cancelled = copy_of_part(scene, tops, nullptr, [](double) { return false; });
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().message, importers::kCancelled);
}

}  // namespace
}  // namespace sightline::apps::item_copier_test
