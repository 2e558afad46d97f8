// Scenes page by page: every page is what the snapshot of the whole has there.
#include "sightline/importers/slc/paged_scene.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <set>
#include <thread>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "sightline/gpuprims/internal/joints.h"
#include "sightline/importers/import.h"
#include "sightline/importers/plant/plant_generator.h"
#include "sightline/importers/slc/internal/slc_rows.h"
#include "sightline/importers/slc/internal/slc_scene.h"
#include "sightline/importers/slc/internal/storage.h"
#include "sightline/lod/coarse_mesh.h"
#include "sightline/lod/stored_levels.h"
#include "sightline/tests/importers/scene_compare.h"
#include "sightline/tests/importers/slc_bytes.h"
#include "sightline/tests/support/counted_memory.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/links.h"
#include "sightline/tests/support/places.h"

namespace sightline::importers::paged_scene_test {
namespace {

namespace fs = std::filesystem;
using core::PagedScene;
using core::Scene;
using core::Slot;
using core::Snapshot;

class PagedSceneTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    const auto now = std::chrono::system_clock::now().time_since_epoch().count();
    folder_ = fs::path(testing::TempDir()) / ("sightline-paged-" + std::string(info->name()) + std::to_string(now));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static Scene plant(std::uint64_t items, std::uint64_t seed = 1) {
    Scene scene;
    EXPECT_TRUE(generate_plant({items, seed}, scene));
    return scene;
  }
  PagedScene paged(const Scene& scene, const char* name = "a.slc") const {
    EXPECT_TRUE(write_slc(scene, folder_ / name));
    auto opened = open_paged_scene(folder_ / name);
    EXPECT_TRUE(opened) << (opened ? "" : opened.error().message);
    return opened ? std::move(*opened) : PagedScene();
  }

  fs::path folder_;
};

void expect_same_slot(const Snapshot& page, Slot at, const Snapshot& whole, Slot slot) {
  ASSERT_EQ(page.item(at), whole.item(slot));
  ASSERT_EQ(page.kind(at), whole.kind(slot));
  EXPECT_EQ(page.vacant(at), whole.vacant(slot));
  EXPECT_EQ(page.bounds().box(at).min, whole.bounds().box(slot).min);
  EXPECT_EQ(page.bounds().box(at).max, whole.bounds().box(slot).max);
  EXPECT_EQ(page.bounds().layers(at), whole.bounds().layers(slot));
  EXPECT_EQ(page.material(at), whole.material(slot));
  const auto placement = [](const Snapshot& snapshot, Slot s) {
    return snapshot.of_kind(snapshot.kind(s)).placements[snapshot.index_in_kind(s)];
  };
  const core::Placement a = placement(page, at), b = placement(whole, slot);
  EXPECT_EQ(a.linear, b.linear);
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(page.chunk_origins()[a.chunk], whole.chunk_origins()[b.chunk]);
  if (int(page.kind(at)) >= core::kPrimitiveKindCount)
    EXPECT_TRUE(tests::same_mesh(page.mesh(at), whole.mesh(slot)));
  else
    EXPECT_TRUE(std::ranges::equal(core::parameters(page.primitive(at)), core::parameters(whole.primitive(slot))));
}

/// Against the scene that the file was read from into memory.
void expect_same(const PagedScene& paged, const Scene& scene) {
  const Snapshot whole(scene);
  const gpuprims::Joints joints(whole);
  EXPECT_EQ(paged.items, whole.size());
  EXPECT_EQ(paged.leaves.origin, whole.bounds().origin);
  const core::FittedBounds fitted = whole.bounds().fitted_bounds();
  EXPECT_EQ(paged.fitted.outliers, fitted.outliers);
  EXPECT_EQ(paged.fitted.bounds.empty(), fitted.bounds.empty());
  EXPECT_TRUE(fitted.bounds.empty() || paged.fitted.bounds.min == fitted.bounds.min);
  Slot slot = 0;
  for (std::uint32_t number = 0; number < paged.pages.size(); ++number) {
    const auto page = paged.load(number);
    ASSERT_TRUE(page) << page.error().message;
    const Snapshot& snapshot = (*page)->snapshot;
    const auto hidden = gpuprims::Joints::of_slots((*page)->internal_end_caps);
    ASSERT_EQ(snapshot.size(), paged.pages[number].slot_count);
    // However far apart the ids of its items are.
    EXPECT_EQ((*page)->internal_end_caps.size(), (snapshot.size() + 31) / 32);
    EXPECT_EQ(snapshot.materials(), whole.materials());
    EXPECT_EQ(snapshot.bounds().origin, whole.bounds().origin);
    EXPECT_EQ(paged.pages[number].first_leaf, slot / core::kBlockSlots);
    std::array<std::uint32_t, core::kKindCount> kinds{};
    std::size_t vacant = 0;
    for (Slot s = 0; s < snapshot.size(); ++s, ++slot) {
      expect_same_slot(snapshot, s, whole, slot);
      EXPECT_EQ(hidden.covered(snapshot, s), joints.covered(whole.item(slot)));
      EXPECT_EQ(snapshot.rank(snapshot.kind(s), s), kinds[std::size_t(snapshot.kind(s))]++);
      vacant += snapshot.vacant(s);
    }
    EXPECT_EQ(snapshot.vacant_count(), vacant);
    EXPECT_EQ(kinds, paged.pages[number].of_kind);
    // The promise that memory limits count on; unused mesh capacity and tables are small beside it.
    EXPECT_LE(snapshot.memory_bytes(), paged.pages[number].memory_bytes + 100'000);
    (*page)->drop_records();
    EXPECT_EQ(snapshot.size(), paged.pages[number].slot_count);
  }
  EXPECT_EQ(slot, whole.size());
}

/// A leaf's box is the union of its items' boxes; its flag says whether it has lines.
void expect_leaves_fit(const PagedScene& paged, const Scene& scene) {
  const Snapshot whole(scene);
  ASSERT_EQ(paged.leaves.size(), (whole.size() + core::kBlockSlots - 1) / core::kBlockSlots);
  ASSERT_EQ(paged.colours.size(), paged.leaves.size());
  for (std::size_t leaf = 0; leaf < paged.leaves.size(); ++leaf) {
    core::Aabb box;
    bool lines = false;
    for (Slot s = Slot(leaf * core::kBlockSlots);
         s < std::min<std::size_t>(whole.size(), (leaf + 1) * core::kBlockSlots); ++s) {
      if (whole.vacant(s)) continue;
      box.grow(whole.bounds().box(s));
      lines |= whole.kind(s) == core::Kind::kLine;
    }
    EXPECT_EQ(paged.leaves.box(leaf).empty(), box.empty());
    EXPECT_TRUE(box.empty() || paged.leaves.box(leaf).min == box.min);
    EXPECT_TRUE(box.empty() || paged.leaves.box(leaf).max == box.max);
    EXPECT_EQ((paged.colours[leaf] & PagedScene::kHasLines) != 0, lines);
  }
}

TEST_F(PagedSceneTest, PagesAreTheSnapshotOfTheWhole) {
  for (Scene& scene : std::array<Scene, 2>{tests::scene_with_everything(), plant(100'000)}) {
    const PagedScene opened = paged(scene);
    expect_same(opened, scene);
    expect_leaves_fit(opened, scene);
  }
}

/// Coarse pages hold the items by the coarsest of their meshes' levels.
TEST_F(PagedSceneTest, CoarsePagesHaveTheCoarsestLevels) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no levels in this build";
  const Scene scene = tests::scene_of_many_pages(600);
  EXPECT_FALSE(paged(scene).coarse);
  ASSERT_TRUE(write_slc(scene, folder_ / "levels.slc", {.levels = true}));
  const auto opened = open_paged_scene(folder_ / "levels.slc");
  ASSERT_TRUE(opened && opened->coarse);
  expect_same(*opened, scene);
  ASSERT_GT(opened->pages.size(), 3u);
  ASSERT_EQ(opened->coarse->pages.size(), opened->pages.size());
  std::size_t deviations = 0;
  for (std::uint32_t number = 0; number < opened->pages.size(); ++number) {
    const auto page = opened->load(number), coarse = opened->coarse->load(number);
    ASSERT_TRUE(page && coarse) << coarse.error().message;
    const Snapshot &all = (*page)->snapshot, &few = (*coarse)->snapshot;
    ASSERT_EQ(few.size(), all.size());
    EXPECT_EQ(opened->coarse->pages[number].slot_count, all.size());
    EXPECT_LT(opened->coarse->pages[number].memory_bytes, opened->pages[number].memory_bytes / 4);
    for (Slot slot = 0; slot < all.size(); ++slot) {
      ASSERT_EQ(few.item(slot), all.item(slot));
      EXPECT_EQ(few.world_from_item(slot).origin, all.world_from_item(slot).origin);
      if (all.kind(slot) != core::Kind::kMesh) continue;
      const core::Mesh& mesh = all.mesh(slot);
      const auto expected = lod::coarsest(mesh, lod::build_levels(mesh));
      EXPECT_EQ(few.mesh(slot).positions, expected.mesh.positions);
      EXPECT_EQ(few.mesh(slot).indices, expected.mesh.indices);
      const std::uint32_t own = few.of_kind(core::Kind::kMesh).meshes[few.index_in_kind(slot)];
      const auto found = (*coarse)->deviations_of(own);
      ASSERT_EQ(found.size(), expected.deviations.size());
      for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].error, expected.deviations[i].error);
      deviations += found.size();
    }
  }
  EXPECT_GT(deviations, 500u);
}

/// As the other arrays of a page.
TEST_F(PagedSceneTest, DamagedCoarsePagesAreFound) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no levels in this build";
  auto bytes = tests::slc_of(tests::scene_of_many_pages(150), true);
  const auto undamaged = *SlcFile::of_bytes(bytes);
  const auto sections = undamaged->sections();
  std::mt19937 random(6);
  const auto all_read = [&](bool verified) {
    const auto opened = open_paged_scene(*SlcFile::of_bytes(bytes), "levels.slc", verified);
    if (!opened || !opened->coarse) return false;
    bool good = true;
    for (std::uint32_t page = 0; page < opened->coarse->pages.size(); ++page) {
      const auto read = opened->coarse->load(page);
      good = good && read;
      if (!read) continue;
      for (std::uint32_t mesh = 0; mesh < (*read)->meshes.mesh_slots(); ++mesh) (void)(*read)->deviations_of(mesh);
    }
    return good;
  };
  ASSERT_TRUE(all_read(true));
  for (const SlcFile::Section& section : std::vector(sections.begin(), sections.end())) {
    if (section.number < kSlcCoarseMeshes || section.number > kSlcCoarsePages) continue;
    const std::uint64_t size = section.count * section.element_size;
    for (int round = 0; round < tests::repeated(60); ++round) {
      std::byte& byte = bytes[std::size_t(section.offset + random() % size)];
      const std::byte before = byte;
      byte ^= std::byte(1u << random() % 8);
      EXPECT_FALSE(all_read(true)) << section.number;
      (void)all_read(false);
      byte = before;
    }
  }
}

TEST_F(PagedSceneTest, BoxesOfLeavesAreInMemoryOnce) {
  ASSERT_TRUE(write_slc(plant(300'000), folder_ / "a.slc"));
  const std::size_t before = tests::live_bytes;
  const auto opened = open_paged_scene(folder_ / "a.slc");
  ASSERT_TRUE(opened) << opened.error().message;
  // The boxes are no vectors, and all else is small: operator new has given out less than they take.
  EXPECT_LT(tests::live_bytes - before, opened->leaves.memory_bytes() / 2);
}

TEST_F(PagedSceneTest, AnEmptySceneHasNoPages) {
  const PagedScene empty = paged(Scene());
  EXPECT_TRUE(empty.pages.empty());
  EXPECT_EQ(empty.leaves.size(), 0u);
}

TEST_F(PagedSceneTest, LargeMeshesMakeSmallPages) {
  Scene scene;
  for (int i = 0; i < 300; ++i) {
    core::Mesh mesh;
    for (int v = 0; v < 9000; ++v) {
      mesh.positions.push_back({float(v % 100), float(v / 100), float(i)});
      mesh.indices.push_back(std::uint32_t(v));
    }
    const auto id = *scene.add_mesh(std::move(mesh));
    const auto node = scene.add_node(scene.root(), "n", core::translation({i * 200.0, 0, 0}));
    scene.add_mesh_instance(node, id);
    scene.add_primitive(node, core::Box{1, 1, 1});
  }
  const PagedScene opened = paged(scene);
  EXPECT_GT(opened.pages.size(), 4u);
  for (const auto& page : opened.pages) EXPECT_LT(page.memory_bytes, std::size_t(20) << 20);
  expect_same(opened, scene);
}

TEST_F(PagedSceneTest, FoldersJoinTheirFiles) {
  const Scene a = plant(5000, 1), c = plant(40'000, 3);
  Scene b = plant(3000, 2);
  b.set_transform(b.first_child(b.root()), core::translation({1e5, -3e4, 7.0}));
  ASSERT_TRUE(write_slc(a, folder_ / "a.slc"));
  ASSERT_TRUE(write_slc(b, folder_ / "b.slc"));
  ASSERT_TRUE(write_slc(c, folder_ / "c.SLC"));
  std::ofstream(folder_ / "notes.txt") << "not a cache";
  const auto joined = open_paged_scene(folder_);
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_EQ(joined->items, 48'000u);
  std::set<core::ItemId> ids;
  const Scene* const scenes[] = {&a, &b, &c};
  const core::ItemId firsts[] = {core::ItemId{0}, core::ItemId{5000}, core::ItemId{8000}};
  for (std::uint32_t number = 0; number < joined->pages.size(); ++number) {
    const auto page = joined->load(number);
    ASSERT_TRUE(page) << page.error().message;
    const Snapshot& snapshot = (*page)->snapshot;
    for (Slot s = 0; s < snapshot.size(); ++s) {
      const core::ItemId id = snapshot.item(s);
      EXPECT_TRUE(ids.insert(id).second);
      const int part = to_index(id) < 5000 ? 0 : to_index(id) < 8000 ? 1 : 2;
      const auto world = scenes[part]->state(core::ItemId{to_index(id) - to_index(firsts[part])}).world_from_item;
      EXPECT_LT(glm::distance(snapshot.world_from_item(s).origin, world.origin), 1e-3);
      // Leaves hold what they should, from their own origin on, too.
      const core::Aabb own = snapshot.bounds().box(s);
      const auto leaf = joined->leaves.box(joined->pages[number].first_leaf + s / core::kBlockSlots);
      const core::dvec3 shift = snapshot.bounds().origin - joined->leaves.origin;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LE(double(leaf.min[axis]), double(own.min[axis]) + shift[axis]);
        EXPECT_GE(double(leaf.max[axis]), double(own.max[axis]) + shift[axis]);
      }
    }
  }
  EXPECT_EQ(ids.size(), 48'000u);
  EXPECT_EQ(to_index(*ids.rbegin()), 47'999u);
}

/// By several threads at once, as one does.
TEST_F(PagedSceneTest, AnyThreadMayReadPages) {
  ASSERT_TRUE(write_slc(plant(70'000), folder_ / "a.slc"));
  ASSERT_TRUE(write_slc(tests::scene_with_everything(), folder_ / "b.slc"));
  const auto opened = open_paged_scene(folder_);
  ASSERT_TRUE(opened) << opened.error().message;
  std::vector<std::unique_ptr<core::Page>> alone;
  for (std::uint32_t number = 0; number < opened->pages.size(); ++number) alone.push_back(*opened->load(number));
  ASSERT_GE(alone.size(), 4u);
  std::array<std::vector<std::unique_ptr<core::Page>>, 4> shared;
  {
    std::vector<std::jthread> threads;
    for (auto& pages : shared)
      threads.emplace_back([&] {
        for (std::uint32_t number = 0; number < opened->pages.size(); ++number) pages.push_back(*opened->load(number));
      });
  }
  std::set<std::uint64_t> generations;
  for (const auto& pages : shared)
    for (std::size_t number = 0; number < alone.size(); ++number) {
      EXPECT_TRUE(generations.insert(pages[number]->snapshot.generation()).second);
      EXPECT_EQ(pages[number]->internal_end_caps, alone[number]->internal_end_caps);
      for (Slot s = 0; s < alone[number]->snapshot.size(); s += 17)
        expect_same_slot(pages[number]->snapshot, s, alone[number]->snapshot, s);
    }
}

TEST_F(PagedSceneTest, FilesMayBeReplacedAndRemovedMeanwhile) {
  const PagedScene opened = paged(plant(3000, 1));
  const auto before = opened.load(0);
  ASSERT_TRUE(before);
  ASSERT_TRUE(write_slc(plant(2000, 2), folder_ / "a.slc"));
  const auto replaced = opened.load(0);
  fs::remove(folder_ / "a.slc");
  const auto removed = opened.load(0);
  ASSERT_TRUE(replaced && removed);
  for (Slot s = 0; s < (*before)->snapshot.size(); ++s) {
    expect_same_slot((*replaced)->snapshot, s, (*before)->snapshot, s);
    expect_same_slot((*removed)->snapshot, s, (*before)->snapshot, s);
  }
}

TEST_F(PagedSceneTest, BadInputIsToldWhere) {
  const auto message = [](const core::Expected<PagedScene>& opened) {
    return opened ? std::string() : opened.error().message;
  };
  EXPECT_NE(message(open_paged_scene(folder_)).find("expected .slc files"), std::string::npos);
  fs::create_directory(folder_ / "folder.slc");
  EXPECT_NE(message(open_paged_scene(folder_)).find("expected .slc files"), std::string::npos);
  const char* const reason = tests::names_ignore_case() ? "aaa: " : "too long";  // Windows has other words
  EXPECT_NE(message(open_paged_scene(folder_ / std::string(300, 'a'))).find(reason), std::string::npos);
  EXPECT_NE(message(open_paged_scene(folder_ / "none.slc")).find("none.slc: cannot open"), std::string::npos);
  std::ofstream(folder_ / "text.slc") << "this is no cache, but it is longer than a header and an end are together, as "
                                         "a text may be, or any file that has the wrong name";
  EXPECT_NE(message(open_paged_scene(folder_ / "text.slc")).find("text.slc: "), std::string::npos);
}

/// A part that cannot be read must not be missing in silence, nor hold up the others for ever.
TEST_F(PagedSceneTest, PartsThatAreNoFilesAreTold) {
  for (const char* name : {"a.slc", "c.slc", "d.slc"}) ASSERT_TRUE(write_slc(plant(1000), folder_ / name));
  ASSERT_TRUE(open_paged_scene(folder_));
  // The order in which a folder lists its entries is its own affair.
  for (const char* name : {"0.slc", "b.slc", "e.SLC"}) {
    if (!tests::make_link(folder_ / "gone.slc", folder_ / name)) break;
    const auto linked = open_paged_scene(folder_);
    ASSERT_FALSE(linked);
    EXPECT_NE(linked.error().message.find(std::string(name) + ": cannot open"), std::string::npos)
        << linked.error().message;
    fs::remove(folder_ / name);
  }
#if __has_include(<sys/mman.h>)
  ASSERT_EQ(mkfifo((folder_ / "b.slc").c_str(), 0600), 0);
  const auto piped = open_paged_scene(folder_);
  ASSERT_FALSE(piped);
  EXPECT_NE(piped.error().message.find("b.slc: not a regular file"), std::string::npos) << piped.error().message;
#endif
}

/// Limits on memory count on these numbers.
TEST_F(PagedSceneTest, PagesWithMoreValuesThanTheFileAreRefused) {
  (void)paged(tests::scene_with_everything());
  const std::vector<std::byte> whole = tests::bytes_of_file(folder_ / "a.slc");
  const std::size_t row = (*SlcFile::of_bytes(whole))->find(kSlcPages)->offset;
  for (const std::size_t field :
       {offsetof(SlcPage, mesh_positions), offsetof(SlcPage, mesh_indices), offsetof(SlcPage, mesh_bytes)})
    for (const std::uint64_t claim : {std::uint64_t(whole.size()), std::uint64_t(1) << 60, ~std::uint64_t(0)}) {
      std::vector<std::byte> bytes = whole;
      std::memcpy(bytes.data() + row + field, &claim, sizeof claim);
      EXPECT_FALSE(open_paged_scene(*SlcFile::of_bytes(bytes), "claim.slc", false)) << field << " " << claim;
    }
}

/// Every third byte of a small file, changed. What stays in memory is found at once, and pages when they are read; or
/// the byte belongs to what pages do not have, such as names.
TEST_F(PagedSceneTest, EveryChangedByteIsFoundOrDoesNotMatter) {
  Scene scene = tests::scene_with_everything();
  const PagedScene before = paged(scene);
  const auto good = before.load(0);
  ASSERT_TRUE(good) << good.error().message;
  std::vector<std::byte> bytes = tests::bytes_of_file(folder_ / "a.slc");
  std::size_t at_opening = 0, at_loading = 0;
  const std::size_t step = tests::long_run() ? 3 : 12;
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    bytes[at] ^= std::byte{0x20};
    const auto file = SlcFile::of_bytes(bytes);
    bytes[at] ^= std::byte{0x20};
    const auto opened = file ? open_paged_scene(*file, "changed.slc") : core::fail("");
    if (!opened) {
      ++at_opening;
      continue;
    }
    ASSERT_EQ(opened->pages.size(), 1u);
    const auto page = opened->load(0);
    if (!page) {
      ++at_loading;
      EXPECT_EQ(page.error().message.rfind("changed.slc: page 0: ", 0), 0u) << page.error().message;
      continue;
    }
    const Snapshot &a = (*page)->snapshot, &b = (*good)->snapshot;
    ASSERT_EQ(a.size(), b.size());
    for (Slot s = 0; s < a.size(); ++s) expect_same_slot(a, s, b, s);
    EXPECT_EQ((*page)->internal_end_caps, (*good)->internal_end_caps);
    ASSERT_FALSE(HasFailure()) << "byte " << at;
  }
  EXPECT_GT(at_opening, 450 / step);
  EXPECT_GT(at_loading, 9000 / step);
}

TEST_F(PagedSceneTest, FilesThatAreCutShortAreRefused) {
  (void)paged(tests::scene_with_everything());
  const std::vector<std::byte> bytes = tests::bytes_of_file(folder_ / "a.slc");
  for (std::size_t size = 0; size < bytes.size(); size += 7)
    EXPECT_FALSE(SlcFile::of_bytes(std::span(bytes).first(size))) << size;
  // Cut in place while it is open: the page is an error.
  const auto opened = open_paged_scene(folder_ / "a.slc");
  ASSERT_TRUE(opened);
  fs::resize_file(folder_ / "a.slc", 200);
  const auto page = opened->load(0);
  ASSERT_FALSE(page);
  EXPECT_NE(page.error().message.find("cut short"), std::string::npos) << page.error().message;
}

}  // namespace
}  // namespace sightline::importers::paged_scene_test
