// A snapshot that followed edits, and a copy of it in a new scene version, show what a new snapshot of the scene shows:
// the same items, in the same boxes, in every view, by every culler.
#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/core/internal/snapshot_copies.h"
#include "sightline/core/snapshot.h"
#include "sightline/culling/frustum/linear_culler.h"

namespace sightline::tests::snapshot_edits_test {
namespace {

using core::ItemId;
using core::Slot;
using core::Snapshot;

/// A scene of nodes with a few boxes each, in a cube of half side `half` about a place.
class EditedScene {
 public:
  EditedScene(std::uint64_t seed, int nodes, double half) : random_(seed), half_(half) {
    for (int i = 0; i < nodes; ++i) add_node();
  }

  core::Scene scene;

  void add_node() {
    nodes_.push_back(scene.add_node(scene.root(), "", core::translation(point(random_, half_))));
    for (int i = whole(random_, 1, 6); i > 0; --i) add_item(nodes_.back());
  }
  /// One of a kind of edit: 0 moves near, 1 moves far, 2 inserts, 3 removes, 4 hides or shows, 5 changes layers.
  void edit(int kind) {
    if (nodes_.empty()) return add_node();
    const std::size_t which = std::size_t(whole(random_, 0, int(nodes_.size()) - 1));
    const core::NodeId node = nodes_[which];
    const ItemId item = scene.first_item(node);
    switch (kind) {
      case 0:
        if (item != core::kNoItem) scene.set_placement(item, core::translation(point(random_, 0.02 * half_)));
        break;
      case 1:
        scene.set_transform(node, core::translation(point(random_, half_)));
        break;
      case 2:
        return chance(random_, 0.3) ? add_node() : add_item(node);
      case 3:
        if (item != core::kNoItem && chance(random_, 0.8)) return scene.remove_item(item);
        scene.remove_node(node);
        nodes_.erase(nodes_.begin() + std::ptrdiff_t(which));
        break;
      case 4:
        if (item != core::kNoItem && chance(random_, 0.5)) return scene.set_visible(item, !scene.item_visible(item));
        scene.set_visible(node, !scene.visible(node));
        break;
      default:
        scene.set_layers(node, std::uint32_t(whole(random_, 0, 3)));
    }
  }
  void remove_everything() {
    for (const core::NodeId node : nodes_) scene.remove_node(node);
    nodes_.clear();
  }

 private:
  void add_item(core::NodeId node) {
    const float size = float(half_ * magnitude(random_, 1e-4, 0.05));
    scene.add_primitive(node, core::Box{size, 2 * size, size}, core::translation(point(random_, 0.02 * half_)));
  }

  Random random_;
  double half_;
  std::vector<core::NodeId> nodes_;
};

std::vector<ItemId> items_of(const Snapshot& snapshot, const core::VisibleSet& set) {
  std::vector<ItemId> items;
  for (const Slot slot : set.sorted_slots())
    if (!snapshot.vacant(slot)) items.push_back(snapshot.item(slot));
  EXPECT_EQ(items.size(), snapshot.count(set));
  std::sort(items.begin(), items.end());
  return items;
}

/// Exact while all snapshots have one origin, since boxes are then the same floats.
void expect_same_boxes(const Snapshot& a, const Snapshot& b) {
  std::map<ItemId, core::Aabb> boxes;
  for (Slot s = 0; s < b.size(); ++s)
    if (!b.vacant(s)) boxes[b.item(s)] = b.bounds().box(s);
  std::size_t count = 0;
  for (Slot s = 0; s < a.size(); ++s) {
    if (a.vacant(s)) continue;
    ++count;
    const auto found = boxes.find(a.item(s));
    ASSERT_NE(found, boxes.end()) << "item " << to_index(a.item(s));
    ASSERT_EQ(a.slot(a.item(s)), s);
    ASSERT_EQ(a.bounds().layers(s), b.bounds().layers(b.slot(a.item(s))));
    if (a.bounds().origin != b.bounds().origin) continue;
    ASSERT_EQ(a.bounds().box(s).min, found->second.min);
    ASSERT_EQ(a.bounds().box(s).max, found->second.max);
  }
  ASSERT_EQ(count, boxes.size());
}

Snapshot in_new_order(const Snapshot& snapshot) {
  core::ItemCopies items;
  for (Slot s = 0; s < snapshot.size(); s += 100)
    core::copy_items(snapshot, s, std::min(s + 100, Slot(snapshot.size())), items);
  return core::reordered(snapshot, std::move(items));
}

/// A snapshot with the culler that follows it.
struct Followed {
  explicit Followed(Snapshot s) : snapshot(std::move(s)), culler(snapshot.bounds()) {}
  Followed(const Followed&) = delete;
  Followed& operator=(const Followed&) = delete;
  void apply(const core::SceneDelta& delta) { culler.update(snapshot.apply(delta)); }
  std::vector<ItemId> visible(const core::View& view) {
    core::VisibleSet set;
    culler.cull(view, set);
    const std::vector<ItemId> items = items_of(snapshot, set);
    culling::LinearCuller(snapshot.bounds()).cull(view, set);
    EXPECT_EQ(items_of(snapshot, set), items);
    return items;
  }
  Snapshot snapshot;
  culling::CpuCuller culler;
};

void expect_same(Followed& followed, const core::Scene& scene, Random& random, double half) {
  Followed fresh{Snapshot(scene)}, reordered(in_new_order(followed.snapshot));
  ASSERT_NO_FATAL_FAILURE(expect_same_boxes(followed.snapshot, fresh.snapshot));
  ASSERT_NO_FATAL_FAILURE(expect_same_boxes(reordered.snapshot, followed.snapshot));
  EXPECT_EQ(reordered.snapshot.disorder(), 0u);
  EXPECT_EQ(reordered.snapshot.size(), scene.item_count());
  const bool same_origin = followed.snapshot.bounds().origin == fresh.snapshot.bounds().origin;
  for (int v = 0; v < 6; ++v) {
    core::View view = random_view(random, core::dvec3(0.0), half);
    if (chance(random, 0.3)) add_sections(random, core::dvec3(0.0), half, view);
    if (chance(random, 0.4)) view.layers = std::uint32_t(whole(random, 0, 3));
    const std::vector<ItemId> seen = followed.visible(view);
    ASSERT_EQ(seen, reordered.visible(view)) << "view " << v;
    if (same_origin) {
      ASSERT_EQ(seen, fresh.visible(view)) << "view " << v;
    }
  }
}

/// Scenes are centred by two far items, so that new snapshots have the same origin.
void pin_origin(core::Scene& scene, double half) {
  for (const double sign : {-1.0, 1.0})
    scene.add_primitive(scene.root(), core::Box{1, 1, 1}, core::translation(core::dvec3(sign * 2.0 * half)));
}

TEST(SnapshotEdits, RandomSequences) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = magnitude(random, 1.0, 1000.0);
    EditedScene edited(seed, whole(random, 0, 800), half);
    pin_origin(edited.scene, half);
    ASSERT_TRUE(edited.scene.commit());
    Followed followed{Snapshot(edited.scene)};
    for (int round = 0; round < 8; ++round) {
      const int edits = whole(random, 1, chance(random, 0.2) ? 1000 : 40), only = whole(random, 0, 9);
      for (int i = 0; i < edits; ++i) edited.edit(only < 6 ? only : whole(random, 0, 5));
      followed.apply(*edited.scene.commit());
      ASSERT_NO_FATAL_FAILURE(expect_same(followed, edited.scene, random, half)) << "round " << round;
    }
  }
}

TEST(SnapshotEdits, StiffSequences) {
  Random random(1);
  const double half = 100.0;
  EditedScene edited(1, 0, half);
  Followed followed{Snapshot(edited.scene)};
  const auto commit = [&] { followed.apply(*edited.scene.commit()); };
  const auto check = [&](const char* what) {
    SCOPED_TRACE(what);
    expect_same(followed, edited.scene, random, half);
  };
  ASSERT_NO_FATAL_FAILURE(check("empty"));
  for (int i = 0; i < 300; ++i) edited.add_node();
  commit();
  ASSERT_NO_FATAL_FAILURE(check("from nothing"));
  for (int i = 0; i < 3000; ++i) edited.add_node();
  commit();
  ASSERT_NO_FATAL_FAILURE(check("ten times as many"));
  edited.scene.set_visible(edited.scene.root(), false);
  commit();
  EXPECT_EQ(followed.snapshot.vacant_count(), followed.snapshot.size());
  ASSERT_NO_FATAL_FAILURE(check("everything hidden"));
  edited.scene.set_visible(edited.scene.root(), true);
  commit();
  EXPECT_EQ(followed.snapshot.vacant_count(), 0u);
  ASSERT_NO_FATAL_FAILURE(check("everything shown"));
  const std::size_t before = followed.snapshot.size();
  edited.scene.set_transform(edited.scene.root(), core::translation({1e5, 2e5, -3e5}));
  commit();
  EXPECT_EQ(followed.snapshot.size(), before) << "what moves as a whole keeps its slots";
  ASSERT_NO_FATAL_FAILURE(check("everything far away"));
  edited.scene.set_transform(edited.scene.root(), {});
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 10'000; ++i) edited.edit(1);
    commit();
  }
  EXPECT_LE(followed.snapshot.size(), before + before / 4 + 64) << "relocation is bounded";
  ASSERT_NO_FATAL_FAILURE(check("everything shuffled"));
  edited.remove_everything();
  commit();
  EXPECT_EQ(followed.snapshot.vacant_count(), followed.snapshot.size());
  ASSERT_NO_FATAL_FAILURE(check("everything removed"));
  edited.add_node();
  commit();
  ASSERT_NO_FATAL_FAILURE(check("a new beginning"));
}

TEST(SnapshotEdits, FarMovesOpenNoBlock) {
  Random random(2);
  core::Scene scene;
  for (int i = 0; i < 32 * 512; ++i)
    scene.add_primitive(scene.root(), core::Box{0.1f, 0.1f, 0.1f}, core::translation(point(random, 50.0)));
  ASSERT_TRUE(scene.commit());
  Followed followed{Snapshot(scene)};
  const std::size_t size = followed.snapshot.size();
  const auto sizes = [&] {
    std::vector<float> all;
    for (std::uint32_t lane = 0; lane < size / 32; ++lane) {
      const auto& b = followed.culler.hierarchy().level(0)[lane / culling::kLanes].bounds;
      const std::uint32_t k = lane % culling::kLanes;
      all.push_back(b[3][k] - b[0][k] + b[4][k] - b[1][k] + b[5][k] - b[2][k]);
    }
    return all;
  };
  const std::vector<float> before = sizes();
  for (ItemId item{0}; to_index(item) < size; item = ItemId{to_index(item) + 100})
    scene.set_placement(item, core::translation(point(random, 50.0)));
  followed.apply(*scene.commit());
  const std::vector<float> after = sizes();
  for (std::size_t i = 0; i < before.size(); ++i) EXPECT_LE(after[i], 1.11f * before[i]) << "block " << i;
  EXPECT_GE(followed.snapshot.size(), size + 150);
  EXPECT_EQ(followed.snapshot.disorder(), 2 * (followed.snapshot.size() - size));
}

/// Parts of a snapshot copied before edits and after: the copy is old in places, and catches up.
TEST(SnapshotEdits, CopiesInPiecesCatchUp) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = 50.0;
    EditedScene edited(seed, 500, half);
    pin_origin(edited.scene, half);
    ASSERT_TRUE(edited.scene.commit());
    Followed live{Snapshot(edited.scene)};
    core::ItemCopies items;
    std::vector<ItemId> missed;
    const auto edit = [&] {
      for (int i = whole(random, 0, 60); i > 0; --i) edited.edit(whole(random, 0, 5));
      const auto delta = edited.scene.commit();
      live.apply(*delta);
      for (const auto* list : {&delta->removed, &delta->changed, &delta->inserted})
        missed.insert(missed.end(), list->begin(), list->end());
    };
    for (std::size_t next = 0; next < live.snapshot.size();) {
      const std::size_t end = std::min(live.snapshot.size(), next + std::size_t(whole(random, 1, 300)));
      core::copy_items(live.snapshot, Slot(next), Slot(end), items);
      next = end;
      edit();
    }
    Followed landed(core::reordered(live.snapshot, std::move(items)));
    edit();
    std::sort(missed.begin(), missed.end());
    missed.erase(std::unique(missed.begin(), missed.end()), missed.end());
    core::ItemCopies late;
    core::copy_items(live.snapshot, missed, late);
    landed.culler.update(core::apply_copies(landed.snapshot, late));
    ASSERT_NO_FATAL_FAILURE(expect_same_boxes(landed.snapshot, live.snapshot));
    ASSERT_NO_FATAL_FAILURE(expect_same(landed, edited.scene, random, half));
  }
}

}  // namespace
}  // namespace sightline::tests::snapshot_edits_test
