// Ids that are given out again: Scene::reuse_ids().
#include <algorithm>
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/core/scene_samples.h"
#include "sightline/tests/support/effort.h"

namespace sightline::core::reused_ids_test {
namespace {

using tests::kPipe;
using tests::Random;
using tests::triangle;
using tests::uniform;

Mesh named_triangle(int name) {
  Mesh mesh = triangle();
  mesh.name = std::to_string(name);
  mesh.positions[1].x = float(1 + name % 7);
  return mesh;
}

/// A scene that things come to and go from, all different.
class Traffic {
 public:
  explicit Traffic(std::uint64_t seed) : random_(seed) { scene_.reuse_ids(true); }

  Scene& scene() { return scene_; }
  Random& random() { return random_; }
  /// Which item has an id, counted from the first that ever was.
  int owner(ItemId item) const { return owners_[to_index(item)]; }
  std::size_t most_items() const { return most_; }

  void edit() {
    const auto what = random_() % 12;
    if (what < 4) return add();
    if (what < 7 && !items_.empty()) return remove(random_() % items_.size());
    if (what < 8 && !nodes_.empty()) return remove_node();
    if (what < 9 && !materials_.empty()) return remove_material(random_() % materials_.size());
    if (what < 10) return remove_unused_mesh();
    if (!items_.empty()) scene_.set_placement(items_[random_() % items_.size()], somewhere());
  }

 private:
  struct Used {
    MeshId mesh;
    int items = 0;
  };
  Affine somewhere() {
    return translation({uniform(random_, -9, 9), uniform(random_, -9, 9), uniform(random_, -9, 9)});
  }
  void add() {
    if (nodes_.empty() || random_() % 8 == 0) nodes_.push_back(scene_.add_node(scene_.root()));
    const NodeId node = nodes_[random_() % nodes_.size()];
    if (materials_.empty() || random_() % 4 == 0) {
      materials_.push_back(scene_.add_material({.name = {}, .colour = vec3(float(serial_ % 97) / 97.0f)}));
      stale_.push_back(materials_.back());
    }
    const MaterialId material = random_() % 3 ? materials_[random_() % materials_.size()] : MaterialId();
    ItemId item;
    if (random_() % 2) {
      if (meshes_.empty() || random_() % 3 == 0) meshes_.push_back({scene_.add_mesh(named_triangle(serial_)).value()});
      Used& used = meshes_[random_() % meshes_.size()];
      ++used.items;
      item = scene_.add_mesh_instance(node, used.mesh, somewhere(), material);
    } else {
      const float size = 0.1f + float(serial_ % 50) / 10.0f;
      const std::array<Primitive, 3> shapes{Cylinder{size, 1.0f}, Sphere{size}, Box{size, 1.0f, 2.0f}};
      item = scene_.add_primitive(node, shapes[random_() % 3], somewhere(), material);
    }
    if (to_index(item) >= owners_.size()) owners_.resize(to_index(item) + 1);
    owners_[to_index(item)] = serial_++;
    ASSERT_EQ(std::count(items_.begin(), items_.end(), item), 0) << "in use";
    items_.push_back(item);
    most_ = std::max(most_, items_.size());
  }
  void release(ItemId item) {
    if (int(scene_.kind(item)) < kPrimitiveKindCount) return;
    const MeshId mesh = scene_.mesh_of(item);
    --std::find_if(meshes_.begin(), meshes_.end(), [&](const Used& used) { return used.mesh == mesh; })->items;
  }
  void remove(std::size_t place) {
    release(items_[place]);
    scene_.remove_item(items_[place]);
    items_.erase(items_.begin() + std::ptrdiff_t(place));
  }
  void remove_node() {
    const std::size_t place = random_() % nodes_.size();
    for (const ItemId item : tests::items_of(scene_, nodes_[place])) {
      release(item);
      std::erase(items_, item);
    }
    scene_.remove_node(nodes_[place]);
    nodes_.erase(nodes_.begin() + std::ptrdiff_t(place));
  }
  void remove_material(std::size_t place) {
    const MaterialId material = materials_[place];
    scene_.remove_material(material);
    materials_.erase(materials_.begin() + std::ptrdiff_t(place));
    for (const MaterialId any : stale_)
      ASSERT_EQ(scene_.contains(any), std::find(materials_.begin(), materials_.end(), any) != materials_.end());
  }
  void remove_unused_mesh() {
    const auto unused = std::find_if(meshes_.begin(), meshes_.end(), [](const Used& used) { return used.items == 0; });
    if (unused == meshes_.end()) return;
    scene_.remove_mesh(unused->mesh);
    stale_meshes_.push_back(unused->mesh);
    meshes_.erase(unused);
    for (const MeshId stale : stale_meshes_) ASSERT_FALSE(scene_.contains(stale));
  }

  Random random_;
  Scene scene_;
  std::vector<NodeId> nodes_;
  std::vector<ItemId> items_;
  std::vector<MaterialId> materials_, stale_;
  std::vector<Used> meshes_;
  std::vector<MeshId> stale_meshes_;
  std::vector<int> owners_;
  int serial_ = 0;
  std::size_t most_ = 0;
};

void expect_same_items(const Snapshot& followed, const Snapshot& fresh, ItemId end) {
  for (ItemId item{0}; item < end; ++item) {
    const Slot a = followed.slot(item), b = fresh.slot(item);
    ASSERT_EQ(a == kNone, b == kNone) << to_index(item);
    if (a == kNone) continue;
    ASSERT_EQ(followed.item(a), item);
    ASSERT_EQ(followed.kind(a), fresh.kind(b)) << to_index(item);
    ASSERT_EQ(followed.vacant(a), fresh.vacant(b)) << to_index(item);
    if (int(followed.kind(a)) < kPrimitiveKindCount) {
      const Primitive x = followed.primitive(a), y = fresh.primitive(b);
      ASSERT_TRUE(std::ranges::equal(parameters(x), parameters(y))) << to_index(item);
    } else {
      ASSERT_EQ(&followed.mesh(a), &fresh.mesh(b)) << to_index(item);
      ASSERT_FALSE(followed.mesh(a).name.empty());
    }
    const auto look = [](const Snapshot& of, Slot slot) {
      return of.material(slot) == kNone ? glm::vec4(-1.0f) : of.materials()[of.material(slot)];
    };
    ASSERT_EQ(look(followed, a), look(fresh, b)) << to_index(item);
    ASSERT_LT(glm::length(followed.world_from_item(a).origin - fresh.world_from_item(b).origin), 1e-5)
        << to_index(item);
  }
}

/// A snapshot that follows in time, now and then, or without a subscription and late.
struct Follower {
  Snapshot snapshot;
  SceneSubscription subscription;
  bool subscribes;
  unsigned pause;
  std::vector<SceneDelta> waiting;
  std::vector<int> owners;  // by item, as of what it knows
  SceneDelta half_read;     // taken and not applied yet

  void know(const SceneDelta& delta, const Traffic& traffic) {
    for (const ItemId item : delta.inserted) {
      if (to_index(item) >= owners.size()) owners.resize(to_index(item) + 1, -1);
      owners[to_index(item)] = traffic.owner(item);
    }
    for (const ItemId item : delta.removed)
      if (!std::binary_search(delta.inserted.begin(), delta.inserted.end(), item)) owners[to_index(item)] = -1;
  }
};

TEST(ReusedIds, SnapshotsThatFollowShowWhatTheSceneHas) {
  for (int seed = 0; seed < tests::repeated(200); ++seed) {
    SCOPED_TRACE(seed);
    Traffic traffic(std::uint64_t(seed) + 1);
    Scene& scene = traffic.scene();
    std::vector<Follower> followers;
    for (const unsigned pause : {1u, 2u, 9u})
      followers.push_back({Snapshot(scene), scene.subscribe(), true, pause, {}, {}, {}});
    followers.push_back({Snapshot(scene), {}, false, 5, {}, {}, {}});
    for (int commit = 0; commit < 150; ++commit) {
      for (auto edits = traffic.random()() % 12; edits-- > 0;) traffic.edit();
      if (testing::Test::HasFatalFailure()) return;
      const auto delta = scene.commit();
      ASSERT_TRUE(delta);
      for (Follower& f : followers) {
        if (!f.subscribes) f.waiting.push_back(*delta);
        // What a subscriber knows by an id is not another item's, even while it has read half of its edits.
        if (f.subscribes)
          for (ItemId item{0}; to_index(item) < f.owners.size(); ++item)
            if (f.owners[to_index(item)] >= 0 && scene.contains_item(item)) {
              ASSERT_EQ(f.owners[to_index(item)], traffic.owner(item)) << to_index(item);
            }
        if (traffic.random()() % f.pause != 0) continue;
        if (!f.subscribes) {
          for (const SceneDelta& old : f.waiting) f.snapshot.apply(old);
          f.waiting.clear();
        } else if (f.half_read.empty() && f.pause > 1) {
          f.half_read = f.subscription.take();  // applied at another time
          continue;
        } else {
          if (f.half_read.empty()) f.half_read = f.subscription.take();
          f.snapshot.apply(f.half_read);
          f.know(f.half_read, traffic);
          f.half_read = f.subscription.take();
          f.snapshot.apply(f.half_read);
          f.know(std::exchange(f.half_read, {}), traffic);
        }
        ASSERT_NO_FATAL_FAILURE(expect_same_items(f.snapshot, Snapshot(scene), ItemId(scene.item_slots())));
      }
    }
    EXPECT_LT(scene.item_slots(), 450u);  // some 600 are added
  }
}

/// Scenes that are read apart and joined, as tiles of a site are.
TEST(ReusedIds, WhatIsAppendedTakesFreePlaces) {
  Scene scene;
  scene.reuse_ids(true);
  Snapshot snapshot(scene);
  SceneSubscription subscription = scene.subscribe();
  Random random(7);
  struct Tile {
    NodeId node;
    std::vector<MeshId> meshes;
    std::vector<MaterialId> materials;
  };
  std::vector<Tile> tiles;
  std::vector<NodeId> stale;
  std::size_t settled = 0;
  for (int round = 0; round < 60; ++round) {
    Scene tile;
    tile.reuse_ids(round % 2 == 0);
    const NodeId top = tile.add_node(tile.root(), "tile " + std::to_string(round));
    for (int i = 0; i < 50; ++i) {
      const NodeId node = tile.add_node(top, "node");
      tile.set_attribute(node, "round", std::to_string(round));
      const MaterialId material = tile.add_material({.name = {}, .colour = vec3(float(round) / 60.0f)});
      const Affine at = translation({double(round), double(i), 0.0});
      const float size = 1.0f + float(round) / 10.0f;
      const std::array<Primitive, 2> shapes{Sphere{size}, Box{size, float(i + 1), 1.0f}};
      tile.add_primitive(node, shapes[std::size_t(i) % 2], at, material);
      const ItemId dropped = tile.add_primitive(node, kPipe);
      tile.add_mesh_instance(node, tile.add_mesh(named_triangle(100 * round + i)).value(), at);
      if (i % 2) tile.remove_item(dropped);
      if (i % 7 == 0) tile.remove_material(material);
      if (i % 9 == 0) tile.remove_node(tile.add_node(top));
    }
    Scene twin = tile;
    scene.remove_item(scene.add_primitive(scene.root(), kPipe));  // its id is free at once, and touched
    const std::vector<NodeId> added = scene.append(scene.root(), std::move(tile));
    ASSERT_EQ(added.size(), 1u);
    for (const NodeId node : stale) ASSERT_FALSE(scene.contains(node));
    tiles.push_back({added[0], {}, {}});
    std::vector<NodeId> wanted, found;
    twin.for_each_node(twin.first_child(twin.root()), [&](NodeId node, const auto&...) { wanted.push_back(node); });
    scene.for_each_node(added[0], [&](NodeId node, const auto&...) { found.push_back(node); });
    ASSERT_EQ(found.size(), wanted.size());
    for (std::size_t n = 0; n < found.size(); ++n) {
      ASSERT_EQ(scene.name(found[n]), twin.name(wanted[n]));
      ASSERT_EQ(scene.attributes(found[n]), twin.attributes(wanted[n]));
      const auto items = tests::items_of(scene, found[n]), same = tests::items_of(twin, wanted[n]);
      ASSERT_EQ(items.size(), same.size());
      for (std::size_t i = 0; i < items.size(); ++i) {
        ASSERT_EQ(scene.kind(items[i]), twin.kind(same[i]));
        ASSERT_EQ(scene.node_of(items[i]), found[n]);
        ASSERT_EQ(scene.placement(items[i]).origin, twin.placement(same[i]).origin);
        const MaterialId a = scene.item_material(items[i]), b = twin.item_material(same[i]);
        ASSERT_EQ(a.valid(), b.valid());
        if (a.valid()) {
          ASSERT_EQ(scene.material(a).colour, twin.material(b).colour);
          tiles.back().materials.push_back(a);
        }
        if (int(scene.kind(items[i])) < kPrimitiveKindCount) {
          const Primitive x = scene.primitive(items[i]), y = twin.primitive(same[i]);
          ASSERT_TRUE(std::ranges::equal(parameters(x), parameters(y)));
        } else {
          tiles.back().meshes.push_back(scene.mesh_of(items[i]));
          ASSERT_EQ(scene.mesh(tiles.back().meshes.back()).name, twin.mesh(twin.mesh_of(same[i])).name);
        }
      }
    }
    if (tiles.size() > 3) {
      const std::size_t place = random() % tiles.size();
      scene.for_each_node(tiles[place].node, [&](NodeId node, const auto&...) { stale.push_back(node); });
      scene.remove_node(tiles[place].node);
      for (const MeshId mesh : tiles[place].meshes) scene.remove_mesh(mesh);
      for (const MaterialId material : tiles[place].materials) scene.remove_material(material);
      tiles.erase(tiles.begin() + std::ptrdiff_t(place));
    }
    const auto delta = scene.commit();
    ASSERT_TRUE(delta);
    for (const auto* list : {&delta->inserted, &delta->changed, &delta->removed})
      ASSERT_EQ(std::adjacent_find(list->begin(), list->end()), list->end()) << "each once";
    for (SceneDelta taken = subscription.take(); !taken.empty(); taken = subscription.take()) snapshot.apply(taken);
    ASSERT_NO_FATAL_FAILURE(expect_same_items(snapshot, Snapshot(scene), ItemId(scene.item_slots())));
    if (round == 12) settled = scene.memory_bytes();
  }
  EXPECT_LE(scene.memory_bytes(), settled + settled / 10);
  EXPECT_LE(scene.item_slots(), 1200u) << "9,000 were added";
  EXPECT_LE(scene.mesh_slots(), 400u);
  EXPECT_LE(scene.material_slots(), 400u);
}

TEST(ReusedIds, MemoryStaysFlatWhileThingsComeAndGo) {
  Scene scene;
  scene.reuse_ids(true);
  Snapshot snapshot(scene);
  SceneSubscription subscription = scene.subscribe();
  const auto pass = [&](int name) {
    std::vector<ItemId> items;
    std::vector<MeshId> meshes;
    std::vector<MaterialId> materials;
    const NodeId node = scene.add_node(scene.root());
    for (int i = 0; i < 1000; ++i) {
      if (i % 10 == 0) {
        meshes.push_back(scene.add_mesh(named_triangle(name)).value());
        materials.push_back(scene.add_material({}));
        items.push_back(scene.add_mesh_instance(node, meshes.back(), {}, materials.back()));
      } else {
        items.push_back(scene.add_primitive(node, kPipe));
      }
    }
    ASSERT_TRUE(scene.commit());
    subscription.take();
    if (name % 2) {
      scene.remove_node(node);
    } else {
      for (const ItemId item : items) scene.remove_item(item);
      scene.remove_node(node);
    }
    for (const MeshId mesh : meshes) scene.remove_mesh(mesh);
    for (const MaterialId material : materials) scene.remove_material(material);
    ASSERT_TRUE(scene.commit());
    subscription.take();
    subscription.take();
  };
  for (int i = 0; i < 4; ++i) pass(i);
  const std::size_t before = scene.memory_bytes(), ids = scene.item_slots();
  for (int i = 0; i < tests::repeated(10'000); ++i) pass(i);  // ten million items
  EXPECT_EQ(scene.memory_bytes(), before);
  EXPECT_EQ(scene.item_slots(), ids);
  EXPECT_LE(ids, 3000u);
  EXPECT_LE(scene.mesh_slots(), 300u);
  EXPECT_LE(scene.material_slots(), 300u);
}

TEST(ReusedIds, AnIdRestsUntilEverySubscriberHasFollowed) {
  Scene scene;
  SceneSubscription prompt = scene.subscribe(), slow = scene.subscribe();
  const auto commit = [&] { ASSERT_TRUE(scene.commit()); };
  const auto add = [&] { return scene.add_primitive(scene.root(), kPipe); };
  const ItemId never = add();
  scene.remove_item(never);
  scene.reuse_ids(true);
  commit();
  const ItemId first = add();
  EXPECT_NE(first, never) << "removed before ids were reused";
  commit();
  scene.remove_item(first);
  commit();
  for (int i = 0; i < 3; ++i) prompt.take();
  commit();
  EXPECT_NE(add(), first) << "slow has not even taken it";
  slow.take();
  commit();
  EXPECT_NE(add(), first) << "slow may still work on it";
  prompt.take(), prompt.take();
  slow.take();
  commit();
  EXPECT_EQ(add(), first);

  const ItemId unseen = add();
  scene.remove_item(unseen);
  EXPECT_EQ(add(), unseen) << "nobody has seen it";
  commit();
  const SceneDelta seen = prompt.take();
  EXPECT_EQ(std::count(seen.inserted.begin(), seen.inserted.end(), unseen), 1);
  EXPECT_TRUE(seen.removed.empty());
}

TEST(ReusedIds, ASubscriberThatIsGoneHoldsNothingUp) {
  Scene scene;
  scene.reuse_ids(true);
  const ItemId item = scene.add_primitive(scene.root(), kPipe);
  {
    const SceneSubscription idle = scene.subscribe();
    ASSERT_TRUE(scene.commit());
    scene.remove_item(item);
    ASSERT_TRUE(scene.commit());
    EXPECT_NE(scene.add_primitive(scene.root(), kPipe), item);
  }
  ASSERT_TRUE(scene.commit());
  EXPECT_EQ(scene.add_primitive(scene.root(), kPipe), item);
}

TEST(ReusedIds, WhatIsTakenBackGetsNewIdsMeanwhile) {
  Scene scene;
  scene.reuse_ids(true);
  const ItemId item = scene.add_primitive(scene.root(), kPipe);
  const MeshId mesh = scene.add_mesh(triangle()).value();
  ASSERT_TRUE(scene.commit());
  scene.remove_item(item);
  scene.remove_mesh(mesh);
  ASSERT_TRUE(scene.commit());
  {
    const Scene::Mark mark = scene.mark();
    const NodeId node = scene.add_node(scene.root());
    EXPECT_GE(scene.add_mesh(triangle()).value().index, mark.meshes);
    const ItemId tried = scene.add_primitive(node, kPipe);
    EXPECT_GE(to_index(tried), mark.items);
    scene.remove_item(tried);  // as imports drop what cannot be committed
    scene.take_back(mark, std::vector{node});
  }
  EXPECT_EQ(scene.add_primitive(scene.root(), kPipe), item);
  const MeshId again = scene.add_mesh(triangle()).value();
  EXPECT_EQ(again.index, mesh.index);
  EXPECT_NE(again, mesh);
  const ItemId next = scene.add_primitive(scene.root(), kPipe);
  EXPECT_EQ(to_index(next) + 1, scene.item_slots()) << "not the one that was taken back";
  ASSERT_TRUE(scene.commit());
}

}  // namespace
}  // namespace sightline::core::reused_ids_test
