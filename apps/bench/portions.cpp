#include "sightline/apps/bench/portions.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sightline/apps/bench/harness.h"
#include "sightline/apps/common/need.h"
#include "sightline/engine/engine.h"

namespace sightline::bench {
namespace {

using apps::need;

constexpr double kSeconds = 0.004;  // of a commit

/// Hills of 2 cells² triangles.
core::Mesh hills(std::uint32_t cells) {
  core::Mesh mesh;
  for (std::uint32_t j = 0; j <= cells; ++j)
    for (std::uint32_t i = 0; i <= cells; ++i)
      mesh.positions.emplace_back(i, j, 2.0 * std::sin(0.05 * i) * std::cos(0.07 * j) + 0.1 * std::sin(1.3 * i + j));
  for (std::uint32_t j = 0; j < cells; ++j)
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * (cells + 1) + i, c = a + cells + 1;
      mesh.indices.insert(mesh.indices.end(), {a, a + 1, c, a + 1, c + 1, c});
    }
  for (core::vec3& p : mesh.positions) p *= 100.0f / float(cells);
  return mesh;
}

struct Stage {
  core::Scene scene;
  std::vector<core::ItemId> added;

  explicit Stage(std::size_t items) {
    core::NodeId node = scene.root();
    for (std::size_t i = 0; i < items; ++i) {
      if (i % 25 == 0) node = scene.add_node(scene.root());
      add_cylinder(node, i);
    }
  }
  void add_cylinder(core::NodeId node, std::size_t i) {
    scene.add_primitive(node, core::Cylinder{0.2f, 1.0f},
                        core::translation({double(i % 400), double(i / 400 % 100), 0.5 * double(i / 40'000) - 20.0}));
  }
  void add_meshes(int count, std::uint32_t cells) {
    for (int i = 0; i < count; ++i) {
      const auto mesh = scene.add_mesh(hills(cells)).value();
      added.push_back(scene.add_mesh_instance(scene.root(), mesh, core::translation({30.0 * i, 0.0, 5.0})));
    }
  }
};

core::View overview() {
  return *core::View::perspective({{-60, -60, 90}, {150, 60, 0}, {0, 0, 1}}, 0.9, 16.0 / 9.0, 0.1);
}

json::Value row_of(const char* what, int portions, const std::vector<double>& frames) {
  return {{"what", what},
          {"portions", portions},
          {"frame_ms", apps::median(frames)},
          {"frame_ms_longest", *std::ranges::max_element(frames)}};
}

/// Portions of a commit, each with a frame after it. The one that swaps in a new scene version counts apart.
json::Value commit_all(engine::Engine& engine, const char* what) {
  double longest = 0.0, with_swap = 0.0, sum = 0.0;
  std::vector<double> frames;
  for (bool all = false; !all;) {
    const std::uint64_t order = engine.snapshot().generation();
    const double start = thread_milliseconds();
    all = need(engine.commit(kSeconds));
    const double took = thread_milliseconds() - start;
    double& most = engine.snapshot().generation() == order ? longest : with_swap;
    most = std::max(most, took);
    sum += took;
    need(engine.frame(overview()));
    frames.push_back(thread_milliseconds() - start - took);
  }
  json::Value row = row_of(what, int(frames.size()), frames);
  row.update({{"portion_ms_longest", longest}, {"portion_ms_with_swap", with_swap}, {"portions_ms", sum}});
  return row;
}

/// Frames from when levels are asked for until they are drawn.
json::Value upload_levels(engine::Engine& engine) {
  std::vector<double> frames;
  const std::size_t before = engine.memory().gpu;
  for (int i = 0, after = 0; i < 20'000 && after < 100; ++i) {
    const double start = thread_milliseconds();
    need(engine.frame(overview()));
    frames.push_back(thread_milliseconds() - start);
    after += engine.memory().levels > 0 && engine.memory().gpu > before;
  }
  return row_of("levels of these", int(frames.size()), frames);
}

}  // namespace

json::Value measure_portions(std::size_t items) {
  Stage stage(items);
  engine::EngineConfig config{.draw = true, .width = 320, .height = 180};
  config.culling.culler = engine::CullerChoice::kCpu;
  auto engine = need(engine::Engine::create(stage.scene, config));
  for (int i = 0; i < 3; ++i) need(engine.frame(overview()));
  json::Value rows;
  stage.add_meshes(1, 10);
  rows.push_back(commit_all(engine, "the first mesh"));
  stage.add_meshes(12, 316);
  rows.push_back(commit_all(engine, "12 meshes of 200,000 triangles"));
  stage.add_meshes(1, 1000);
  rows.push_back(commit_all(engine, "a mesh of 2,000,000 triangles"));
  need(engine.finish_levels());
  config = engine.config();
  config.losses.lod_error = 1.0;
  need(engine.configure(config));
  rows.push_back(upload_levels(engine));
  for (std::size_t i = 0; i < 300'000; ++i) stage.add_cylinder(stage.scene.root(), items + i);
  rows.push_back(commit_all(engine, "300,000 cylinders"));
  for (const core::ItemId item : stage.added) stage.scene.remove_item(item);
  rows.push_back(commit_all(engine, "meshes that go"));
  return rows;
}

}  // namespace sightline::bench
