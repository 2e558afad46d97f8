// Scene caches: what is written is what is read, and a cache never gives what its files would not.
#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>
#if __has_include(<sys/wait.h>)
#include <sys/wait.h>
#endif

#include "sightline/core/mesh_extras.h"
#include "sightline/core/snapshot.h"
#include "sightline/gpuprims/internal/joints.h"
#include "sightline/importers/obj/obj_writer.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/importers/rvm/rvm_writer.h"
#include "sightline/importers/slc/internal/slc_scene.h"
#include "sightline/importers/slc/internal/storage.h"
#include "sightline/lod/stored_levels.h"
#include "sightline/tests/importers/scene_compare.h"
#include "sightline/tests/importers/slc_bytes.h"
#include "sightline/tests/support/full_disk.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::importers::slc_test {
namespace {

namespace fs = std::filesystem;
using core::ItemId;
using core::Scene;
using core::Snapshot;

bool same_bytes(const auto& a, const auto& b) {
  return a.size() == b.size() &&
         (a.size() == 0 || std::memcmp(a.data(), b.data(), a.size() * sizeof(a.data()[0])) == 0);
}

void expect_same_snapshot(const Snapshot& a, const Snapshot& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a.bounds().origin, b.bounds().origin);
  EXPECT_EQ(a.bounds().extent().min, b.bounds().extent().min);
  EXPECT_EQ(a.bounds().extent().max, b.bounds().extent().max);
  EXPECT_EQ(a.bounds().uses_layers(), b.bounds().uses_layers());
  EXPECT_EQ(a.chunk_origins(), b.chunk_origins());
  EXPECT_EQ(a.vacant_count(), b.vacant_count());
  EXPECT_EQ(a.disorder(), b.disorder());
  EXPECT_EQ(a.materials(), b.materials());
  int arrays = 0;
  std::vector<std::vector<std::byte>> of_a;
  storage::for_each_snapshot_array(a, [&](std::uint64_t, const auto& array) {
    const auto bytes = std::as_bytes(std::span(array.data(), array.size()));
    of_a.emplace_back(bytes.begin(), bytes.end());
  });
  storage::for_each_snapshot_array(b, [&](std::uint64_t number, const auto& array) {
    EXPECT_TRUE(same_bytes(of_a[std::size_t(arrays++)], std::as_bytes(std::span(array.data(), array.size()))))
        << number;
  });
}

/// Bit for bit, with the same ids everywhere.
void expect_same(const Scene& a, const Scene& b) {
  EXPECT_EQ(tests::scene_difference(a, a.root(), b, b.root()), "");
  ASSERT_EQ(a.node_count(), b.node_count());
  ASSERT_EQ(a.item_slots(), b.item_slots());
  ASSERT_EQ(a.item_count(), b.item_count());
  ASSERT_EQ(a.mesh_slots(), b.mesh_slots());
  ASSERT_EQ(a.material_slots(), b.material_slots());
  for (ItemId i{0}; to_index(i) < a.item_slots(); ++i) {
    ASSERT_EQ(a.contains_item(i), b.contains_item(i)) << to_index(i);
    if (!a.contains_item(i)) continue;
    EXPECT_TRUE(tests::same_item(a, i, b, i)) << to_index(i);
    EXPECT_EQ(a.node_of(i), b.node_of(i)) << to_index(i);
    EXPECT_EQ(a.item_visible(i), b.item_visible(i)) << to_index(i);
  }
  for (std::size_t i = 0; i < a.mesh_slots(); ++i) {
    ASSERT_EQ(a.mesh_at(i).valid(), b.mesh_at(i).valid());
    if (!a.mesh_at(i).valid()) continue;
    EXPECT_TRUE(tests::same_mesh(a.mesh(a.mesh_at(i)), b.mesh(b.mesh_at(i))));
    EXPECT_EQ(a.mesh(a.mesh_at(i)).name, b.mesh(b.mesh_at(i)).name);
  }
  for (std::size_t i = 0; i < a.material_slots(); ++i)
    EXPECT_TRUE(tests::same_material(a, a.material_at(i), b, b.material_at(i)));
  a.for_each_node(a.root(), [&](core::NodeId node, auto&&...) {
    ASSERT_TRUE(b.contains(node));
    EXPECT_EQ(a.visible(node), b.visible(node));
  });
  expect_same_snapshot(Snapshot(a), Snapshot(b));
}

class SlcTest : public ::testing::Test {
 protected:
  void SetUp() override {
    static int count = 0;
    const auto now = std::chrono::system_clock::now().time_since_epoch().count();
    folder_ = fs::path(testing::TempDir()) / ("sightline-slc-" + std::to_string(now) + "-" + std::to_string(count++));
    fs::create_directories(folder_);
    options_.cache_folder = folder_ / "cache";
  }
  void TearDown() override {
    std::error_code ignored;
    fs::permissions(folder_, fs::perms::owner_all, ignored);
    fs::remove_all(folder_);
  }

  static Scene read(const fs::path& file) {
    Scene scene;
    const auto report = import_file(file, scene, scene.root());
    EXPECT_TRUE(report) << (report ? "" : report.error().message);
    return scene;
  }

  /// A plant as a file.
  fs::path plant(std::uint64_t items = 1500, const char* name = "plant.rvm", std::uint64_t seed = 1) const {
    Scene scene;
    PlantOptions config;
    config.items = items;
    config.seed = seed;
    const auto made = generate_plant(config, scene);
    EXPECT_TRUE(made) << (made ? "" : made.error().message);
    EXPECT_TRUE(write_rvm(scene, scene.root(), folder_ / name));
    return folder_ / name;
  }

  core::Expected<ImportReport> import(std::vector<fs::path> paths, Scene& scene) const {
    return import_files(paths, scene, scene.root(), options_);
  }
  /// Imports, expects what the files give without a cache, and tells whether the cache was read.
  bool was_cached(const std::vector<fs::path>& paths, std::size_t warnings = 0) const {
    Scene scene, plain;
    const auto report = import(paths, scene);
    EXPECT_TRUE(report) << (report ? "" : report.error().message);
    ImportOptions without = options_;
    without.cache_folder.clear();
    const auto twin = import_files(paths, plain, plain.root(), without);
    EXPECT_TRUE(twin) << (twin ? "" : twin.error().message);
    if (!report || !twin) return false;
    EXPECT_EQ(report->warnings.size(), twin->warnings.size() + warnings);
    EXPECT_EQ(report->items, twin->items);
    EXPECT_EQ(report->bytes, twin->bytes);
    EXPECT_EQ(report->attributed, twin->attributed);
    EXPECT_EQ(report->nodes.size(), twin->nodes.size());
    for (std::size_t i = 0; i < report->nodes.size(); ++i) EXPECT_EQ(report->nodes[i], twin->nodes[i]);
    expect_same(plain, scene);
    const auto committed = scene.commit(), plainly = plain.commit();
    EXPECT_TRUE(committed && plainly);
    // In the first start, too, it is read from what was written.
    EXPECT_EQ(core::Access::of(scene).stored_snapshot() != nullptr, caches_are_kept_);
    EXPECT_EQ(committed->inserted, plainly->inserted);
    EXPECT_EQ(committed->materials, plainly->materials);
    return report->from_cache;
  }
  std::vector<fs::path> caches() const {
    std::vector<fs::path> found;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(options_.cache_folder, none)) found.push_back(entry.path());
    return found;
  }

  fs::path folder_;
  ImportOptions options_;
  bool caches_are_kept_ = true;
};

TEST_F(SlcTest, EveryContentComesBackBitForBit) {
  const Scene scene = tests::scene_with_everything();
  ASSERT_TRUE(write_slc(scene, folder_ / "a.slc"));
  Scene again = read(folder_ / "a.slc");
  EXPECT_NE(core::Access::of(again).stored_snapshot(), nullptr);
  expect_same(scene, again);
  // And once more from what was read.
  ASSERT_TRUE(write_slc(again, folder_ / "b.slc"));
  expect_same(scene, read(folder_ / "b.slc"));
  EXPECT_EQ(tests::bytes_of_file(folder_ / "a.slc"), tests::bytes_of_file(folder_ / "b.slc"));
}

TEST_F(SlcTest, AnEmptySceneComesBack) {
  ASSERT_TRUE(write_slc(Scene(), folder_ / "empty.slc"));
  const Scene again = read(folder_ / "empty.slc");
  EXPECT_EQ(again.node_count(), 1u);
  EXPECT_EQ(Snapshot(again).size(), 0u);
}

TEST_F(SlcTest, ARootGivesItsChildrenWhatItHas) {
  Scene scene;
  scene.set_transform(scene.root(), core::translation({1e7, 2, 3}));
  scene.set_layers(scene.root(), core::kLayerInsulation);
  const auto node = scene.add_node(scene.root(), "a", core::translation({1, 0, 0}));
  scene.add_primitive(node, core::Box{1, 1, 1});
  ASSERT_TRUE(write_slc(scene, folder_ / "a.slc"));
  const Scene again = read(folder_ / "a.slc");
  EXPECT_EQ(again.world_from_node(again.first_child(again.root())).origin, core::dvec3(1e7 + 1, 2, 3));
  EXPECT_EQ(again.state(ItemId{0}).layers, core::kLayerInsulation);
  scene.add_primitive(scene.root(), core::Box{1, 1, 1});
  EXPECT_FALSE(write_slc(scene, folder_ / "a.slc"));
}

TEST_F(SlcTest, EditsOfWhatWasReadGiveTheSameAsEditsOfTheSource) {
  ASSERT_TRUE(write_slc(tests::scene_with_everything(), folder_ / "a.slc"));
  Scene source = tests::scene_with_everything(), cached = read(folder_ / "a.slc");
  const Scene copy = cached;
  const auto edit = [](Scene& scene) {
    const auto top = scene.first_child(scene.root());
    const auto child = scene.first_child(top);
    EXPECT_TRUE(scene.commit());
    Snapshot snapshot(scene);
    scene.set_transform(child, core::translation({5, 6, 7}));
    scene.set_name(child, "a longer name than the one that it had before");
    scene.set_attribute(child, "Tag", "new");
    scene.remove_item(ItemId{0});
    const auto added = scene.add_node(top, "added");
    scene.add_primitive(added, core::Cylinder{1, 2});
    for (core::NodeId n = scene.next_sibling(child); n.valid() && scene.name(n) != "added";) {
      const auto next = scene.next_sibling(n);
      scene.remove_node(n);  // with its attributes, and the next node gets its place
      EXPECT_TRUE(scene.attributes(scene.add_node(added, "again")).empty());
      n = next;
    }
    const auto delta = scene.commit();
    EXPECT_TRUE(delta);
    snapshot.apply(*delta);
    return snapshot;
  };
  const Snapshot a = edit(source), b = edit(cached);
  expect_same_snapshot(a, b);
  expect_same(source, cached);
  expect_same(tests::scene_with_everything(), copy);
}

TEST_F(SlcTest, SnapshotsOfOneSceneDoNotShareTheirMemory) {
  ASSERT_TRUE(write_slc(tests::scene_with_everything(), folder_ / "a.slc"));
  const Scene scene = read(folder_ / "a.slc");
  Snapshot first(scene);
  const Snapshot second(scene);
  const core::Slot slots[] = {0, 1, 2, 3};
  first.hide(slots);
  expect_same_snapshot(second, Snapshot(tests::scene_with_everything()));
}

TEST_F(SlcTest, InternalEndCapsAreThoseThatWouldBeFound) {
  const fs::path model = plant();
  const Scene source = read(model);
  ASSERT_TRUE(write_slc(source, folder_ / "a.slc"));
  Scene cached = read(folder_ / "a.slc");
  const auto expect_same_ends = [&](const Snapshot& snapshot, const gpuprims::Joints& found) {
    const gpuprims::Joints joints(snapshot);
    EXPECT_EQ(joints.count(), found.count());
    for (ItemId item{0}; to_index(item) < cached.item_slots(); ++item)
      ASSERT_EQ(joints.covered(item), found.covered(item)) << to_index(item);
  };
  Snapshot snapshot(cached);
  ASSERT_NE(gpuprims::stored_joints(snapshot), nullptr);
  const gpuprims::Joints found{Snapshot(source)};
  EXPECT_GT(found.count(), 100u);
  expect_same_ends(snapshot, found);
  // Not those of a snapshot that was changed since, or of materials that were.
  const core::Slot slots[] = {0, 1, 2};
  snapshot.hide(slots);
  EXPECT_EQ(gpuprims::stored_joints(snapshot), nullptr);
  for (std::size_t i = 0; i < cached.material_slots(); ++i) {
    core::Material glass = cached.material(cached.material_at(i));
    glass.alpha = 0.5f;
    cached.update_material(cached.material_at(i), glass);
  }
  const Snapshot changed(cached);
  Scene twin = read(model);
  for (std::size_t i = 0; i < twin.material_slots(); ++i)
    twin.update_material(twin.material_at(i), cached.material(cached.material_at(i)));
  expect_same_ends(changed, gpuprims::Joints{Snapshot(twin)});
}

TEST_F(SlcTest, ThreadsMayReadAttributesAtOnce) {
  ASSERT_TRUE(write_slc(tests::scene_with_everything(), folder_ / "a.slc"));
  const Scene scene = read(folder_ / "a.slc"), twin = tests::scene_with_everything();
  std::atomic<int> wrong{0};
  {
    std::vector<std::jthread> readers;
    for (int t = 0; t < 4; ++t)
      readers.emplace_back([&] {
        scene.for_each_node(scene.root(), [&](core::NodeId node, auto&&...) {
          wrong += scene.attributes(node) != twin.attributes(node) || scene.name(node) != twin.name(node);
        });
      });
  }
  EXPECT_EQ(wrong, 0);
}

TEST_F(SlcTest, ItemsThatAParentMovesOutOfReachAreDropped) {
  ASSERT_TRUE(write_slc(tests::scene_with_everything(), folder_ / "a.slc"));
  Scene scene;
  core::Affine huge;
  huge.linear *= 1e36;
  const auto parent = scene.add_node(scene.root(), "far", huge);
  const auto report = import_file(folder_ / "a.slc", scene, parent);
  ASSERT_TRUE(report);
  EXPECT_FALSE(report->warnings.empty());
  EXPECT_TRUE(scene.commit());
}

/// Levels of a scene's meshes as bytes; empty where a mesh came without.
std::vector<std::vector<std::byte>> levels_of(const Scene& scene) {
  std::vector<std::vector<std::byte>> all;
  for (std::uint32_t i = 0; i < scene.mesh_slots(); ++i) {
    all.emplace_back();
    const core::MeshId id = scene.mesh_at(i);
    if (!id.valid() || !core::bytes_stored_with(scene.mesh(id))) continue;
    auto bytes = core::bytes_stored_with(scene.mesh(id))->bytes();
    EXPECT_TRUE(bytes) << bytes.error().message;
    if (bytes) all.back() = std::move(*bytes);
  }
  return all;
}

/// What is to be found in a file with levels.
std::vector<std::vector<std::byte>> built_levels(const Scene& scene) {
  std::vector<std::vector<std::byte>> all(scene.mesh_slots());
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    const core::MeshId id = scene.mesh_at(i);
    if (!id.valid()) continue;
    if (const auto built = lod::build_levels(scene.mesh(id)); !built.empty()) all[i] = lod::encode(built);
  }
  return all;
}

TEST_F(SlcTest, LevelsComeWithTheirMeshes) {
  const Scene scene = tests::scene_with_levels();
  ASSERT_TRUE(write_slc(scene, folder_ / "plain.slc"));
  const Scene plain = read(folder_ / "plain.slc");
  EXPECT_EQ(levels_of(plain), std::vector<std::vector<std::byte>>(scene.mesh_slots()));
  const auto written = write_slc(scene, folder_ / "a.slc", {.levels = true});
  ASSERT_EQ(bool(written), lod::builds_levels());
  if (!written) return;
  const Scene again = read(folder_ / "a.slc");
  expect_same(plain, again);
  EXPECT_EQ(levels_of(again), built_levels(scene));
  // They stay with their meshes, wherever these go.
  ASSERT_TRUE(write_slc(again, folder_ / "b.slc"));
  EXPECT_EQ(tests::bytes_of_file(folder_ / "b.slc"), tests::bytes_of_file(folder_ / "a.slc"));
  Scene both;
  for (const char* name : {"plain.slc", "b.slc"}) ASSERT_TRUE(import_file(folder_ / name, both, both.root()));
  auto joined = levels_of(plain);
  for (auto& levels : levels_of(again)) joined.push_back(std::move(levels));
  EXPECT_EQ(levels_of(both), joined);
  const Snapshot snapshot(both);
  std::size_t with = 0;
  for (const core::Slot slot : snapshot.of_kind(core::Kind::kMesh).members)
    with += core::bytes_stored_with(snapshot.mesh(slot)) != nullptr;
  EXPECT_EQ(with, 6u);
}

/// Surfaces of a scene's meshes as bytes; empty where a mesh has none.
std::vector<std::vector<std::byte>> surfaces_of(const Scene& scene) {
  std::vector<std::vector<std::byte>> all;
  for (std::uint32_t i = 0; i < scene.mesh_slots(); ++i) {
    const core::MeshId id = scene.mesh_at(i);
    const auto bytes =
        std::as_bytes(id.valid() ? core::surfaces_stored_with(scene.mesh(id)) : std::span<const core::MeshSurface>());
    all.emplace_back(bytes.begin(), bytes.end());
  }
  return all;
}

/// A file of meshes without surfaces is what it was before there were any.
TEST_F(SlcTest, SurfacesComeWithTheirMeshes) {
  const Scene scene = tests::scene_with_surfaces();
  const auto surfaces = surfaces_of(scene);
  EXPECT_EQ(surfaces.back().size(), 2 * sizeof(core::MeshSurface));
  ASSERT_TRUE(write_slc(scene, folder_ / "a.slc"));
  const Scene again = read(folder_ / "a.slc");
  EXPECT_EQ(surfaces_of(again), surfaces);
  ASSERT_TRUE(write_slc(again, folder_ / "b.slc", {.levels = lod::builds_levels()}));
  const Scene with_levels = read(folder_ / "b.slc"), copy = again;
  EXPECT_EQ(surfaces_of(with_levels), surfaces);
  EXPECT_EQ(surfaces_of(copy), surfaces);
  Scene moved;
  const core::NodeId parent = moved.add_node(moved.root(), "moved", core::translation({1, 2, 3}));
  ASSERT_TRUE(import_file(folder_ / "a.slc", moved, parent));
  EXPECT_EQ(surfaces_of(moved), surfaces);
  const auto plain = SlcFile::of_bytes(tests::slc_of(tests::scene_with_everything()));
  EXPECT_EQ((*plain)->find(kSlcSurfaces), nullptr);
  EXPECT_EQ((*plain)->find(kSlcSurfaceEnds), nullptr);
}

TEST_F(SlcTest, LevelsOfAnotherVersionAreNotUsed) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no levels in this build";
  auto bytes = tests::slc_of(tests::scene_with_levels(), true);
  const auto whole = SlcFile::of_bytes(bytes);
  ASSERT_TRUE(whole);
  EXPECT_TRUE(load(*whole)->has_levels);
  bytes[(*whole)->find(kSlcLevelsVersion)->offset] ^= std::byte{64};
  const auto loaded = load(*SlcFile::of_bytes(bytes), false);
  ASSERT_TRUE(loaded);
  EXPECT_FALSE(loaded->has_levels);
  EXPECT_EQ(levels_of(loaded->scene), std::vector<std::vector<std::byte>>(loaded->scene.mesh_slots()));
}

TEST_F(SlcTest, CachesGetLevelsWhereTheyAreAskedFor) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no levels in this build";
  Scene scene;
  const auto torus = scene.add_mesh(tests::bumpy_torus(20, 0.1)).value();
  scene.add_mesh_instance(scene.add_node(scene.root(), "torus"), torus);
  ASSERT_TRUE(scene.commit());
  const fs::path model = folder_ / "torus.obj";
  ASSERT_TRUE(write_obj(scene, scene.root(), model));
  const auto with_levels = [&] {
    Scene made;
    const auto report = import({model}, made);
    EXPECT_TRUE(report) << (report ? "" : report.error().message);
    return levels_of(made) == built_levels(made);
  };
  EXPECT_FALSE(was_cached({model}));
  EXPECT_FALSE(with_levels());
  options_.cached_levels = true;
  EXPECT_TRUE(was_cached({model})) << "the cache gets levels";
  const auto bytes = tests::bytes_of_file(caches().at(0));
  EXPECT_TRUE(with_levels());
  options_.cached_levels = false;
  EXPECT_TRUE(with_levels()) << "those that there are are used";
  EXPECT_EQ(tests::bytes_of_file(caches().at(0)), bytes);
  fs::remove(caches().at(0));
  options_.cached_levels = true;
  // Who cancels while levels are built still has a cache.
  double told = 0.0;
  options_.progress = [&](double share) { return (told = share) < 0.21; };
  Scene none;
  EXPECT_EQ(import({model}, none).error().message, kCancelled);
  EXPECT_LT(told, 1.0);
  options_.progress = {};
  options_.cached_levels = false;
  EXPECT_TRUE(was_cached({model}));
  EXPECT_FALSE(with_levels());
  fs::remove(caches().at(0));
  options_.cached_levels = true;
  EXPECT_FALSE(was_cached({model}));
  EXPECT_EQ(tests::bytes_of_file(caches().at(0)), bytes);
  EXPECT_TRUE(with_levels());
}

TEST_F(SlcTest, ASecondImportReadsTheCache) {
  const fs::path model = plant();
  EXPECT_FALSE(was_cached({model}));
  EXPECT_EQ(caches().size(), 1u);
  EXPECT_TRUE(was_cached({model}));
  // Below another node of a scene that holds something.
  Scene scene;
  scene.add_primitive(scene.add_node(scene.root(), "kept"), core::Sphere{1});
  const auto parent = scene.add_node(scene.root(), "parent");
  const auto report = import_files(std::span(&model, 1), scene, parent, options_);
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->from_cache);
  EXPECT_EQ(scene.parent(report->nodes.at(0)), parent);
  const Scene plain = read(model);
  scene.set_name(report->nodes[0], "another");  // nodes below tops of the same name are compared by their paths
  EXPECT_EQ(tests::scene_difference(plain, plain.first_child(plain.root()), scene, report->nodes[0]), "");
  // A moved parent bypasses it.
  const auto moved = scene.add_node(scene.root(), "moved", core::translation({1, 2, 3}));
  EXPECT_FALSE(import_files(std::span(&model, 1), scene, moved, options_)->from_cache);
}

TEST_F(SlcTest, ChangesOfTheSourcesAreFound) {
  const fs::path model = plant();
  EXPECT_FALSE(was_cached({model}));
  // Another content, and the same with another time.
  const auto time = fs::last_write_time(model);
  plant(1200);
  fs::last_write_time(model, time);
  EXPECT_FALSE(was_cached({model}));
  EXPECT_TRUE(was_cached({model}));
  fs::last_write_time(model, fs::last_write_time(model) + std::chrono::hours(5));
  EXPECT_TRUE(was_cached({model}));
  // A file of equal size, with another content and time.
  auto bytes = tests::bytes_of_file(model);
  const char name[] = "SITE";
  const auto at =
      std::search(bytes.begin(), bytes.end(), name, name + 4, [](std::byte x, char c) { return char(x) == c; });
  ASSERT_NE(at, bytes.end());
  *at = std::byte{'s'};
  tests::write_bytes(model, bytes);
  fs::last_write_time(model, time + std::chrono::seconds(1));
  EXPECT_FALSE(was_cached({model}));
  // Other options, other files.
  plant(1200);
  EXPECT_FALSE(was_cached({model}));
  options_.copies = MeshCopies::kApart;
  EXPECT_FALSE(was_cached({model}));
  const fs::path second = plant(1000, "second.rvm", 2);
  EXPECT_FALSE(was_cached({model, second}));
  EXPECT_TRUE(was_cached({model, second}));
  EXPECT_FALSE(was_cached({second, model}));
}

TEST_F(SlcTest, AttributesBelongToTheCache) {
  const fs::path model = plant();
  const std::string group = "SITE";
  const fs::path attributes = folder_ / "plant.txt";
  constexpr const char* kHeader = "CADC_Attributes_File v1.0 , start: NEW , end: END , name_end: := , sep: &end&\n";
  std::ofstream(attributes) << kHeader << "NEW " << group << "\nType:= VALVE\nEND\n";
  const bool first = was_cached({model, attributes});
  EXPECT_FALSE(first);
  EXPECT_TRUE(was_cached({model, attributes}));
  std::ofstream(attributes) << kHeader << "NEW " << group << "\nType:= PIPE !\nEND\n";
  EXPECT_FALSE(was_cached({model, attributes}));
}

TEST_F(SlcTest, SideFilesBelongToTheSources) {
  std::ofstream(folder_ / "a.obj") << "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
  const fs::path model = folder_ / "a.obj";
  Scene probe;
  if (!import_file(model, probe, probe.root(), {.lenient = true})) GTEST_SKIP() << "no OBJ in this build";
  options_.lenient = true;
  EXPECT_FALSE(was_cached({model}));
  EXPECT_TRUE(was_cached({model}));
  std::ofstream(folder_ / "a.mtl") << "newmtl m\nKd 1 0 0\n";  // was missing before
  EXPECT_FALSE(was_cached({model}));
  EXPECT_TRUE(was_cached({model}));
  std::ofstream(folder_ / "a.mtl") << "newmtl m\nKd 0 1 0\n";
  fs::last_write_time(folder_ / "a.mtl", fs::last_write_time(folder_ / "a.mtl") + std::chrono::seconds(2));
  EXPECT_FALSE(was_cached({model}));
}

TEST_F(SlcTest, DamagedCachesAreMadeAnewWithAWarning) {
  const fs::path model = plant(1000);
  ASSERT_FALSE(was_cached({model}));
  const fs::path cache = caches().at(0);
  const auto whole = tests::bytes_of_file(cache);
  const auto damage = [&](std::vector<std::byte> bytes) {
    tests::write_bytes(cache, bytes);
    Scene scene;
    const auto report = import({model}, scene);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_FALSE(report->from_cache);
    ASSERT_EQ(report->warnings.size(), 1u);
    EXPECT_NE(report->warnings[0].message.find("scene cache made anew"), std::string::npos);
    expect_same(read(model), scene);
    EXPECT_EQ(tests::bytes_of_file(cache), whole);
  };
  for (std::size_t at = 3; at < whole.size(); at += whole.size() / 60) {
    auto bytes = whole;
    bytes[at] ^= std::byte{4};
    damage(bytes);
    damage({whole.begin(), whole.begin() + std::ptrdiff_t(at)});
  }
  damage({});
  damage(std::vector<std::byte>(whole.size()));
  EXPECT_TRUE(was_cached({model}));
  // Another version is no damage.
  auto bytes = whole;
  bytes[8] = std::byte{99};
  tests::reseal(bytes);
  tests::write_bytes(cache, bytes);
  EXPECT_FALSE(was_cached({model}));
  EXPECT_TRUE(was_cached({model}));
}

TEST_F(SlcTest, WhereNothingCanBeWrittenTheImportGoesOn) {
  const fs::path model = plant(1000);
  std::ofstream(folder_ / "file") << "no folder";
  options_.cache_folder = folder_ / "file";
  caches_are_kept_ = false;
  EXPECT_FALSE(was_cached({model}, 1));
#if __has_include(<sys/resource.h>)
  if (geteuid() == 0) return;  // root may write anywhere
  options_.cache_folder = folder_ / "read-only";
  fs::create_directories(options_.cache_folder);
  fs::permissions(options_.cache_folder, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_FALSE(was_cached({model}, 1));
  fs::permissions(options_.cache_folder, fs::perms::owner_all);
#endif
}

TEST_F(SlcTest, ACacheCannotBeADirectory) {
  const fs::path model = plant(1000);
  ASSERT_FALSE(was_cached({model}));
  const fs::path cache = caches().at(0);
  fs::remove(cache);
  fs::create_directory(cache);
  caches_are_kept_ = false;
  EXPECT_FALSE(was_cached({model}, 2));  // it is no file, and none can be written
}

#ifdef SIGHTLINE_HAS_FULL_DISK
TEST_F(SlcTest, AFullDiskLeavesTheOldCache) {
  const fs::path model = plant(1000);
  ASSERT_FALSE(was_cached({model}));
  const fs::path cache = caches().at(0);
  const auto old = tests::bytes_of_file(cache);
  plant(3000);
  caches_are_kept_ = false;
  {
    const tests::FullDisk full(20'000);
    EXPECT_FALSE(was_cached({model}, 1));
  }
  caches_are_kept_ = true;
  EXPECT_EQ(tests::bytes_of_file(cache), old);
  EXPECT_EQ(caches().size(), 1u);
  EXPECT_FALSE(was_cached({model}));
  EXPECT_TRUE(was_cached({model}));
}

TEST_F(SlcTest, AnEndInTheMiddleOfWritingLeavesTheOldCache) {
  const fs::path model = plant(1000);
  ASSERT_FALSE(was_cached({model}));
  const auto old = tests::bytes_of_file(caches().at(0));
  plant(3000);
  const pid_t child = fork();
  if (child == 0) {
    rlimit limit{20'000, 20'000};
    (void)setrlimit(RLIMIT_FSIZE, &limit);
    (void)std::signal(SIGXFSZ, SIG_DFL);  // ends the process in the middle
    const rlimit no_core{0, 0};
    (void)setrlimit(RLIMIT_CORE, &no_core);
    Scene scene;
    (void)import({model}, scene);
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status));
  std::vector<fs::path> left;
  for (const fs::path& path : caches())
    if (path.extension() == ".part")
      left.push_back(path);
    else
      EXPECT_EQ(tests::bytes_of_file(path), old);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_FALSE(was_cached({model}));
  EXPECT_TRUE(fs::exists(left[0]));  // it might still be being written
  fs::last_write_time(left[0], fs::file_time_type::clock::now() - std::chrono::hours(2));
  plant(1200);
  EXPECT_FALSE(was_cached({model}));
  EXPECT_FALSE(fs::exists(left[0]));
}

TEST_F(SlcTest, ProcessesMayWriteAndReadAtOnce) {
  const fs::path model = plant(2000);
  std::vector<pid_t> children;
  for (int i = 0; i < 4; ++i) {
    const pid_t child = fork();
    if (child == 0) {
      int wrong = 0;
      for (int round = 0; round < 5; ++round) {
        Scene scene;
        const auto report = import({model}, scene);
        wrong += !report || !report->warnings.empty() || scene.item_count() != 2000;
        if (round % 2 == 1)
          for (const fs::path& cache : caches())
            if (std::error_code ignored; cache.extension() == ".slc") fs::remove(cache, ignored);
      }
      _exit(wrong == 0 ? 0 : 1);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  }
  (void)was_cached({model});
  EXPECT_TRUE(was_cached({model}));
}
#endif

TEST_F(SlcTest, ReplacingAFileLeavesItsReadersAlone) {
  ASSERT_TRUE(write_slc(tests::scene_with_everything(), folder_ / "a.slc"));
  const Scene scene = read(folder_ / "a.slc");
  Scene other;
  other.add_primitive(other.add_node(other.root(), "other"), core::Sphere{1});
  ASSERT_TRUE(write_slc(other, folder_ / "a.slc"));
  expect_same(tests::scene_with_everything(), scene);
  expect_same(other, read(folder_ / "a.slc"));
}

TEST_F(SlcTest, ACancelledImportLeavesTheSceneAsItWas) {
  const fs::path model = plant();
  ASSERT_FALSE(was_cached({model}));
  options_.progress = [](double) { return false; };
  Scene scene;
  const auto report = import({model}, scene);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, kCancelled);
  EXPECT_EQ(scene.node_count(), 1u);
  EXPECT_EQ(write_slc(read(model), folder_ / "b.slc", {.progress = [](double) { return false; }}).error().message,
            kCancelled);
  EXPECT_FALSE(fs::exists(folder_ / "b.slc"));
}

}  // namespace
}  // namespace sightline::importers::slc_test
