// One thread edits a scene; engines on other threads cull, pick, query and make new scene versions meanwhile. Only
// create(), commit() and rebuild() keep out of the edits' way, as docs/guide/embedding.md says. ThreadSanitizer finds
// what reads the scene nevertheless; without it wrong picks do.
#include <atomic>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/engine/engine.h"
#include "sightline/engine/pick.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::threads_test {
namespace {

using engine::Engine;

core::Mesh lump(std::mt19937& random) {
  core::Mesh mesh = gpuprims::tessellate(core::Sphere{1.5f}, {.fixed_segments = 3 + int(random() % 6)});
  mesh.name = std::to_string(mesh.indices.size());
  return mesh;
}

/// Items come and go, each with a mesh of its own, which goes with it.
class Editor {
 public:
  explicit Editor(std::uint32_t seed) : random_(seed) {
    for (int i = 0; i < 1500; ++i) add();
    EXPECT_TRUE(scene.commit());
  }

  void edit() {
    switch (random_() % 4) {
      case 0:
        return add();
      case 1: {
        if (items_.size() < 1000) return;
        std::swap(items_[random_() % items_.size()], items_.back());
        const core::ItemId item = items_.back();
        items_.pop_back();
        const core::MeshId mesh = scene.mesh_of(item);
        const core::NodeId node = scene.node_of(item);
        scene.remove_item(item);
        scene.remove_mesh(mesh);
        if (random_() % 2 == 0) scene.remove_node(node);
        return;
      }
      case 2:
        (void)scene.add_mesh(lump(random_)).value();  // that no item uses
        return;
      default:
        scene.set_placement(items_[random_() % items_.size()], somewhere());
    }
  }

  core::Scene scene;
  std::mutex access;  // of the scene

 private:
  void add() {
    const core::NodeId node = scene.add_node(scene.root(), "lump");
    items_.push_back(scene.add_mesh_instance(node, scene.add_mesh(lump(random_)).value(), somewhere()));
  }
  core::Affine somewhere() {
    const auto coordinate = [&] { return double(random_() % 4000) / 100.0 - 20.0; };
    return core::translation({coordinate(), coordinate(), coordinate()});
  }

  std::mt19937 random_;
  std::vector<core::ItemId> items_;
};

core::View view_of(std::mt19937& random) {
  const double turn = double(random() % 628) / 100.0;
  return *core::View::perspective({{50 * std::cos(turn), 50 * std::sin(turn), 12}, {0, 0, 0}, {0, 0, 1}}, 0.9, 1.5,
                                  0.5);
}

/// What an application does with an engine, for so many frames.
void use(Editor& editor, std::uint32_t seed, int frames) {
  std::mt19937 random(seed);
  engine::EngineConfig config;
  config.width = 300, config.height = 200;
  config.culling.culler = engine::CullerChoice::kCpu;
  config.culling.rebuild_share = 0.02;
  auto engine = [&] {
    const std::lock_guard lock(editor.access);
    return Engine::create(editor.scene, config);
  }();
  ASSERT_TRUE(engine) << engine.error().message;
  for (int frame = 0; frame < frames; ++frame) {
    const core::View view = view_of(random);
    ASSERT_TRUE(engine->frame(view));
    engine->prepare_picks();
    for (int i = 0; i < 5; ++i) {
      const auto pick = engine->pick(view, double(random() % 300), double(random() % 200));
      ASSERT_TRUE(pick) << pick.error().message;
      ASSERT_TRUE(!*pick || ((*pick)->node.valid() && (*pick)->triangle != core::kNone));
    }
    const engine::PixelRectangle rectangle{double(random() % 200), double(random() % 100), 300.0, 200.0};
    ASSERT_TRUE(engine->items_in(view, rectangle, culling::RegionRule::kCrossing));
    ASSERT_TRUE(engine->cull_states(view));
    const std::lock_guard lock(editor.access);
    ASSERT_TRUE(engine->commit());
    ASSERT_TRUE(random() % 16 != 0 || engine->rebuild());
  }
}

TEST(Threads, EnginesReadNoSceneThatIsEdited) {
  Editor editor(1);
  std::atomic<int> running = 2;
  std::vector<std::jthread> users;
  for (std::uint32_t seed = 1; seed <= 2; ++seed)
    users.emplace_back([&, seed] {
      use(editor, seed, repeated(300));
      --running;
    });
  std::uint64_t edits = 0;
  while (running > 0) {
    const std::lock_guard lock(editor.access);
    for (int i = 0; i < 20; ++i, ++edits) editor.edit();
    std::this_thread::yield();
  }
  EXPECT_GT(edits, 0u);
}

/// On one thread, as the manual allows: meshes come and go while a new scene version, and the tracer for it, are made.
TEST(Threads, MeshesComeAndGoWhileATracerIsMade) {
  Editor editor(2);
  engine::EngineConfig config;
  config.culling.culler = engine::CullerChoice::kCpu;
  config.culling.rebuild_share = 0.02;
  auto engine = Engine::create(editor.scene, config);
  ASSERT_TRUE(engine) << engine.error().message;
  std::mt19937 random(2);
  ASSERT_TRUE(engine->pick(view_of(random), 640, 360));
  for (int round = 0; round < repeated(100); ++round) {
    for (int i = 0; i < 100; ++i) editor.edit();
    ASSERT_TRUE(engine->commit());
    engine->prepare_picks();
    for (int i = 0; i < 300 && (engine->preparing_picks() || engine->rebuilding()); ++i) {
      for (int edit = 0; edit < 20; ++edit) editor.edit();
      ASSERT_TRUE(engine->frame(view_of(random)));
    }
  }
}

}  // namespace
}  // namespace sightline::tests::threads_test
