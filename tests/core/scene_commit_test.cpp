// What commit() refuses, and what it publishes to whom.
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/internal/access.h"
#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/core/scene_samples.h"

namespace sightline::core::scene_commit_test {
namespace {

using tests::Ids;
using tests::kPipe;
using tests::Random;
using tests::triangle;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

void expect_refused(Scene& scene, const std::string& node) {
  const auto delta = scene.commit();
  ASSERT_FALSE(delta);
  EXPECT_NE(delta.error().message.find("node \"" + node + "\""), std::string::npos) << delta.error().message;
  EXPECT_EQ(delta.error().message.find('\n'), std::string::npos);
}

TEST(SceneCommit, RefusesWhatIsNotFiniteOrTooFarAway) {
  for (const double bad : {kNan, kInf, -kInf, 1.1e37, -1e38, 1e60, 1e300})
    for (int entry = 0; entry < 12; ++entry) {
      SCOPED_TRACE(testing::Message() << bad << " at " << entry);
      Affine place;
      (entry < 9 ? place.linear[entry / 3] : place.origin)[entry % 3] = bad;
      for (const bool on_item : {true, false}) {
        Scene scene;
        const NodeId plant = scene.add_node(scene.root(), "plant");
        const NodeId node = scene.add_node(plant, "pump", on_item ? Affine{} : place);
        const ItemId good = scene.add_primitive(plant, kPipe);
        const ItemId item = scene.add_primitive(node, kPipe, on_item ? place : Affine{});
        expect_refused(scene, "plant/pump");
        on_item ? scene.set_placement(item, {}) : scene.set_transform(node, {});
        const auto delta = scene.commit();
        ASSERT_TRUE(delta);
        EXPECT_EQ(delta->inserted, (Ids{good, item}));
      }
    }
}

TEST(SceneCommit, RefusesBadPlacementsOfThingsWithoutExtent) {
  // Their boxes say nothing, but the placement would go into a snapshot and its chunks all the same.
  Mesh nothing;
  for (const double bad : {kNan, kInf, 1e60}) {
    Scene scene;
    const NodeId node = scene.add_node(scene.root(), "ghost");
    const ItemId item = scene.add_mesh_instance(node, scene.add_mesh(nothing).value(), translation({bad, 0, 0}));
    expect_refused(scene, "ghost");
    scene.set_placement(item, {dmat3(bad), dvec3(0.0)});
    expect_refused(scene, "ghost");
    scene.remove_item(item);
    EXPECT_TRUE(scene.commit()->empty());
    scene.add_primitive(node, Sphere{0.0f}, {dmat3(bad), dvec3(0.0)});
    expect_refused(scene, "ghost");
  }
}

TEST(SceneCommit, RefusesBadParameters) {
  Random random(3);
  for (int k = 0; k < kPrimitiveKindCount; ++k)
    for (int v = 0; v < parameter_count(static_cast<Kind>(k)); ++v)
      for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        const Primitive p = tests::random_primitive(static_cast<Kind>(k), random);
        std::vector<float> values(parameters(p).begin(), parameters(p).end());
        values[std::size_t(v)] = bad;
        Scene scene;
        scene.add_primitive(scene.add_node(scene.root(), "part"), make_primitive(static_cast<Kind>(k), values));
        expect_refused(scene, "part");
      }
}

/// The scene and its other meshes go on.
TEST(SceneCommit, AMeshWithAVertexThatIsNoNumberIsNotAdded) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()})
    for (int axis = 0; axis < 3; ++axis) {
      Scene scene;
      Mesh mesh = triangle();
      mesh.name = "plate";
      const MeshId good = scene.add_mesh(mesh).value();
      mesh.positions[1][axis] = bad;
      const auto refused = scene.add_mesh(mesh);
      ASSERT_FALSE(refused);
      EXPECT_EQ(refused.error().message,
                "mesh \"plate\": expected finite positions, found one that is not at vertex 1");
      EXPECT_EQ(scene.mesh_slots(), 1u);
      scene.add_mesh_instance(scene.root(), good);
      EXPECT_EQ(scene.commit()->inserted.size(), 1u);
    }
}

TEST(SceneCommit, AFailedCommitKeepsEarlierEditsAndRemovals) {
  Scene scene;
  const NodeId node = scene.add_node(scene.root(), "a");
  const ItemId first = scene.add_primitive(node, kPipe), second = scene.add_primitive(node, kPipe),
               third = scene.add_primitive(node, kPipe);
  ASSERT_TRUE(scene.commit());
  scene.remove_item(first);
  scene.set_visible(third, false);
  const ItemId fourth = scene.add_primitive(node, kPipe, translation({kNan, 0, 0}));
  expect_refused(scene, "a");
  expect_refused(scene, "a");
  scene.remove_item(fourth);
  const auto delta = scene.commit();
  ASSERT_TRUE(delta);
  EXPECT_EQ(delta->removed, Ids{first});
  EXPECT_EQ(delta->changed, Ids{third});
  EXPECT_TRUE(delta->inserted.empty()) << "never published";
  EXPECT_TRUE(scene.contains_item(second));
  EXPECT_TRUE(scene.commit()->empty());
}

TEST(SceneCommit, ReusedPlacesDoNotInheritPendingTouches) {
  Scene scene;
  const NodeId old = scene.add_node(scene.root());
  scene.set_visible(old, false);
  scene.remove_node(old);
  const NodeId fresh = scene.add_node(scene.root());
  ASSERT_EQ(fresh.index, old.index) << "the place was to be reused";
  const ItemId item = scene.add_primitive(fresh, kPipe);
  EXPECT_EQ(scene.commit()->inserted, Ids{item});
  EXPECT_EQ(scene.state(item).layers, kLayerModel);
  scene.set_visible(fresh, false);
  EXPECT_EQ(scene.commit()->changed, Ids{item});
}

TEST(SceneCommit, EditedMaterialsArePublishedOnce) {
  Scene scene;
  const MaterialId red = scene.add_material({.name = "red"}), blue = scene.add_material({.name = "blue"});
  const ItemId item = scene.add_primitive(scene.root(), kPipe, translation({kNan, 0, 0}), red);
  EXPECT_FALSE(scene.commit());
  scene.set_placement(item, {});
  EXPECT_EQ(scene.commit()->materials, (std::vector{red.index, blue.index})) << "those that waited, too";
  EXPECT_TRUE(scene.commit()->empty());
  scene.update_material(blue, {.name = "light blue", .alpha = 0.5f});
  scene.update_material(red, {.name = "dark red"});
  scene.update_material(blue, {.name = "pale blue", .alpha = 0.5f});
  EXPECT_EQ(scene.material(blue).name, "pale blue");
  const auto delta = scene.commit();
  EXPECT_EQ(delta->materials, (std::vector{red.index, blue.index}));
  EXPECT_TRUE(delta->changed.empty()) << "items name what they named before";
  EXPECT_TRUE(scene.commit()->empty());
  const Scene::Mark mark = scene.mark();
  scene.add_material({});
  scene.take_back(mark, {});
  EXPECT_TRUE(scene.commit()->empty());
}

/// Items that were pending before the mark stay so; ids that are given out again are published once.
TEST(SceneCommit, WhatIsTakenBackIsNotPublished) {
  Scene scene;
  const ItemId pending = scene.add_primitive(scene.root(), kPipe);
  const Scene::Mark mark = scene.mark();
  const NodeId tried = scene.add_node(scene.root());
  for (int i = 0; i < 3; ++i) scene.add_primitive(tried, kPipe);
  scene.take_back(mark, std::vector{tried});
  const ItemId again = scene.add_primitive(scene.root(), kPipe);
  EXPECT_EQ(to_index(again), to_index(pending) + 1);
  EXPECT_EQ(scene.commit()->inserted, (Ids{pending, again}));
  EXPECT_TRUE(scene.commit()->empty());
}

TEST(SceneCommit, EachSubscriptionGetsWhatWasPublishedSinceItAsked) {
  std::optional<Scene> scene(std::in_place);
  SceneSubscription early = scene->subscribe(), nobody;
  const ItemId first = scene->add_primitive(scene->root(), kPipe);
  EXPECT_TRUE(early.take().empty()) << "not published yet";
  ASSERT_TRUE(scene->commit());
  SceneSubscription late = scene->subscribe();
  const ItemId second = scene->add_primitive(scene->root(), kPipe), third = scene->add_primitive(scene->root(), kPipe);
  scene->set_visible(first, false);
  ASSERT_TRUE(scene->commit());
  scene->set_visible(second, false);
  scene->remove_item(third);
  ASSERT_TRUE(scene->commit());
  const SceneDelta all = early.take();
  EXPECT_EQ(all.inserted, (Ids{first, second}));
  EXPECT_TRUE(all.changed.empty() && all.removed.empty()) << "the third never was, the others are new";
  EXPECT_TRUE(early.take().empty());
  SceneSubscription moved = std::move(late);
  scene->remove_item(first);
  ASSERT_TRUE(scene->commit());
  const SceneDelta rest = moved.take();
  EXPECT_EQ(rest.inserted, Ids{second});
  EXPECT_TRUE(rest.changed.empty());
  EXPECT_EQ(rest.removed, Ids{first});
  EXPECT_EQ(early.take().removed, Ids{first});
  EXPECT_TRUE(nobody.take().empty());
  // A copy is another scene.
  Scene copy = *scene;
  copy.remove_item(second);
  ASSERT_TRUE(copy.commit());
  EXPECT_TRUE(early.take().empty());
  scene->remove_item(second);
  ASSERT_TRUE(scene->commit());
  scene.reset();
  EXPECT_EQ(early.take().removed, Ids{second}) << "published while there was a scene";
}

/// Random edits of a tree, among them nodes that are moved above and below each other.
void edit(Scene& scene, std::vector<NodeId>& nodes, Random& random) {
  for (int i = 0; i < 60; ++i) {
    const NodeId node = nodes[random() % nodes.size()];
    const auto item = ItemId(random() % (scene.item_slots() + 1));
    const bool known = scene.contains_item(item);
    switch (random() % 7) {
      case 0:
        nodes.push_back(scene.add_node(node, "node"));
        break;
      case 1:
        scene.set_transform(node, translation({double(i), 0, 0}));
        break;
      case 2:
        if (known) scene.remove_item(item);
        break;
      case 3:
        if (known) scene.set_visible(item, i % 2 == 0);
        break;
      case 4:
        scene.add_material({"", {0.1f, 0.2f, 0.3f}});
        break;
      default:
        scene.add_primitive(node, kPipe, translation({0, double(i), 0}));
    }
  }
}

TEST(SceneCommit, InPiecesPublishesWhatOneCommitDoes) {
  constexpr std::size_t kPiece = 7;
  Scene scene;
  Random random(3);
  std::vector<NodeId> nodes{scene.root()};
  std::size_t pieces = 0;
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(testing::Message() << "seed 3, round " << round);
    edit(scene, nodes, random);
    Scene twin = scene;
    const auto wanted = twin.commit();
    ASSERT_TRUE(wanted);
    SceneSubscription subscription = scene.subscribe();
    SceneDelta published;
    while (Access::has_edits(scene)) {
      const auto piece = Access::publish(scene, kPiece);
      ASSERT_TRUE(piece);
      ASSERT_LE(piece->size() - piece->materials.size(), kPiece);
      published.append(*piece);
      ++pieces;
    }
    ASSERT_EQ(published.inserted, wanted->inserted);
    ASSERT_EQ(published.changed, wanted->changed);
    ASSERT_EQ(published.removed, wanted->removed);
    ASSERT_EQ(published.materials, wanted->materials);
    const SceneDelta taken = subscription.take();
    ASSERT_EQ(taken.inserted, wanted->inserted);
    ASSERT_EQ(taken.changed, wanted->changed);
    ASSERT_EQ(taken.removed, wanted->removed);
  }
  EXPECT_GT(pieces, 1000u);
}

TEST(SceneCommit, InPiecesLosesNothingWhereOneIsRefused) {
  Scene scene;
  Ids items;
  for (int i = 0; i < 20; ++i) items.push_back(scene.add_primitive(scene.root(), kPipe));
  scene.set_placement(items[9], translation({kNan, 0, 0}));
  std::size_t published = 0;
  for (;;) {
    const auto piece = Access::publish(scene, 3);
    if (!piece) break;
    published += piece->inserted.size();
    ASSERT_LT(published, 20u);
  }
  EXPECT_FALSE(Access::publish(scene, 3));
  scene.set_placement(items[9], {});
  while (Access::has_edits(scene)) published += Access::publish(scene, 3)->inserted.size();
  EXPECT_EQ(published, 20u);
}

}  // namespace
}  // namespace sightline::core::scene_commit_test
