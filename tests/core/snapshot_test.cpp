#include "sightline/core/snapshot.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <span>

#include <gtest/gtest.h>

#include "sightline/core/internal/snapshot_copies.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::core::snapshot_test {
namespace {

using tests::Random;
using tests::uniform;

/// A tree of nodes with items of every kind, primitives in millimetres scaled to metres, over a site of `site` metres.
class RandomPlant {
 public:
  RandomPlant(std::uint64_t seed, int items, double site, const dvec3& offset = dvec3(0.0))
      : random_(seed), site_(site) {
    top_ = scene.add_node(scene.root(), "site", translation(offset));
    nodes_.push_back(top_);
    for (int i = 0; i < 3; ++i) materials_.push_back(scene.add_material({}));
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    meshes_.push_back(scene.add_mesh(mesh).value());
    mesh.contour_sizes = {4};
    mesh.polygon_contours = {1};
    meshes_.push_back(scene.add_mesh(mesh).value());
    meshes_.push_back(scene.add_mesh({}).value());
    for (int i = 0; i < items; ++i) {
      if (random_() % 8 == 0) add_node();
      add_item();
    }
  }

  Scene scene;

  /// One edit of any sort.
  void edit() {
    const NodeId node = some_node();
    const ItemId item = some_item();
    if (random_() % 10 == 0) edit_material();
    switch (random_() % 12) {
      case 0:
        return add_node();
      case 1:
      case 2:
        return add_item();
      case 3:
        return scene.set_transform(node, somewhere(0.01));
      case 4:
        return scene.set_visible(node, random_() % 2);
      case 5:
        return scene.set_layers(node, random_() % 2 ? 0 : kLayerInsulation);
      case 6:
        return scene.set_material(node, materials_[random_() % materials_.size()]);
      case 7:
        if (node != top_ && random_() % 4 == 0) scene.remove_node(node);
        return;
      default:
        break;
    }
    if (item == kNoItem) return;
    if (scene.kind(item) == Kind::kMesh && random_() % 2) return scene.set_mesh(item, meshes_[random_() % 2 ? 0 : 2]);
    switch (random_() % 4) {
      case 0:
        return scene.remove_item(item);
      case 1:
        return scene.set_placement(item, small_parts());
      case 2:
        return scene.set_visible(item, random_() % 2);
      default:
        return scene.set_material(item, materials_[random_() % materials_.size()]);
    }
  }

 private:
  Affine somewhere(double share) {
    // Coordinates of a binary grid: adding whole metres to them is exact.
    Affine a{tests::random_rotation(random_), dvec3(0.0)};
    if (random_() % 2) a.linear = dmat3(1.0);
    for (int i = 0; i < 3; ++i) a.origin[i] = std::round(uniform(random_, -1.0, 1.0) * share * site_ * 1024.0) / 1024.0;
    return a;
  }
  Affine small_parts() {
    Affine a = somewhere(1.0);
    a.linear = a.linear * 0.001;
    return a;
  }
  NodeId some_node() {
    NodeId node;
    do node = nodes_[random_() % nodes_.size()];
    while (!scene.contains(node));
    return node;
  }
  ItemId some_item() {
    for (int tries = 0; tries < 20 && scene.item_slots() > 0; ++tries)
      if (const ItemId item = ItemId(random_() % scene.item_slots()); scene.contains_item(item)) return item;
    return kNoItem;
  }
  void edit_material() {
    MaterialId& material = materials_[random_() % materials_.size()];
    const Material look{
        .name = "look", .colour = {0.5f, 0.25f, float(random_() % 8) / 8.0f}, .alpha = random_() % 2 ? 1.0f : 0.5f};
    if (random_() % 2) return scene.update_material(material, look);
    scene.remove_material(material);
    material = scene.add_material(look);
  }
  void add_node() { nodes_.push_back(scene.add_node(some_node(), "", somewhere(0.01))); }
  void add_item() {
    const Kind kind = static_cast<Kind>(random_() % kKindCount);
    const MaterialId material = random_() % 2 ? MaterialId{} : materials_[random_() % materials_.size()];
    if (int(kind) < kPrimitiveKindCount) {
      scene.add_primitive(some_node(), tests::random_primitive(kind, random_), small_parts(), material);
    } else {
      scene.add_mesh_instance(some_node(), meshes_[random_() % meshes_.size()], somewhere(1.0), material);
    }
  }

  Random random_;
  double site_;
  NodeId top_;
  std::vector<NodeId> nodes_;
  std::vector<MaterialId> materials_;
  std::vector<MeshId> meshes_;
};

std::vector<ItemId> live_items(const Scene& scene) {
  std::vector<ItemId> items;
  for (ItemId i{0}; to_index(i) < scene.item_slots(); ++i)
    if (scene.contains_item(i)) items.push_back(i);
  return items;
}

/// Structure: maps both ways, kind arrays in slot order, ranks by counting.
void expect_consistent(const Snapshot& snapshot) {
  ASSERT_EQ(snapshot.bounds().size(), snapshot.size());
  std::array<std::uint32_t, kKindCount> counts{};
  for (Slot s = 0; s < snapshot.size(); ++s) {
    for (int k = 0; k < kKindCount; ++k) ASSERT_EQ(snapshot.rank(static_cast<Kind>(k), s), counts[std::size_t(k)]);
    const Kind kind = snapshot.kind(s);
    const KindItems& list = snapshot.of_kind(kind);
    ASSERT_EQ(snapshot.index_in_kind(s), counts[std::size_t(kind)]);
    ASSERT_LT(snapshot.index_in_kind(s), list.size());
    ASSERT_EQ(list.members[snapshot.index_in_kind(s)], s);
    ++counts[std::size_t(kind)];
    const ItemId item = snapshot.item(s);
    if (item == kNoItem) {
      ASSERT_TRUE(snapshot.vacant(s)) << "given up";
      continue;
    }
    ASSERT_TRUE(snapshot.scene().contains_item(item));
    ASSERT_EQ(snapshot.slot(item), s);
    ASSERT_EQ(kind, snapshot.scene().kind(item));
  }
  for (int k = 0; k < kKindCount; ++k) {
    const KindItems& list = snapshot.of_kind(static_cast<Kind>(k));
    ASSERT_EQ(snapshot.rank(static_cast<Kind>(k), Slot(snapshot.size())), counts[std::size_t(k)]);
    ASSERT_EQ(list.size(), counts[std::size_t(k)]);
    ASSERT_EQ(list.placements.size(), list.size());
    ASSERT_TRUE(std::is_sorted(list.members.begin(), list.members.end()));
    const bool mesh = k >= kPrimitiveKindCount;
    ASSERT_EQ(list.meshes.size(), mesh ? list.size() : 0);
    ASSERT_EQ(list.parameters.size(), mesh ? 0 : list.size() * std::size_t(parameter_count(static_cast<Kind>(k))));
  }
}

/// Each live item as the scene has it now: box around the exact one, placement, parameters, material, layers.
void expect_shows(const Snapshot& snapshot, const Scene& scene) {
  std::size_t live = 0;
  for (const ItemId item : live_items(scene)) {
    SCOPED_TRACE(testing::Message() << "item " << to_index(item));
    const Slot s = snapshot.slot(item);
    ASSERT_LT(s, snapshot.size());
    ++live;
    const Scene::ItemState state = scene.state(item);
    ASSERT_EQ(snapshot.material(s), state.material);
    if (state.material != kNone) {
      const Material& look = scene.material(scene.material_at(state.material));
      ASSERT_EQ(snapshot.materials()[state.material], glm::vec4(look.colour, look.alpha));
      ASSERT_EQ(snapshot.opaque(s), look.alpha >= 1.0f);
    }
    if (int(snapshot.kind(s)) < kPrimitiveKindCount) {
      const Primitive a = snapshot.primitive(s), b = scene.primitive(item);
      ASSERT_TRUE(std::ranges::equal(parameters(a), parameters(b)));
    } else {
      ASSERT_EQ(snapshot.of_kind(snapshot.kind(s)).meshes[snapshot.index_in_kind(s)], scene.mesh_of(item).index);
    }
    const AabbD exact = scene.bounds_under(item, state.world_from_item);
    const Aabb box = snapshot.bounds().box(s);
    ASSERT_EQ(box.empty(), exact.empty() || state.layers == 0);
    if (!box.empty()) {
      ASSERT_EQ(snapshot.bounds().layers(s), state.layers);
    }
    for (int axis = 0; axis < 3 && !box.empty(); ++axis) {
      const long double origin = snapshot.bounds().origin[axis];
      ASSERT_LE(origin + box.min[axis], (long double)(exact.min[axis]));
      ASSERT_GE(origin + box.max[axis], (long double)(exact.max[axis]));
      const double slack = 3e-7 * (std::abs(double(box.min[axis])) + std::abs(double(box.max[axis]))) + 1e-8;
      ASSERT_NEAR(double(origin + box.min[axis]), exact.min[axis], slack);
      ASSERT_NEAR(double(origin + box.max[axis]), exact.max[axis], slack);
    }
    const Placement& placement = snapshot.of_kind(snapshot.kind(s)).placements[snapshot.index_in_kind(s)];
    ASSERT_LT(placement.chunk, snapshot.chunk_origins().size());
    ASSERT_EQ(placement.linear, mat3(state.world_from_item.linear));
    const dvec3 origin = snapshot.world_from_item(s).origin;
    ASSERT_LT(glm::distance(origin, state.world_from_item.origin),
              1e-7 * (1e-3 + glm::length(placement.origin)) + 4e-9);
  }
  std::size_t held = 0, vacant = 0;
  for (Slot s = 0; s < snapshot.size(); ++s) {
    held += snapshot.item(s) != kNoItem;
    vacant += snapshot.vacant(s);
    ASSERT_EQ(snapshot.bounds().box(s).empty(), snapshot.vacant(s));
  }
  ASSERT_EQ(held, live);
  ASSERT_EQ(snapshot.vacant_count(), vacant);
}

TEST(Snapshot, ShowsTheScene) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    const double far = seed % 2 ? 7e6 : 0.0;
    RandomPlant plant(seed, seed % 4 == 0 ? int(seed) : 500, seed % 3 == 0 ? 10.0 : 300.0, dvec3(far, -far, 0));
    ASSERT_TRUE(plant.scene.commit());
    const Snapshot snapshot(plant.scene);
    EXPECT_EQ(&snapshot.scene(), &plant.scene);
    EXPECT_EQ(snapshot.size(), plant.scene.item_count());
    EXPECT_EQ(snapshot.disorder(), 0u);
    ASSERT_NO_FATAL_FAILURE(expect_consistent(snapshot));
    ASSERT_NO_FATAL_FAILURE(expect_shows(snapshot, plant.scene));
  }
}

TEST(Snapshot, OfAnEmptyScene) {
  Scene scene;
  Snapshot snapshot(scene);
  EXPECT_EQ(snapshot.size(), 0u);
  EXPECT_EQ(snapshot.rank(Kind::kBox, 0), 0u);
  EXPECT_EQ(snapshot.slot(ItemId{0}), kNone);
  EXPECT_EQ(snapshot.bounds().coordinate(0)[0], Aabb::kFar) << "padding even so";
  EXPECT_TRUE(snapshot.apply(SceneDelta{}).empty());
  EXPECT_EQ(snapshot.size(), 0u);
  const ItemId item = scene.add_primitive(scene.root(), Cylinder{1, 1}, translation({1e6, 0, 0}));
  snapshot.apply(*scene.commit());
  EXPECT_EQ(snapshot.size(), 1u);
  EXPECT_EQ(snapshot.slot(item), 0u);
  expect_consistent(snapshot);
  expect_shows(snapshot, scene);
}

TEST(Snapshot, GenerationsRiseAndDeltasKeepThem) {
  RandomPlant plant(1, 50, 10.0);
  ASSERT_TRUE(plant.scene.commit());
  Snapshot a(plant.scene);
  const Snapshot b(plant.scene);
  EXPECT_LT(a.generation(), b.generation());
  const std::uint64_t generation = a.generation();
  plant.scene.remove_item(ItemId{3});
  a.apply(*plant.scene.commit());
  EXPECT_EQ(a.generation(), generation);
}

TEST(Snapshot, SlotsOfHiddenItemsAreVacantUntilTheyComeBack) {
  Scene scene;
  const NodeId node = scene.add_node(scene.root());
  const ItemId shown = scene.add_primitive(scene.root(), Sphere{1}), below = scene.add_primitive(node, Sphere{1}),
               alone = scene.add_primitive(scene.root(), Sphere{1});
  EXPECT_FALSE(Snapshot(scene).bounds().uses_layers());
  scene.set_visible(node, false);
  scene.set_visible(alone, false);
  ASSERT_TRUE(scene.commit());
  Snapshot snapshot(scene);
  EXPECT_FALSE(snapshot.bounds().uses_layers());
  EXPECT_FALSE(snapshot.vacant(snapshot.slot(shown)));
  EXPECT_TRUE(snapshot.vacant(snapshot.slot(below)));
  EXPECT_TRUE(snapshot.vacant(snapshot.slot(alone)));
  EXPECT_EQ(snapshot.item(snapshot.slot(below)), below) << "it still has its place";
  EXPECT_EQ(snapshot.vacant_count(), 2u);
  const Slot place = snapshot.slot(below);
  scene.set_visible(node, true);
  EXPECT_EQ(snapshot.apply(*scene.commit()), std::vector{place});
  EXPECT_EQ(snapshot.slot(below), place);
  EXPECT_FALSE(snapshot.vacant(place));
  EXPECT_EQ(snapshot.disorder(), 0u);
}

// --- precision -------------------------------------------------------------------------------------------------------

TEST(Snapshot, PlacementsAreMicrometresFineWhereverTheSiteLies) {
  for (const double far : {0.0, 1e4, 7e6}) {
    SCOPED_TRACE(far);
    RandomPlant plant(5, 3000, 100.0, {far, -far, far});
    ASSERT_TRUE(plant.scene.commit());
    const Snapshot snapshot(plant.scene);
    ASSERT_LE(snapshot.chunk_origins().size(), 4096u);
    for (int k = 0; k < kKindCount; ++k)
      for (const Placement& p : snapshot.of_kind(static_cast<Kind>(k)).placements)
        for (int axis = 0; axis < 3; ++axis) ASSERT_LE(std::abs(p.origin[axis]), 8.0f) << "half a chunk";
    for (const ItemId item : live_items(plant.scene)) {
      const dvec3 exact = plant.scene.state(item).world_from_item.origin;
      const dvec3 kept = snapshot.world_from_item(snapshot.slot(item)).origin;
      for (int axis = 0; axis < 3; ++axis) ASSERT_NEAR(kept[axis], exact[axis], 5e-7);
    }
  }
}

TEST(Snapshot, VastSitesGetCoarserChunksRatherThanMore) {
  Scene scene;
  Random random(6);
  for (int i = 0; i < 20'000; ++i) {
    const dvec3 p(uniform(random, -1e6, 1e6), uniform(random, -1e6, 1e6), uniform(random, -1e6, 1e6));
    scene.add_primitive(scene.root(), Cylinder{1, 1}, translation(p));
  }
  scene.add_primitive(scene.root(), Cylinder{1, 1}, translation(dvec3(9e36)));
  scene.add_primitive(scene.root(), Cylinder{1, 1}, translation(dvec3(-9e36)));
  ASSERT_TRUE(scene.commit());
  const Snapshot snapshot(scene);
  EXPECT_LE(snapshot.chunk_origins().size(), 4096u);
  for (Slot s = 0; s < snapshot.size(); ++s) {
    const dvec3 exact = scene.state(snapshot.item(s)).world_from_item.origin, kept = snapshot.world_from_item(s).origin;
    const Placement& p = snapshot.of_kind(Kind::kCylinder).placements[snapshot.index_in_kind(s)];
    ASSERT_LE(glm::distance(kept, exact), 1e-7 * double(glm::length(p.origin)) + 1e-15 * glm::length(exact));
  }
}

TEST(Snapshot, AMovedSiteIsTheSameSite) {
  const dvec3 far(3e6, 7e6, 1e3);
  RandomPlant here(7, 2000, 100.0), there(7, 2000, 100.0, far);
  ASSERT_TRUE(here.scene.commit());
  ASSERT_TRUE(there.scene.commit());
  const Snapshot a(here.scene), b(there.scene);
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(b.bounds().origin - a.bounds().origin, far);
  ASSERT_EQ(a.chunk_origins().size(), b.chunk_origins().size());
  for (Slot s = 0; s < a.size(); ++s) {
    ASSERT_EQ(a.item(s), b.item(s)) << "the same order";
    const Aabb p = a.bounds().box(s), q = b.bounds().box(s);
    for (int axis = 0; axis < 3 && !p.empty(); ++axis) {
      ASSERT_NEAR(p.min[axis], q.min[axis], 2e-5);
      ASSERT_NEAR(p.max[axis], q.max[axis], 2e-5);
    }
    const KindItems &list_a = a.of_kind(a.kind(s)), &list_b = b.of_kind(b.kind(s));
    const Placement &u = list_a.placements[a.index_in_kind(s)], &v = list_b.placements[b.index_in_kind(s)];
    ASSERT_EQ(u.chunk, v.chunk);
    ASSERT_EQ(u.linear, v.linear);
    ASSERT_LT(glm::distance(a.world_from_item(s).origin + far, b.world_from_item(s).origin), 1e-6);
  }
}

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

/// Every array, bit for bit.
void expect_identical(const Snapshot& a, const Snapshot& b) {
  const std::size_t n = a.size();
  ASSERT_EQ(n, b.size());
  for (int axis = 0; axis < 6; ++axis)
    ASSERT_TRUE(same_bytes(std::span(a.bounds().coordinate(axis), n + ItemBounds::kPadding),
                           std::span(b.bounds().coordinate(axis), n + ItemBounds::kPadding)));
  ASSERT_EQ(a.bounds().origin, b.bounds().origin);
  ASSERT_EQ(a.bounds().extent().min, b.bounds().extent().min);
  ASSERT_EQ(a.bounds().extent().max, b.bounds().extent().max);
  ASSERT_EQ(a.bounds().uses_layers(), b.bounds().uses_layers());
  ASSERT_TRUE(same_bytes(a.bounds().layers(), b.bounds().layers()));
  ASSERT_EQ(a.vacant_count(), b.vacant_count());
  ASSERT_EQ(a.chunk_origins(), b.chunk_origins());
  for (Slot s = 0; s < n; ++s) {
    ASSERT_EQ(a.item(s), b.item(s)) << "slot " << s;
    ASSERT_EQ(a.kind(s), b.kind(s)) << "slot " << s;
    ASSERT_EQ(a.index_in_kind(s), b.index_in_kind(s)) << "slot " << s;
    ASSERT_EQ(a.material(s), b.material(s)) << "slot " << s;
    ASSERT_EQ(a.slot(a.item(s)), b.slot(a.item(s))) << "slot " << s;
    ASSERT_EQ(a.first_vacant(s, Slot(n)), b.first_vacant(s, Slot(n))) << "slot " << s;
  }
  for (int k = 0; k < kKindCount; ++k) {
    const KindItems &p = a.of_kind(static_cast<Kind>(k)), &q = b.of_kind(static_cast<Kind>(k));
    ASSERT_TRUE(same_bytes<Slot>(p.members, q.members));
    ASSERT_TRUE(same_bytes<Placement>(p.placements, q.placements));
    ASSERT_TRUE(same_bytes<float>(p.parameters, q.parameters));
    ASSERT_TRUE(same_bytes<std::uint32_t>(p.meshes, q.meshes));
  }
}

ItemCopies copies_of(const Snapshot& snapshot) {
  ItemCopies items;
  copy_items(snapshot, 0, Slot(snapshot.size()), items);
  return items;
}

TEST(Snapshot, DoesNotDependOnThreads) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    // With many edits and with none: hidden and removed items and layers of their own, or none of these.
    RandomPlant plant(seed, seed % 4 == 3 ? 30'000 : 1'500 + 700 * int(seed), 200.0);
    for (int i = 0; i < 300 && seed % 2 == 0; ++i) plant.edit();
    ASSERT_TRUE(plant.scene.commit());
    const Snapshot one(plant.scene, 1);
    ASSERT_NO_FATAL_FAILURE(expect_consistent(one));
    ASSERT_NO_FATAL_FAILURE(expect_shows(one, plant.scene));
    const Snapshot copied = reordered(one, copies_of(one), 1);
    ASSERT_NO_FATAL_FAILURE(expect_consistent(copied));
    for (const int threads : {2, 3, 8}) {
      SCOPED_TRACE(testing::Message() << threads << " threads");
      ASSERT_NO_FATAL_FAILURE(expect_identical(one, Snapshot(plant.scene, threads)));
      ASSERT_NO_FATAL_FAILURE(expect_identical(copied, reordered(one, copies_of(one), threads)));
    }
  }
}

// --- deltas ----------------------------------------------------------------------------------------------------------

/// Both show the same: the same items in the same boxes up to float rounding about different origins.
void expect_same_image(const Snapshot& followed, const Snapshot& fresh) {
  const auto image = [](const Snapshot& snapshot) {
    std::set<ItemId> items;
    for (Slot s = 0; s < snapshot.size(); ++s)
      if (!snapshot.vacant(s)) items.insert(snapshot.item(s));
    return items;
  };
  ASSERT_EQ(image(followed), image(fresh));
}

TEST(Snapshot, FollowsRandomDeltas) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    RandomPlant plant(seed, int(seed) * 5, seed % 2 ? 20.0 : 500.0, dvec3(seed % 3 == 0 ? 5e6 : 0.0));
    ASSERT_TRUE(plant.scene.commit());
    Snapshot snapshot(plant.scene);
    Random random(seed);
    for (int round = 0; round < 12; ++round) {
      for (std::uint64_t i = random() % 30; i > 0; --i) plant.edit();
      const std::vector<ItemId> order_before = [&] {
        std::vector<ItemId> items;
        for (Slot s = 0; s < snapshot.size(); ++s) items.push_back(snapshot.item(s));
        return items;
      }();
      const auto delta = plant.scene.commit();
      ASSERT_TRUE(delta) << delta.error().message;
      const ItemBounds before = snapshot.bounds();
      const std::vector<Slot> touched = snapshot.apply(*delta);
      const std::set<Slot> changed(touched.begin(), touched.end());
      ASSERT_EQ(changed.size(), touched.size()) << "each once";
      for (Slot s = 0; s < order_before.size(); ++s) {
        if (changed.contains(s)) continue;
        ASSERT_EQ(snapshot.item(s), order_before[s]);
        ASSERT_EQ(snapshot.bounds().box(s).min, before.box(s).min);
        ASSERT_EQ(snapshot.bounds().box(s).max, before.box(s).max);
        ASSERT_EQ(snapshot.bounds().layers(s), before.layers(s));
      }
      for (const ItemId item : delta->inserted) ASSERT_GE(snapshot.slot(item), order_before.size());
      ASSERT_NO_FATAL_FAILURE(expect_consistent(snapshot));
      ASSERT_NO_FATAL_FAILURE(expect_shows(snapshot, plant.scene));
      ASSERT_NO_FATAL_FAILURE(expect_same_image(snapshot, Snapshot(plant.scene)));
    }
  }
}

TEST(Snapshot, CatchesUpWithDeltasThatCameMeanwhile) {
  // Built in the background at one commit, published after several more.
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    RandomPlant plant(seed, 100, 50.0);
    ASSERT_TRUE(plant.scene.commit());
    Snapshot early(plant.scene);
    std::vector<SceneDelta> deltas;
    for (int round = 0; round < 6; ++round) {
      for (int i = 0; i < 15; ++i) plant.edit();
      deltas.push_back(*plant.scene.commit());
    }
    for (const SceneDelta& delta : deltas) early.apply(delta);
    ASSERT_NO_FATAL_FAILURE(expect_consistent(early));
    ASSERT_NO_FATAL_FAILURE(expect_shows(early, plant.scene));
  }
}

/// Items are read as they are now, with materials that only a later delta names.
TEST(Snapshot, KnowsMaterialsOfLaterDeltas) {
  Scene scene;
  const ItemId item = scene.add_primitive(scene.root(), Sphere{1});
  ASSERT_TRUE(scene.commit());
  Snapshot snapshot(scene);
  scene.set_placement(item, translation({1, 0, 0}));
  const SceneDelta moved = *scene.commit();
  const MaterialId glass = scene.add_material({.name = "glass", .alpha = 0.5f});
  scene.set_material(item, glass);
  const SceneDelta painted = *scene.commit();
  for (const SceneDelta& delta : {moved, painted}) {
    snapshot.apply(delta);
    ASSERT_EQ(snapshot.material(snapshot.slot(item)), glass.index);
    ASSERT_GT(snapshot.materials().size(), glass.index);
    EXPECT_FALSE(snapshot.opaque(snapshot.slot(item)));
  }
}

TEST(Snapshot, TakesADeltaWhoseEditsItAlreadyShows) {
  RandomPlant plant(3, 100, 50.0);
  ASSERT_TRUE(plant.scene.commit());
  for (int i = 0; i < 50; ++i) plant.edit();
  Snapshot eager(plant.scene);  // with pending edits
  const std::size_t size = eager.size();
  eager.apply(*plant.scene.commit());
  EXPECT_EQ(eager.size(), size) << "no item twice";
  expect_consistent(eager);
  expect_shows(eager, plant.scene);
}

TEST(Snapshot, FollowsAWholeSiteThatMovesAway) {
  Scene scene;
  const NodeId site = scene.add_node(scene.root());
  Random random(9);
  for (int i = 0; i < 20'000; ++i) {
    const dvec3 p(uniform(random, -200, 200), uniform(random, -200, 200), uniform(random, 0, 30));
    scene.add_primitive(site, Cylinder{1, 1}, translation(p));
  }
  ASSERT_TRUE(scene.commit());
  Snapshot snapshot(scene);
  const std::size_t at_first = snapshot.chunk_origins().size();
  scene.set_transform(site, translation({5e5, 5e5, 0}));
  snapshot.apply(*scene.commit());
  expect_consistent(snapshot);
  expect_shows(snapshot, scene);
  EXPECT_LE(snapshot.chunk_origins().size(), 2 * at_first) << "each chunk has moved as one";
  for (const Placement& p : snapshot.of_kind(Kind::kCylinder).placements) ASSERT_LE(glm::length(p.origin), 16.0f);
  // Items of a vast site must not each look for a chunk of their own.
  Scene vast;
  for (int i = 0; i < 20'000; ++i)
    vast.add_primitive(vast.root(), Cylinder{1, 1},
                       translation({uniform(random, -1e5, 1e5), uniform(random, -1e5, 1e5), 0}));
  ASSERT_TRUE(vast.commit());
  Snapshot wide(vast);
  const std::size_t chunks = wide.chunk_origins().size();
  vast.set_layers(vast.root(), kLayerModel | kLayerInsulation);
  wide.apply(*vast.commit());
  EXPECT_EQ(wide.chunk_origins().size(), chunks) << "nothing moved";
  expect_shows(wide, vast);
}

/// Each chunk goes along as it was: no offset grows, as it would about the first item of the chunk that has moved.
TEST(Snapshot, WhatMovesAsAWholeKeepsItsPlaceInItsChunk) {
  Scene scene;
  const NodeId site = scene.add_node(scene.root());
  Random random(10);
  constexpr int kItems = 8 * 32;  // heaps that are blocks of slots
  for (int i = 0; i < kItems; ++i) {
    const dvec3 heap(200.0 * (i % 8), 0.0, 0.0);
    scene.add_primitive(site, Cylinder{1, 1},
                        translation(heap + dvec3(uniform(random, 0, 14), uniform(random, 0, 14), 0.0)));
  }
  ASSERT_TRUE(scene.commit());
  Snapshot snapshot(scene);
  const auto offsets = [&] {
    std::vector<vec3> by_item(kItems);
    const KindItems& list = snapshot.of_kind(Kind::kCylinder);
    for (std::size_t i = 0; i < list.size(); ++i)
      if (const ItemId item = snapshot.item(list.members[i]); item != kNoItem)
        by_item[to_index(item)] = list.placements[i].origin;
    return by_item;
  };
  const std::vector<vec3> before = offsets();
  scene.set_transform(site, translation({5e5, 5e5, 0}));
  snapshot.apply(*scene.commit());
  const std::vector<vec3> after = offsets();
  for (std::size_t i = 0; i < before.size(); ++i) ASSERT_LT(glm::distance(before[i], after[i]), 1e-4f) << "item " << i;
}

TEST(Snapshot, FollowsADeepNestThatMoves) {
  Scene scene;
  NodeId node = scene.root();
  for (int i = 0; i < 100'000; ++i) {
    node = scene.add_node(node, "", translation({1e-3, 0, 0}));
    scene.add_primitive(node, Sphere{1});
  }
  ASSERT_TRUE(scene.commit());
  Snapshot snapshot(scene);
  scene.set_transform(scene.first_child(scene.root()), translation({0, 5, 0}));
  snapshot.apply(*scene.commit());
  const dvec3 last = snapshot.world_from_item(snapshot.slot(ItemId(99'999))).origin;
  EXPECT_NEAR(last.x, 99.999, 1e-5);
  EXPECT_NEAR(last.y, 5.0, 1e-5);
}

TEST(Snapshot, CountsItsMemory) {
  RandomPlant plant(10, 2000, 100.0);
  const Snapshot snapshot(plant.scene);
  EXPECT_GT(snapshot.memory_bytes(), snapshot.size() * (28 + 48));
  EXPECT_LT(snapshot.memory_bytes(), snapshot.size() * 400);
}

}  // namespace
}  // namespace sightline::core::snapshot_test
