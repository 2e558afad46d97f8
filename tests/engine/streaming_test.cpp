// Meshes and kinds of items that come and go while an engine draws: the image is that of an engine made for the
// purpose, and memory does not grow.
#include <map>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/engine/internal/engine_parts.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/engine/drawn_grid.h"

namespace sightline::tests::streaming_test {
namespace {

using engine::CullerChoice;
using engine::Engine;

class StreamingTest : public DrawnGrid {
 protected:
  core::Affine somewhere() {
    std::uniform_real_distribution<double> place(0.0, 22.0);
    const double x = place(random), y = place(random);
    return core::translation({x, y, place(random)});
  }
  /// A mesh that no other item has.
  void add_mesh(core::Scene& scene) {
    core::Mesh lump = gpuprims::tessellate(core::Sphere{0.8f}, {.fixed_segments = 3 + int(random() % 9)});
    if (random() % 3 == 0) lump.normals.clear();
    const core::MeshId mesh = scene.add_mesh(std::move(lump)).value();
    items.push_back(scene.add_mesh_instance(scene.root(), mesh, somewhere()));
    if (random() % 4 == 0) scene.add_mesh_instance(scene.root(), mesh, somewhere());  // which stays
  }
  void remove(core::Scene& scene, std::size_t count) {
    for (; count > 0 && !items.empty(); --count) {
      std::swap(items[random() % items.size()], items.back());
      scene.remove_item(items.back());
      items.pop_back();
    }
  }

  /// Ghosts, faint ones, and one with an outline, among those that stay.
  static bool set_styles(Engine& engine) {
    std::vector<core::ItemId> ghosts, faint;
    for (core::ItemId item{0}; to_index(item) < 4000; item = core::ItemId{to_index(item) + 2})
      (to_index(item) % 3 == 0 ? ghosts : faint).push_back(item);
    return engine.set_override(ghosts, {.ghost = true}) && engine.set_override(faint, {.alpha = 0.5f}) &&
           engine.set_override({&faint[3], 1}, {.outline = true});
  }

  /// Removes some items with their meshes, and adds others.
  void exchange_items(core::Scene& scene, std::span<const core::Primitive> shapes, std::map<core::ItemId, bool>& of) {
    while (items.size() > 120) {
      std::swap(items[random() % items.size()], items.back());
      const bool has_mesh = int(scene.kind(items.back())) >= core::kPrimitiveKindCount;
      const core::MeshId mesh = has_mesh ? scene.mesh_of(items.back()) : core::MeshId();
      of.erase(items.back());
      scene.remove_item(items.back());
      items.pop_back();
      if (has_mesh) scene.remove_mesh(mesh);
    }
    const core::NodeId node = scene.add_node(scene.root());
    for (int i = 0; i < 6; ++i) {
      if (random() % 2) {
        core::Mesh lump = gpuprims::tessellate(core::Sphere{0.9f}, {.fixed_segments = 3 + int(random() % 9)});
        const core::MeshId mesh = scene.add_mesh(std::move(lump)).value();
        items.push_back(scene.add_mesh_instance(node, mesh, somewhere()));
      } else {
        items.push_back(scene.add_primitive(node, shapes[random() % shapes.size()], somewhere()));
      }
    }
  }

  /// That a plan says are used.
  static std::vector<std::string> programs(const engine::Plan& plan) {
    std::vector<std::string> used;
    for (const engine::PlanEntry& entry : plan.entries)
      if (entry.used && entry.feature.find(" program") != std::string::npos)
        used.push_back(entry.feature + ": " + entry.why);
    return used;
  }

  static inline const engine::ItemStyle kRed{.colour = core::vec3(1.0f, 0.0f, 0.0f)};
  static inline const engine::ItemStyle kBlue{.colour = core::vec3(0.0f, 0.0f, 1.0f)};
  std::mt19937 random{11};
  std::vector<core::ItemId> items;
};

TEST_F(StreamingTest, MeshesThatComeAndGoShowAsIfBuiltAnew) {
  SCOPED_TRACE("seed 11");
  for (const auto culler : {CullerChoice::kCpu, CullerChoice::kGpu, CullerChoice::kHybrid}) {
    core::Scene scene;
    fill(scene, 22);
    for (int i = 0; i < 50; ++i) add_mesh(scene);
    engine::EngineConfig c = config(culler);
    c.culling.rebuild_share = 0.0;
    auto streamed = Engine::create(scene, c);
    ASSERT_TRUE(streamed);
    for (int round = 0; round < 8; ++round) {
      for (int i = 0; i < 40; ++i) add_mesh(scene);
      remove(scene, 35);
      ASSERT_TRUE(streamed->commit());
      ASSERT_TRUE(streamed->frame(view(0.3 * round)));
      if (round % 3 != 1) continue;
      auto anew = Engine::create(scene, c);
      ASSERT_TRUE(anew && anew->frame(view(0.3 * round)));
      ASSERT_NO_FATAL_FAILURE(expect_same_image(*streamed, *anew, 1));
    }
    items.clear();
  }
}

/// Each kind has programs, draw lists and bounds of its own.
TEST_F(StreamingTest, KindsMayComeIntoAnEmptyScene) {
  const core::Primitive kinds[] = {core::Cylinder{0.5f, 1.0f}, core::Box{1.0f, 1.0f, 1.0f}, core::Sphere{0.6f},
                                   core::CircularTorus{1.0f, 0.3f, 1.5f}, core::Line{-0.5f, 0.5f}};
  for (const auto culler : {CullerChoice::kCpu, CullerChoice::kGpu}) {
    core::Scene scene;
    engine::EngineConfig c = config(culler);
    c.culling.rebuild_share = 0.0;
    auto streamed = Engine::create(scene, c);
    ASSERT_TRUE(streamed);
    for (std::size_t kind = 0; kind <= std::size(kinds); ++kind) {
      SCOPED_TRACE(kind);
      for (int i = 0; i < 30; ++i)
        if (kind == 2)
          add_mesh(scene);
        else
          scene.add_primitive(scene.root(), kinds[kind < 2 ? kind : kind - 1], somewhere());
      ASSERT_TRUE(streamed->commit());
      core::View eye = view(0.4);
      if (kind % 2 == 1) eye.sections = {{{0.1, 0.2, -1.0}, 12.0}};
      auto anew = Engine::create(scene, c);
      ASSERT_TRUE(anew && streamed->frame(eye) && anew->frame(eye));
      ASSERT_NO_FATAL_FAILURE(expect_same_image(*streamed, *anew, 1));
      EXPECT_EQ(programs(streamed->plan()), programs(anew->plan()));
    }
  }
}

/// What a new scene version needs is uploaded while frames show the former one and edits go on, with overlays beside.
TEST_F(StreamingTest, NewVersionsLandBetweenEdits) {
  SCOPED_TRACE("seed 11");
  for (const auto culler : {CullerChoice::kCpu, CullerChoice::kGpu}) {
    core::Scene scene;
    fill(scene, 22);
    engine::EngineConfig c = config(culler);
    c.culling.rebuild_share = 0.01;
    c.drawing.looks.depth_shading = {0.5f, 0.5f};
    auto streamed = Engine::create(scene, c);
    ASSERT_TRUE(streamed && set_styles(*streamed));
    std::map<core::ItemId, bool> is_red;
    const auto coloured_as = [&](bool red) {
      std::vector<core::ItemId> found;
      for (const auto& [item, item_red] : is_red)
        if (item_red == red) found.push_back(item);
      return found;
    };
    int swaps = 0, in_between = 0;
    for (int round = 0; round < 2000 && swaps < 2; ++round) {
      const std::uint64_t order = streamed->snapshot().generation();
      const std::size_t slots = streamed->snapshot().size();
      for (int i = 0; i < 4; ++i) add_mesh(scene);
      remove(scene, 2);
      scene.set_placement(core::ItemId(random() % 10'000), somewhere());
      const auto nudged = core::ItemId(random() % 10'000);
      scene.set_placement(nudged, core::translation({0.0, 0.0, 0.3}) * scene.placement(nudged));
      std::vector<core::ItemId>
          coloured;  // many, so that some show that are edited while a new scene version is uploaded
      for (int i = 0; i < 3000; ++i) coloured.push_back(core::ItemId(4000 + random() % 6000));
      streamed->paused();  // then the portions are the smallest
      const bool red = round % 2 == 0;
      ASSERT_TRUE(streamed->set_override(coloured, red ? kRed : kBlue));
      for (const core::ItemId item : coloured) is_red[item] = red;
      ASSERT_TRUE(streamed->commit() && streamed->frame(view(0.1 * round)));
      const bool swapped = streamed->snapshot().generation() != order && streamed->snapshot().size() < slots;
      swaps += swapped;
      const bool swapping = streamed->rebuilding() && !swapped;
      in_between += swapping;
      if (!swapped && !(swapping && in_between % 16 == 1)) continue;
      auto anew = Engine::create(scene, c);
      ASSERT_TRUE(anew && set_styles(*anew));
      ASSERT_TRUE(anew->set_override(coloured_as(true), kRed) && anew->set_override(coloured_as(false), kBlue));
      ASSERT_TRUE(anew->frame(view(0.1 * round)));
      // Rays of another order differ in last bits, which shows where two colours meet.
      const auto difference = image::compare(*streamed->read_colour(), *anew->read_colour());
      ASSERT_TRUE(difference);
      EXPECT_LE(difference->pixels, 200u) << "round " << round;
    }
    EXPECT_EQ(swaps, 2);
    EXPECT_GE(in_between, 1);
    items.clear();
  }
}

/// Later edits, of the same items too, may come before all of the earlier ones are shown.
TEST_F(StreamingTest, EditsMayBeFollowedInPortions) {
  // How much a portion holds, and when a new version comes, depends on time, and so do the order of the items and the
  // last bits of their outlines. In scenes of this seed no pixel's centre lies so near to one.
  SCOPED_TRACE("seed 14");
  random.seed(14);
  core::Scene scene;
  fill(scene, 12);
  engine::EngineConfig c = config(CullerChoice::kCpu);
  c.culling.rebuild_share = 0.1;
  auto streamed = Engine::create(scene, c);
  ASSERT_TRUE(streamed);
  int portions = 0;
  for (int round = 0; round < 12; ++round) {
    for (int i = 0; i < 500; ++i) scene.add_primitive(scene.root(), core::Sphere{0.3f}, somewhere());
    for (int i = 0; i < 20; ++i) add_mesh(scene);
    remove(scene, 10);
    for (int i = 0; i < 300; ++i) {
      const auto item = core::ItemId(random() % scene.item_slots());
      if (!scene.contains_item(item)) continue;
      if (i % 3 == 0)
        scene.set_placement(item, somewhere());
      else
        scene.set_visible(item, i % 2 == 0);
    }
    bool all = false;
    do {
      const auto done = streamed->commit(0.0);
      ASSERT_TRUE(done && streamed->frame(view(0.2 * round)));
      all = *done;
      ++portions;
    } while (round % 4 == 3 && !all);
    if (round % 4 != 3) continue;
    ASSERT_TRUE(streamed->frame(view(0.2 * round)));
    auto anew = Engine::create(scene, c);
    ASSERT_TRUE(anew && anew->frame(view(0.2 * round)));
    ASSERT_NO_FATAL_FAILURE(expect_same_image(*streamed, *anew, 1));
    EXPECT_EQ(streamed->snapshot().size() - streamed->snapshot().vacant_count(),
              anew->snapshot().size() - anew->snapshot().vacant_count());
  }
  EXPECT_GT(portions, 12);
}

/// Ids that others have had: what was known of those, such as styles and meshes, is not known of these, on any way to
/// follow an edit.
TEST_F(StreamingTest, ReusedIdsAreThoseOfOtherItems) {
  SCOPED_TRACE("seed 11");
  const core::Primitive shapes[] = {core::Cylinder{0.5f, 1.0f}, core::Box{1.0f, 0.6f, 1.2f}, core::Sphere{0.6f}};
  for (const double share : {0.05, 1.0}) {
    items.clear();
    core::Scene scene;
    scene.reuse_ids(true);
    fill(scene, 14);
    engine::EngineConfig c = config(share < 1.0 ? CullerChoice::kCpu : CullerChoice::kGpu);
    c.culling.rebuild_share = share;
    auto streamed = Engine::create(scene, c);
    ASSERT_TRUE(streamed);
    std::map<core::ItemId, bool> is_red;
    int swaps = 0;
    for (int round = 0; round < 60; ++round) {
      const std::uint64_t order = streamed->snapshot().generation();
      for (int piece = 0; piece < 6; ++piece) {  // commits that a new scene version comes to know at once
        exchange_items(scene, shapes, is_red);
        while (!*streamed->commit(round % 3 ? 1.0 : 0.0)) continue;
        ASSERT_TRUE(streamed->set_override({&items.back(), 1}, piece % 2 ? kRed : kBlue));
        is_red[items.back()] = piece % 2;
      }
      ASSERT_TRUE(round % 17 != 16 || streamed->rebuild());
      ASSERT_TRUE(streamed->frame(view(0.1 * round)));
      swaps += streamed->snapshot().generation() != order;
      if (round % 6 != 5) continue;
      auto anew = Engine::create(scene, c);
      ASSERT_TRUE(anew);
      for (const auto& [item, red] : is_red) ASSERT_TRUE(anew->set_override({&item, 1}, red ? kRed : kBlue));
      ASSERT_TRUE(anew->frame(view(0.1 * round)));
      const auto difference = image::compare(*streamed->read_colour(), *anew->read_colour());
      ASSERT_TRUE(difference);
      EXPECT_LE(difference->pixels, 60u) << "round " << round;  // where two colours meet, in orders of their own
    }
    EXPECT_GE(swaps, share < 1.0 ? 9 : 3);
    EXPECT_LT(scene.item_slots(), 14u * 14u * 14u + 300u) << "2,160 were added";
  }
}

TEST_F(StreamingTest, TrianglesThatAreGoneMakeRoom) {
  core::Scene scene;
  fill(scene, 8);
  engine::EngineConfig c = config(CullerChoice::kCpu);
  c.culling.rebuild_share = 0.0;
  auto engine = Engine::create(scene, c);
  ASSERT_TRUE(engine);
  std::size_t settled = 0;
  for (int round = 0; round < 60; ++round) {
    const std::vector<core::MeshId> gone = [&] {
      std::vector<core::MeshId> meshes;
      for (const core::ItemId item : items) meshes.push_back(scene.mesh_of(item));
      return meshes;
    }();
    remove(scene, items.size());
    for (const core::MeshId mesh : gone) scene.remove_mesh(mesh);
    for (int i = 0; i < 100; ++i) {
      const auto mesh =
          scene.add_mesh(gpuprims::tessellate(core::Sphere{0.8f}, {.fixed_segments = 8 + (round + i) % 9})).value();
      items.push_back(scene.add_mesh_instance(scene.root(), mesh, somewhere()));
    }
    ASSERT_TRUE(engine->commit() && engine->frame(view(0.1 * round)));
    const auto& meshes = engine::EngineParts::drawing(*engine)->scene().meshes();
    const std::size_t bytes = meshes.vertices().size() + meshes.indices().size();
    if (round == 10) settled = bytes;
    if (round > 10) {
      EXPECT_LE(bytes, settled + settled / 2) << "round " << round;
    }
  }
  EXPECT_GT(settled, 0u);
}

}  // namespace
}  // namespace sightline::tests::streaming_test
