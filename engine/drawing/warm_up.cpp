#include "sightline/engine/drawing/internal/warm_up.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <new>
#include <numbers>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "sightline/gl/internal/program_cache.h"
#include "sightline/gpuscene/internal/draw_lists.h"
#include "sightline/gpuscene/internal/gpu_scene.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::engine {
namespace {

using gpuscene::BatchKind;

constexpr int kImageSize = 16;           // pixels
constexpr std::size_t kMostThreads = 8;  // each has a context

core::Primitive example_of(BatchKind kind) {
  switch (kind) {
    case BatchKind::kCylinder:
      return core::Cylinder{1.0f, 2.0f};
    case BatchKind::kSnout:
      return core::Snout{1.0f, 0.5f, 2.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    case BatchKind::kCircularTorus:
      return core::CircularTorus{2.0f, 0.5f, float(std::numbers::pi) / 2.0f};
    case BatchKind::kSphereCap:
      return core::Sphere{2.0f};
    case BatchKind::kRectangularTorus:
      return core::RectangularTorus{1.0f, 2.0f, 1.0f, float(std::numbers::pi) / 2.0f};
    case BatchKind::kPyramid:
      return core::Pyramid{2.0f, 2.0f, 1.0f, 1.0f, 0.0f, 0.0f, 2.0f};
    case BatchKind::kLine:
      return core::Line{-1.0f, 1.0f};
    default:
      return core::Box{1.0f, 1.0f, 1.0f};
  }
}

core::Mesh example_mesh() {
  core::Mesh mesh;
  mesh.positions = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 1.0f}};
  mesh.indices = {0, 1, 2};
  return mesh;
}

core::Expected<core::Scene> example_scene(BatchKind batch) {
  core::Scene scene;
  if (batch == BatchKind::kMesh) {
    auto mesh = scene.add_mesh(example_mesh());
    if (!mesh) return tl::unexpected(mesh.error());
    scene.add_mesh_instance(scene.root(), *mesh);
  } else {
    scene.add_primitive(scene.root(), example_of(batch));
  }
  if (auto done = scene.commit(); !done) return tl::unexpected(done.error());
  return scene;
}

/// A thread's context, and what it draws with.
struct Stage {
  gl::Context context;
  render::RenderTarget target;
  render::Renderer renderer;

  static core::Expected<Stage> create(const EngineConfig& config, const render::TargetFormat& format) {
    gl::ContextOptions options;
    options.platform = config.context.platform;
    auto context = gl::Context::create_offscreen(options);
    if (!context) return tl::unexpected(context.error());
    context->cache_programs(config.context.program_cache.value_or(gl::ProgramCache::default_folder()));
    auto target = render::RenderTarget::create(*context, kImageSize, kImageSize, format);
    if (!target) return tl::unexpected(target.error());
    auto renderer = render::Renderer::begin(*context);
    if (!renderer) return tl::unexpected(renderer.error());
    return Stage{std::move(*context), std::move(*target), std::move(*renderer)};
  }

  core::Expected<void> draw(BatchKind kind) {
    auto example = example_scene(kind);
    if (!example) return tl::unexpected(example.error());
    const core::Snapshot snapshot(*example);
    auto scene = gpuscene::GpuScene::create(context, snapshot, {});
    if (!scene) return tl::unexpected(scene.error());
    auto lists = gpuscene::DrawLists::create(context, *scene);
    if (!lists) return tl::unexpected(lists.error());
    const core::Aabb box = snapshot.bounds().box(0);
    const core::dvec3 origin = snapshot.bounds().origin;
    const auto view = core::View::fit({origin + core::dvec3(box.min), origin + core::dvec3(box.max)},
                                      core::kOverviewDirection, 0.9, 1.0);
    if (!view) return tl::unexpected(view.error());
    core::VisibleSet all;
    all.generation = snapshot.generation();
    all.single_slots = {0};
    if (auto done = lists->update(snapshot, *scene, all); !done) return done;
    if (auto done = renderer.follow(*scene, target.format()); !done) return done;
    auto done = renderer.draw(*view, snapshot, *scene, *lists, target);
    context.functions().Finish();
    return done;
  }
};

/// The order in which threads take kinds. Of those that are ray-cast, which share their first stages, the one with the
/// shortest program comes first, so that only one thread compiles these. Long ones come before short ones, so that no
/// thread ends long after the others.
constexpr std::array<BatchKind, gpuscene::kBatchKindCount> kOrder = {
    BatchKind::kBox,           BatchKind::kMesh,    BatchKind::kLine,
    BatchKind::kCircularTorus, BatchKind::kSnout,   BatchKind::kRectangularTorus,
    BatchKind::kCylinder,      BatchKind::kPyramid, BatchKind::kSphereCap};

}  // namespace

void warm_up(const gl::Context& context, const EngineConfig& config, const render::TargetFormat& format,
             std::span<const BatchKind> kinds) {
  const std::size_t processors = std::thread::hardware_concurrency();
  const gl::Functions& gl = context.functions();
  if (!context.capabilities().software || processors < 2 || !gl.program_cache || !gl.program_cache->enabled()) return;
  std::vector<BatchKind> missing;
  for (const BatchKind kind : kOrder)
    if (std::find(kinds.begin(), kinds.end(), kind) != kinds.end() && !render::Renderer::has_cached(gl, kind, format))
      missing.push_back(kind);
  if (missing.size() < 2) return;
  std::atomic<std::size_t> next = 0;
  const auto draw_next = [&] {
    try {
      auto stage = Stage::create(config, format);
      for (std::size_t i = next++; stage && i < missing.size(); i = next++)
        if (!stage->draw(missing[i])) return;
    } catch (const std::bad_alloc&) {  // the frame itself will tell
    }
  };
  std::vector<std::thread> threads;
  try {
    for (std::size_t i = 0; i < std::min({missing.size(), processors, kMostThreads}); ++i)
      threads.emplace_back(draw_next);
  } catch (const std::system_error&) {  // fewer threads do
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace sightline::engine
