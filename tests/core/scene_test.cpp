// Nodes and items: what they are given, inherit and keep, and how many there may be.
#include "sightline/core/scene.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/snapshot.h"
#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/core/scene_samples.h"

namespace sightline::core::scene_test {
namespace {

using tests::children_of;
using tests::Ids;
using tests::items_of;
using tests::kPipe;
using tests::Random;
using tests::triangle;

TEST(Scene, StartsWithARootOnTheModelLayer) {
  Scene scene;
  EXPECT_TRUE(scene.contains(scene.root()));
  EXPECT_EQ(scene.node_count(), 1u);
  EXPECT_EQ(scene.item_count(), 0u);
  EXPECT_FALSE(scene.parent(scene.root()).valid());
  EXPECT_FALSE(scene.first_child(scene.root()).valid());
  EXPECT_EQ(scene.layers(scene.root()), kLayerModel);
  EXPECT_EQ(scene.path(scene.root()), "");
  EXPECT_TRUE(scene.commit()->empty());
}

TEST(Scene, HandlesOfRemovedNodesStayStale) {
  Scene scene;
  std::vector<NodeId> stale;
  for (int i = 0; i < 100; ++i) {
    const NodeId node = scene.add_node(scene.root(), "again");
    for (const NodeId& old : stale) {
      EXPECT_FALSE(scene.contains(old));
      EXPECT_NE(old, node);
    }
    EXPECT_TRUE(scene.contains(node));
    EXPECT_TRUE(scene.transform(node).linear == dmat3(1.0)) << "nothing is left of the node before";
    EXPECT_TRUE(scene.visible(node));
    EXPECT_TRUE(scene.attributes(node).empty());
    EXPECT_EQ(scene.layers(node), 0u);
    EXPECT_EQ(scene.first_item(node), kNoItem);
    scene.set_transform(node, {dmat3(2.0), dvec3(1.0)});
    scene.set_visible(node, false);
    scene.set_layers(node, 4);
    scene.set_attribute(node, "k", "v");
    scene.add_primitive(node, kPipe);
    scene.remove_node(node);
    stale.push_back(node);
  }
  EXPECT_FALSE(scene.contains(NodeId{}));
  EXPECT_FALSE(scene.contains(MeshId{}));
  EXPECT_FALSE(scene.contains(MaterialId{}));
  EXPECT_EQ(scene.node_count(), 1u);
  EXPECT_EQ(scene.item_count(), 0u);
}

TEST(Scene, ItemsKeepWhatTheyWereGiven) {
  Scene scene;
  Random random(1);
  const MaterialId red = scene.add_material({"red", {1, 0, 0}, 0.5f, 7});
  Mesh facets = triangle();
  facets.contour_sizes = {3};
  facets.polygon_contours = {1};
  const MeshId mesh = scene.add_mesh(triangle()).value(), facet_group = scene.add_mesh(facets).value();
  EXPECT_EQ(scene.material(red).code, 7u);
  EXPECT_EQ(scene.mesh(mesh).positions.size(), 3u);
  EXPECT_EQ(scene.mesh_bounds(mesh).max, dvec3(1, 1, 0));
  EXPECT_EQ(scene.mesh_at(1), facet_group);
  EXPECT_EQ(scene.material_at(0), red);
  const NodeId node = scene.add_node(scene.root());
  for (int k = 0; k < kPrimitiveKindCount; ++k) {
    const Primitive p = tests::random_primitive(static_cast<Kind>(k), random);
    const Affine place = tests::random_affine(random, 1.0, 1e7);
    const ItemId item = scene.add_primitive(node, p, place, red);
    EXPECT_EQ(item, ItemId(k));
    EXPECT_EQ(scene.kind(item), static_cast<Kind>(k));
    const Primitive back = scene.primitive(item);
    EXPECT_TRUE(std::ranges::equal(parameters(back), parameters(p)));
    EXPECT_EQ(scene.placement(item).origin, place.origin) << "the origin in double";
    EXPECT_EQ(scene.placement(item).linear, dmat3(mat3(place.linear))) << "the linear part in float";
    EXPECT_EQ(scene.node_of(item), node);
    EXPECT_EQ(scene.item_material(item), red);
  }
  const ItemId a = scene.add_mesh_instance(node, mesh), b = scene.add_mesh_instance(node, facet_group);
  EXPECT_EQ(scene.kind(a), Kind::kMesh);
  EXPECT_EQ(scene.kind(b), Kind::kFacetGroup);
  EXPECT_EQ(scene.mesh_of(b), facet_group);
  EXPECT_FALSE(scene.item_material(a).valid());
  EXPECT_EQ(scene.bounds_under(a, translation({5, 0, 0})).size().z, scene.bounds_under(a, {}).size().z);
  EXPECT_NEAR(scene.bounds_under(a, translation({5, 0, 0})).max.x, 6.0, 1e-12);
}

TEST(Scene, PathsNameNodesAndCountUnnamedOnes) {
  Scene scene;
  const NodeId plant = scene.add_node(scene.root(), "plant");
  scene.add_node(plant);
  const NodeId second = scene.add_node(plant);
  const NodeId pipe = scene.add_node(second, "pipe");
  EXPECT_EQ(scene.path(pipe), "plant/#1/pipe");
  EXPECT_EQ(scene.path(plant), "plant");
  scene.set_name(second, "zone");
  EXPECT_EQ(scene.path(pipe), "plant/zone/pipe");
  ASSERT_TRUE(scene.reparent(pipe, scene.root()));
  EXPECT_EQ(scene.path(pipe), "pipe");
}

TEST(Scene, PartsAreTheNearestNamedNodesBelowFiles) {
  Scene scene;
  const NodeId file = scene.add_node(scene.root(), "plant.rvm"), bare = scene.add_node(file);
  const NodeId pipe = scene.add_node(bare, "pipe"), flange = scene.add_node(pipe, "flange"),
               body = scene.add_node(flange);
  EXPECT_EQ(part_of(scene, body), flange);
  EXPECT_EQ(part_of(scene, flange), flange);
  EXPECT_EQ(part_of(scene, scene.parent(flange)), pipe) << "the assembly";
  EXPECT_EQ(part_of(scene, scene.parent(pipe)), NodeId()) << "a file is no part";
  EXPECT_EQ(part_of(scene, scene.root()), NodeId());
  EXPECT_EQ(part_of(scene, NodeId()), NodeId());
}

TEST(Scene, RenamingDoesNotLeak) {
  Scene scene;
  Random random(4);
  std::vector<NodeId> nodes;
  std::vector<std::string> names(200);
  for (std::size_t i = 0; i < names.size(); ++i) nodes.push_back(scene.add_node(scene.root()));
  const std::size_t before = scene.memory_bytes();
  for (int i = 0; i < 500'000; ++i) {
    const std::size_t n = random() % nodes.size();
    names[n].assign(random() % 40, char('a' + i % 26));
    scene.set_name(nodes[n], names[n]);
    if (i % 50'000 == 0) {
      for (std::size_t k = 0; k < nodes.size(); ++k) ASSERT_EQ(scene.name(nodes[k]), names[k]);
    }
  }
  for (std::size_t k = 0; k < nodes.size(); ++k) ASSERT_EQ(scene.name(nodes[k]), names[k]);
  EXPECT_LT(scene.memory_bytes(), before + 64 * 1024);
  // Names of removed nodes are given back too.
  for (int i = 0; i < 100'000; ++i) scene.remove_node(scene.add_node(scene.root(), "a name of some length, gone soon"));
  EXPECT_LT(scene.memory_bytes(), before + 64 * 1024);
  for (std::size_t k = 0; k < nodes.size(); ++k) ASSERT_EQ(scene.name(nodes[k]), names[k]);
}

TEST(Scene, ANameMayBeTakenFromAnotherNode) {
  Scene scene;
  const NodeId a = scene.add_node(scene.root(), "a rather long name that needs room"),
               b = scene.add_node(scene.root(), "b");
  for (int i = 0; i < 1000; ++i) {
    scene.set_name(b, scene.name(a));
    ASSERT_EQ(scene.name(b), "a rather long name that needs room");
    scene.set_name(b, "");
  }
  scene.set_name(a, scene.name(a).substr(2, 6));
  EXPECT_EQ(scene.name(a), "rather");
}

TEST(Scene, AttributesKeepTheirOrderAndLastValue) {
  Scene scene;
  const NodeId node = scene.add_node(scene.root());
  EXPECT_TRUE(scene.attributes(node).empty());
  scene.set_attribute(node, "b", "1");
  scene.set_attribute(node, "a", "2");
  scene.set_attribute(node, "b", "3");
  const Scene::Attributes expected{{"b", "3"}, {"a", "2"}};
  EXPECT_EQ(scene.attributes(node), expected);
  EXPECT_TRUE(scene.commit()->empty()) << "attributes and names touch no item";
}

TEST(Scene, LayersMaterialAndVisibilityComeFromTheNearestAbove) {
  Scene scene;
  const MaterialId red = scene.add_material({}), blue = scene.add_material({});
  const NodeId a = scene.add_node(scene.root()), b = scene.add_node(a), c = scene.add_node(b);
  const ItemId plain = scene.add_primitive(c, kPipe), painted = scene.add_primitive(c, kPipe, {}, blue);
  EXPECT_EQ(scene.state(plain).layers, kLayerModel);
  EXPECT_EQ(scene.state(plain).material, kNone);
  scene.set_material(a, red);
  scene.set_layers(a, kLayerInsulation);
  EXPECT_EQ(scene.state(plain).layers, kLayerInsulation);
  EXPECT_EQ(scene.state(plain).material, red.index);
  EXPECT_EQ(scene.state(painted).material, blue.index);
  scene.set_layers(b, kLayerObstruction | kLayerModel);
  scene.set_material(c, blue);
  EXPECT_EQ(scene.state(plain).layers, kLayerObstruction | kLayerModel);
  EXPECT_EQ(scene.state(plain).material, blue.index);
  EXPECT_EQ(scene.layers(c), 0u) << "as set";
  scene.set_material(c, {});
  scene.set_layers(b, 0);
  EXPECT_EQ(scene.state(plain).layers, kLayerInsulation);
  EXPECT_EQ(scene.state(plain).material, red.index);
  scene.set_visible(a, false);
  EXPECT_EQ(scene.state(plain).layers, 0u);
  EXPECT_TRUE(scene.visible(c)) << "as set";
  scene.set_visible(a, true);
  scene.set_visible(plain, false);
  EXPECT_EQ(scene.state(plain).layers, 0u);
  EXPECT_EQ(scene.state(painted).layers, kLayerInsulation);
}

TEST(Scene, BoundsAreOfWhatASubtreeShows) {
  Scene scene;
  const NodeId top = scene.add_node(scene.root(), "top", translation({1e6, 0, 0}));
  const NodeId a = scene.add_node(top, "a"), b = scene.add_node(top, "b", translation({0, 10, 0}));
  const NodeId volumes = scene.add_node(top, "volumes"), nothing = scene.add_node(top, "nothing");
  scene.set_layers(volumes, kLayerObstruction);
  const Box cube{2, 2, 2};
  const ItemId first = scene.add_primitive(a, cube), second = scene.add_primitive(a, cube, translation({5, 0, 0}));
  scene.add_primitive(b, cube);
  scene.add_primitive(volumes, cube, translation({0, 0, 100}));
  const auto expect_bounds = [&](const AabbD& box, const dvec3& low, const dvec3& high) {
    EXPECT_LE(glm::length(box.min - low), 1e-8);
    EXPECT_LE(glm::length(box.max - high), 1e-8);
  };
  expect_bounds(scene.bounds(a), {1e6 - 1, -1, -1}, {1e6 + 6, 1, 1});
  expect_bounds(scene.bounds(b), {1e6 - 1, 9, -1}, {1e6 + 1, 11, 1});
  expect_bounds(scene.bounds(scene.root()), {1e6 - 1, -1, -1}, {1e6 + 6, 11, 1});
  EXPECT_TRUE(scene.bounds(volumes).empty());
  expect_bounds(scene.bounds(volumes, kLayerObstruction), {1e6 - 1, -1, 99}, {1e6 + 1, 1, 101});
  expect_bounds(scene.bounds(top, ~0u), {1e6 - 1, -1, -1}, {1e6 + 6, 11, 101});
  EXPECT_TRUE(scene.bounds(nothing).empty());
  EXPECT_TRUE(Scene().bounds(Scene().root()).empty());

  // A snapshot's are rounded outwards and no more.
  ASSERT_TRUE(scene.commit());
  const AabbD exact = scene.bounds(scene.root()), rounded = Snapshot(scene).bounds().world_bounds();
  EXPECT_TRUE(glm::all(glm::lessThanEqual(rounded.min, exact.min)));
  EXPECT_TRUE(glm::all(glm::greaterThanEqual(rounded.max, exact.max)));
  EXPECT_LE(glm::length(rounded.size() - exact.size()), 1e-4);

  scene.set_visible(second, false);
  expect_bounds(scene.bounds(a), {1e6 - 1, -1, -1}, {1e6 + 1, 1, 1});
  scene.remove_item(first);
  EXPECT_TRUE(scene.bounds(a).empty());
  scene.set_visible(top, false);
  EXPECT_TRUE(scene.bounds(scene.root()).empty());
  EXPECT_TRUE(scene.bounds(b).empty()) << "hidden from above";
}

TEST(Scene, RemovingItemsInAnyOrderKeepsTheList) {
  Scene scene;
  const NodeId node = scene.add_node(scene.root());
  Random random(2);
  Ids twin;
  for (int step = 0; step < 5000; ++step) {
    if (twin.empty() || random() % 5 < 2) {
      twin.push_back(scene.add_primitive(node, kPipe));
    } else {
      const std::size_t at = step % 3 == 0 ? 0 : step % 3 == 1 ? twin.size() - 1 : random() % twin.size();
      scene.remove_item(twin[at]);
      EXPECT_FALSE(scene.contains_item(twin[at]));
      twin.erase(twin.begin() + std::ptrdiff_t(at));
    }
    if (step % 16 == 0) {
      ASSERT_EQ(items_of(scene, node), twin);
    }
  }
}

TEST(Scene, ANodeThatCannotHangBelowItselfStaysWhereItIs) {
  Scene scene;
  const NodeId a = scene.add_node(scene.root(), "a"), b = scene.add_node(a, "b"), c = scene.add_node(b, "c"),
               d = scene.add_node(scene.root(), "d");
  scene.add_primitive(c, kPipe);
  ASSERT_TRUE(scene.commit());
  for (const NodeId parent : {a, b, c}) {
    const auto done = scene.reparent(a, parent);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().message,
              "node \"a\": expected a parent outside its subtree, found \"" + scene.path(parent) + "\"");
    EXPECT_EQ(children_of(scene, scene.root()), (std::vector{a, d}));
    EXPECT_EQ(children_of(scene, a), std::vector{b});
    EXPECT_EQ(children_of(scene, c), std::vector<NodeId>{});
    EXPECT_TRUE(scene.commit()->empty());
  }
  EXPECT_TRUE(scene.reparent(c, a)) << "up is no circle";
  EXPECT_TRUE(scene.reparent(a, d));
  EXPECT_EQ(scene.path(c), "d/a/c");
}

/// Places that removed nodes have left in either scene are given to new nodes, once each.
TEST(Scene, JoinedScenesReuseTheirPlaces) {
  Scene scene;
  const NodeId top = scene.add_node(scene.root(), "top");
  scene.remove_node(scene.add_node(top));
  Scene other;
  const NodeId first = other.add_node(other.root(), "first");
  std::vector<NodeId> gone;
  for (int i = 0; i < 10; ++i) gone.push_back(other.add_node(first, "gone"));
  const NodeId last = other.add_node(first, "last");
  other.add_primitive(last, kPipe);
  for (const NodeId node : gone) other.remove_node(node);
  const std::vector<NodeId> added = scene.append(top, std::move(other));
  ASSERT_EQ(added.size(), 1u);
  const std::size_t nodes = scene.node_count();
  std::uint32_t places = 0;
  scene.for_each_node(scene.root(), [&](NodeId node, const Affine&, bool, std::uint32_t, MaterialId) {
    places = std::max(places, node.index + 1);
  });
  std::vector<NodeId> fresh;
  for (int i = 0; i < 11; ++i) fresh.push_back(scene.add_node(top, "fresh"));
  EXPECT_EQ(scene.node_count(), nodes + 11);
  for (const NodeId node : fresh) EXPECT_LT(node.index, places) << "no new place";
  const NodeId beyond = scene.add_node(top);
  EXPECT_EQ(beyond.index, places);
  std::vector<NodeId> below = added;
  below.insert(below.end(), fresh.begin(), fresh.end());
  below.push_back(beyond);
  EXPECT_EQ(children_of(scene, top), below);
  ASSERT_EQ(children_of(scene, added[0]).size(), 1u);
  EXPECT_EQ(scene.path(scene.node_of(ItemId{0})), "top/first/last");
}

TEST(Scene, NestsAHundredThousandDeep) {
  constexpr int kDeep = 100'000;
  Scene scene;
  NodeId node = scene.root(), top;
  for (int i = 0; i < kDeep; ++i) {
    node = scene.add_node(node, i % 1000 == 0 ? "level" : "", translation({1, 0, 0}));
    if (i == 0) top = node;
    scene.add_primitive(node, kPipe);
  }
  ASSERT_EQ(scene.commit()->inserted.size(), std::size_t(kDeep));
  EXPECT_EQ(scene.world_from_node(node).origin.x, double(kDeep));
  EXPECT_EQ(scene.state(ItemId{kDeep - 1}).world_from_item.origin.x, double(kDeep));
  std::size_t visited = 0;
  scene.for_each_node(scene.root(), [&](NodeId, const Affine& world, bool, std::uint32_t, MaterialId) {
    ASSERT_EQ(world.origin.x, double(visited++));
  });
  EXPECT_EQ(visited, std::size_t(kDeep) + 1);
  EXPECT_FALSE(scene.path(node).empty());
  scene.set_layers(top, 2);
  EXPECT_EQ(scene.commit()->changed.size(), std::size_t(kDeep));
  // A fan at the very bottom, every leaf of it touched: nobody may walk up from each.
  std::vector<NodeId> fan;
  for (int i = 0; i < kDeep; ++i) {
    fan.push_back(scene.add_node(node));
    scene.add_primitive(fan.back(), kPipe);
  }
  ASSERT_EQ(scene.commit()->inserted.size(), std::size_t(kDeep));
  for (const NodeId& leaf : fan) scene.set_visible(leaf, false);
  EXPECT_EQ(scene.commit()->changed.size(), std::size_t(kDeep));
  scene.remove_node(top);
  EXPECT_EQ(scene.node_count(), 1u);
  EXPECT_EQ(scene.commit()->removed.size(), 2 * std::size_t(kDeep));
}

TEST(Scene, HoldsAHundredThousandChildrenAndItemsOnOneNode) {
  constexpr int kWide = 100'000;
  Scene scene;
  const NodeId wide = scene.add_node(scene.root(), "wide");
  std::vector<NodeId> children;
  Ids items;
  for (int i = 0; i < kWide; ++i) {
    children.push_back(scene.add_node(wide));
    items.push_back(scene.add_primitive(wide, kPipe));
    scene.add_primitive(children.back(), kPipe);
  }
  ASSERT_EQ(scene.commit()->inserted.size(), 2 * std::size_t(kWide));
  ASSERT_EQ(items_of(scene, wide), items);
  ASSERT_EQ(children_of(scene, wide), children);
  // Last first: the order in which a singly linked list would be walked to its end each time.
  for (int i = kWide - 1; i >= 0; --i) scene.remove_item(items[std::size_t(i)]);
  for (int i = kWide - 1; i >= 0; --i) scene.remove_node(children[std::size_t(i)]);
  EXPECT_FALSE(scene.first_child(wide).valid());
  EXPECT_EQ(scene.first_item(wide), kNoItem);
  EXPECT_EQ(scene.item_count(), 0u);
  EXPECT_EQ(scene.commit()->removed.size(), 2 * std::size_t(kWide));
}

}  // namespace
}  // namespace sightline::core::scene_test
