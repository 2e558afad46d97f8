// EngineConfig::culling.part: images of the parts of a scene, put together by depth, beside that of the whole.
#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/tests/engine/drawing_modes.h"

namespace sightline::tests::scene_parts_test {
namespace {

using engine::Engine;
using engine::EngineConfig;

constexpr int kWidth = 200, kHeight = 140;

struct Image {
  std::vector<std::uint8_t> colours;
  std::vector<std::uint32_t> ids;
  std::vector<float> depths;  // reversed
};

class SceneParts : public DrawnGrid {
 protected:
  /// Boxes and cylinders, meshes between them, and pipes in a row, whose ends cover each other.
  void SetUp() override {
    DrawnGrid::SetUp();
    fill(scene, 9);
    for (int i = 0; i < 40; ++i) {
      core::Mesh mesh;
      mesh.positions = {{0, 0, 0}, {0.8f, 0, 0}, {0, 0.8f + 0.01f * float(i), 0}, {0, 0, 0.8f}};
      mesh.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
      const auto added = scene.add_mesh(mesh);
      ASSERT_TRUE(added) << added.error().message;
      scene.add_mesh_instance(scene.root(), *added, core::translation({0.5 + i % 8, 0.5 + i / 8 % 8, 0.5 + i * 3 % 8}));
    }
    for (int i = 0; i < 300; ++i)
      scene.add_primitive(scene.root(), core::Cylinder{0.3f, 0.1f}, core::translation({-1.0, -1.0, 0.1 * i}));
  }

  static core::View seen() {
    return *core::View::perspective({{-6.0, -8.0, 9.0}, {4.0, 4.0, 4.0}, {0, 0, 1}}, 0.9, double(kWidth) / kHeight,
                                    0.1);
  }

  EngineConfig config(int index, int count) const {
    EngineConfig made;
    made.draw = made.drawing.ids = true;
    made.width = kWidth;
    made.height = kHeight;
    made.culling.part = {index, count};
    return made;
  }

  static Image drawn(Engine& engine) {
    const auto report = engine.frame(seen());
    EXPECT_TRUE(report && report->drawn);
    return {engine.read_colour()->pixels, engine.read_ids()->ids,
            engine::EngineParts::drawing(engine)->target().read_reversed_depths()};
  }

  static void put(const Image& part, Image& into) {
    for (std::size_t i = 0; i < into.ids.size(); ++i) {
      if (part.depths[i] <= into.depths[i]) continue;
      into.depths[i] = part.depths[i];
      into.ids[i] = part.ids[i];
      std::copy_n(&part.colours[3 * i], 3, &into.colours[3 * i]);
    }
  }

  core::Scene scene;
};

TEST_F(SceneParts, MakeTheImageOfTheWhole) {
  auto whole = Engine::create(scene, config(0, 1));
  ASSERT_TRUE(whole) << whole.error().message;
  const Image expected = drawn(*whole);
  ASSERT_GT(engine::EngineParts::joints(*whole).count(), 500u);
  for (const int count : {2, 3, 5, 40}) {
    SCOPED_TRACE(count);
    std::optional<Image> all;
    std::set<core::ItemId> seen_items;
    std::size_t items = 0;
    for (int index = 0; index < count; ++index) {
      auto engine = Engine::create(scene, config(index, count));
      ASSERT_TRUE(engine) << engine.error().message;
      const Image part = drawn(*engine);
      for (core::Slot slot = 0; slot < engine->snapshot().size(); ++slot)
        if (!engine->snapshot().vacant(slot)) seen_items.insert(engine->snapshot().item(slot)), ++items;
      if (!all) all = part;
      put(part, *all);
      EXPECT_EQ(engine::EngineParts::joints(*engine).count(),
                engine::EngineParts::joints(*whole).count());  // ends that another part covers
      EXPECT_LT(engine->memory().gpu, whole->memory().gpu);
    }
    EXPECT_EQ(items, whole->snapshot().size() - whole->snapshot().vacant_count());
    EXPECT_EQ(seen_items.size(), items);
    std::size_t others = 0;
    for (std::size_t i = 0; i < expected.ids.size(); ++i) others += all->depths[i] != expected.depths[i];
    EXPECT_EQ(others, 0u);
    EXPECT_EQ(all->ids, expected.ids);
    EXPECT_EQ(all->colours, expected.colours);
  }
}

TEST_F(SceneParts, FollowEdits) {
  auto whole = Engine::create(scene, config(0, 1));
  auto first = Engine::create(scene, config(0, 2)), second = Engine::create(scene, config(1, 2));
  ASSERT_TRUE(whole && first && second);
  const auto add = [&](double x) {
    scene.add_primitive(scene.root(), core::Cylinder{1.0f, 1.0f}, core::translation({x, -2.0, 6.0}));
  };
  add(0.0);
  add(4.0);
  ASSERT_TRUE(whole->commit() && whole->rebuild() && first->commit() && second->commit());
  Image all = drawn(*first);
  put(drawn(*second), all);
  const Image expected = drawn(*whole);
  EXPECT_EQ(all.ids, expected.ids);
  EXPECT_EQ(all.colours, expected.colours);
}

TEST_F(SceneParts, MustExist) {
  for (const auto& [index, count] : {std::pair(0, 0), {-1, 2}, {2, 2}, {0, -1}})
    EXPECT_FALSE(Engine::create(scene, config(index, count)));
}

}  // namespace
}  // namespace sightline::tests::scene_parts_test
