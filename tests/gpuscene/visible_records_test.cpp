// What a visible set names, by batch, against a look at every slot.
#include "sightline/gpuscene/internal/visible_records.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace sightline::visible_records_test {
namespace {

using core::Slot;
using core::Snapshot;
using core::VisibleSet;
using gpuscene::BatchKind;
using gpuscene::GpuScene;
using gpuscene::VisibleRecords;
using Random = std::mt19937_64;

bool chance(Random& random, double probability) {
  return std::uniform_real_distribution<double>(0.0, 1.0)(random) < probability;
}

/// A row of items, each of a random one of `kinds` kinds.
core::Scene row(Random& random, std::size_t count, int kinds) {
  core::Mesh triangle;
  triangle.positions = {{0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0}};
  triangle.indices = {0, 1, 2};
  core::Mesh facets = triangle;
  facets.contour_sizes = {3};
  facets.polygon_contours = {1};
  core::Scene scene;
  const core::MeshId mesh = scene.add_mesh(triangle).value(), facet_group = scene.add_mesh(facets).value();
  for (std::size_t i = 0; i < count; ++i) {
    const core::Affine place = core::translation({double(i), 0.0, 0.0});
    switch (std::uniform_int_distribution<int>(0, kinds - 1)(random)) {
      case 0:
        scene.add_primitive(scene.root(), core::Cylinder{0.2f, 0.5f}, place);
        break;
      case 1:
        scene.add_primitive(scene.root(), core::Sphere{0.5f}, place);
        break;
      case 2:
        scene.add_primitive(scene.root(), core::SphericalDish{0.5f, 0.2f}, place);
        break;
      case 3:
        scene.add_mesh_instance(scene.root(), mesh, place);
        break;
      case 4:
        scene.add_mesh_instance(scene.root(), facet_group, place);
        break;
      default:
        scene.add_primitive(scene.root(), core::Line{-0.2f, 0.2f}, place);
    }
  }
  EXPECT_TRUE(scene.commit());
  return scene;
}

/// Hides items with a probability that changes every now and then.
void hide_some(Random& random, core::Scene& scene, Snapshot& snapshot) {
  double probability = 0.0;
  for (Slot slot = 0; slot < snapshot.size(); ++slot) {
    if (chance(random, 0.01)) probability = std::array{0.0, 0.02, 0.5, 0.95, 1.0}[std::size_t(random() % 5)];
    if (chance(random, probability)) scene.set_visible(snapshot.item(slot), false);
  }
  auto delta = scene.commit();
  ASSERT_TRUE(delta);
  snapshot.apply(*delta);
}

/// Disjoint ranges and single slots that are not vacant.
VisibleSet random_set(Random& random, const Snapshot& snapshot) {
  VisibleSet set;
  const Slot size = Slot(snapshot.size());
  for (Slot slot = 0; slot < size;) {
    const Slot count = std::min<Slot>(size - slot, Slot(1 + random() % (chance(random, 0.5) ? 20 : 2000)));
    const auto what = random() % 3;
    if (what == 0) set.ranges.push_back({slot, count});
    if (what == 1)
      for (Slot s = slot; s < slot + count; ++s)
        if (!snapshot.vacant(s) && chance(random, 0.3)) set.single_slots.push_back(s);
    slot += count;
  }
  return set;
}

/// Vacant slots on both sides of a slot, itself one: how long their run is within `set`'s range around it.
std::size_t vacant_run(const Snapshot& snapshot, const core::SlotRange& range, Slot slot) {
  Slot first = slot, end = slot + 1;
  while (first > range.first && snapshot.vacant(first - 1)) --first;
  while (end < range.first + range.count && snapshot.vacant(end)) ++end;
  return end - first;
}

void expect_same_as_slot_by_slot(const Snapshot& snapshot, const VisibleSet& set, const VisibleRecords& found) {
  std::array<std::vector<std::uint32_t>, gpuscene::kBatchKindCount> wanted, spare;
  std::vector<Slot> meshes;
  const auto want = [&](Slot slot) {
    const auto kind = gpuscene::batch_of(snapshot.kind(slot));
    if (kind == BatchKind::kMesh) meshes.push_back(slot);
    wanted[std::size_t(kind)].push_back(GpuScene::record_of(snapshot, slot));
  };
  for (const core::SlotRange& range : set.ranges)
    for (Slot slot = range.first; slot < range.first + range.count; ++slot) {
      if (!snapshot.vacant(slot)) {
        want(slot);
      } else if (vacant_run(snapshot, range, slot) <= gpuscene::kLongestGap) {
        spare[std::size_t(gpuscene::batch_of(snapshot.kind(slot)))].push_back(GpuScene::record_of(snapshot, slot));
      }
    }
  for (const Slot slot : set.single_slots) want(slot);
  EXPECT_EQ(found.meshes, meshes);
  for (int kind = 0; kind < int(BatchKind::kMesh); ++kind) {
    const auto& batch = found.batches[std::size_t(kind)];
    std::vector<std::uint32_t> records = batch.singles;
    for (const auto& run : batch.runs) {
      EXPECT_GE(run.count, gpuscene::kShortestRun);
      for (std::uint32_t i = 0; i < run.count; ++i) records.push_back(run.first + i);
    }
    std::sort(records.begin(), records.end());
    EXPECT_EQ(std::adjacent_find(records.begin(), records.end()), records.end()) << "a record twice, kind " << kind;
    std::vector<std::uint32_t> lost, extra, unasked;
    auto& all = wanted[std::size_t(kind)];
    std::sort(all.begin(), all.end());
    std::set_difference(all.begin(), all.end(), records.begin(), records.end(), std::back_inserter(lost));
    std::set_difference(records.begin(), records.end(), all.begin(), all.end(), std::back_inserter(extra));
    auto& allowed = spare[std::size_t(kind)];
    std::sort(allowed.begin(), allowed.end());
    std::set_difference(extra.begin(), extra.end(), allowed.begin(), allowed.end(), std::back_inserter(unasked));
    EXPECT_TRUE(lost.empty()) << lost.size() << " of kind " << kind;
    EXPECT_TRUE(unasked.empty()) << unasked.size() << " of kind " << kind;
  }
}

void expect_equal(const VisibleRecords& a, const VisibleRecords& b) {
  EXPECT_EQ(a.meshes, b.meshes);
  for (std::size_t kind = 0; kind < a.batches.size(); ++kind) {
    EXPECT_EQ(a.batches[kind].singles, b.batches[kind].singles);
    EXPECT_TRUE(std::ranges::equal(a.batches[kind].runs, b.batches[kind].runs, [](const auto& x, const auto& y) {
      return x.first == y.first && x.count == y.count;
    }));
  }
}

/// Whatever the number of threads.
TEST(VisibleRecords, AreThoseOfTheSet) {
  core::ThreadPool few(2), many(5);
  VisibleRecords shared;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    core::Scene scene = row(random, 1 + random() % (seed % 8 == 0 ? 40'000 : 6'000), 1 + int(seed % 6));
    Snapshot snapshot(scene);
    VisibleRecords found;
    for (int step = 0; step < 3; ++step) {
      const VisibleSet set = random_set(random, snapshot);
      found.assign(snapshot, set);
      expect_same_as_slot_by_slot(snapshot, set, found);
      for (core::ThreadPool* const threads : {&few, &many}) {
        shared.assign(snapshot, set, threads);
        expect_equal(shared, found);
      }
      hide_some(random, scene, snapshot);
    }
  }
}

TEST(VisibleRecords, OfARangeAreOneRunUntilMoreThanAFewAreVacant) {
  Random random(1);
  core::Scene scene = row(random, 1000, 1);
  Snapshot snapshot(scene);
  VisibleSet all;
  all.ranges.push_back({0, 1000});
  VisibleRecords found;
  const auto runs = [&] {
    found.assign(snapshot, all);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (const auto& run : found.batches[std::size_t(BatchKind::kCylinder)].runs)
      pairs.emplace_back(run.first, run.count);
    EXPECT_TRUE(found.batches[std::size_t(BatchKind::kCylinder)].singles.empty());
    return pairs;
  };
  const auto hide = [&](Slot first, Slot end) {
    for (Slot slot = first; slot < end; ++slot) scene.set_visible(snapshot.item(slot), false);
    snapshot.apply(*scene.commit());
  };
  using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  EXPECT_EQ(runs(), (Pairs{{0, 1000}}));
  hide(500, 500 + gpuscene::kLongestGap);
  EXPECT_EQ(runs(), (Pairs{{0, 1000}}));
  hide(500 + gpuscene::kLongestGap, 501 + gpuscene::kLongestGap);
  EXPECT_EQ(runs(), (Pairs{{0, 500}, {501 + gpuscene::kLongestGap, 499 - gpuscene::kLongestGap}}));
  hide(0, 100);
  hide(900, 1000);
  EXPECT_EQ(runs(), (Pairs{{100, 400}, {501 + gpuscene::kLongestGap, 399 - gpuscene::kLongestGap}}));
  hide(0, 1000);
  EXPECT_EQ(runs(), Pairs{});
}

TEST(VisibleRecords, ShortRunsAreSingleRecords) {
  Random random(1);
  core::Scene scene = row(random, 1000, 1);
  const Snapshot snapshot(scene);
  VisibleRecords found;
  const auto& cylinders = found.batches[std::size_t(BatchKind::kCylinder)];
  VisibleSet set;
  set.ranges = {{7, gpuscene::kShortestRun}};
  found.assign(snapshot, set);
  EXPECT_EQ(cylinders.runs.size(), 1u);
  EXPECT_TRUE(cylinders.singles.empty());
  set.ranges = {{7, gpuscene::kShortestRun - 1}};
  found.assign(snapshot, set);
  EXPECT_TRUE(cylinders.runs.empty());
  EXPECT_EQ(cylinders.singles.size(), gpuscene::kShortestRun - 1);
}

}  // namespace
}  // namespace sightline::visible_records_test
