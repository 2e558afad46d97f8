#include "sightline/engine/engine.h"

#include <chrono>

#if SIGHTLINE_HAS_GL
#include "sightline/engine/drawing.h"
#else
namespace sightline::engine {
class Drawing {};
}  // namespace sightline::engine
#endif

namespace sightline::engine {
namespace {

double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Engine::Engine(core::Scene& scene, const EngineConfig& config) : scene_(&scene), config_(config) {}
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&&) noexcept = default;
Engine::~Engine() = default;

core::Expected<Engine> Engine::create(core::Scene& scene, const EngineConfig& config) {
  if (auto delta = scene.commit(); !delta) return tl::unexpected(delta.error());
  Engine engine(scene, config);
  if (auto done = engine.build(); !done) return tl::unexpected(done.error());
  if (config.draw) {
#if SIGHTLINE_HAS_GL
    auto drawing = Drawing::create(*engine.snapshot_, config);
    if (!drawing) return tl::unexpected(drawing.error());
    engine.drawing_ = std::move(*drawing);
#else
    return core::fail("drawing needs OpenGL, and this build was made without it (SIGHTLINE_GL)");
#endif
  }
  return engine;
}

core::Expected<void> Engine::build() {
  using Culler = std::variant<culling::LinearCuller, culling::CpuCuller>;
  auto snapshot = std::make_unique<core::Snapshot>(*scene_);
  plan_ = make_plan(*snapshot, config_.culler, config_.draw, config_.ids);
  if (plan_.culler == CullerChoice::kLinear) {
    culler_ = std::make_unique<Culler>(std::in_place_type<culling::LinearCuller>, snapshot->bounds());
  } else {
    culler_ = std::make_unique<Culler>(std::in_place_type<culling::CpuCuller>, snapshot->bounds());
  }
  snapshot_ = std::move(snapshot);
  return {};
}

core::Expected<FrameReport> Engine::frame(const core::View& view) {
  FrameReport report;
  const double begin = now_seconds();
  if (last_frame_began_ >= 0.0) report.frame_ms = 1e3 * (begin - last_frame_began_);
  last_frame_began_ = begin;
  std::visit([&](const auto& culler) { culler.cull(view, visible_); }, *culler_);
  visible_.generation = snapshot_->generation();
  const double culled = now_seconds();
  report.cull_ms = 1e3 * (culled - begin);
  report.visible = snapshot_->count(visible_);
  report.tested = visible_.counters.nodes_tested + visible_.counters.boxes_tested;
#if SIGHTLINE_HAS_GL
  if (drawing_) {
    if (auto done = drawing_->draw(view, *snapshot_, visible_); !done) return tl::unexpected(done.error());
    report.draw_ms = 1e3 * (now_seconds() - culled);
  }
#endif
  return report;
}

core::Expected<void> Engine::commit() {
  auto delta = scene_->commit();
  if (!delta) return tl::unexpected(delta.error());
  if (delta->empty()) return {};
  const std::vector<core::Slot> touched = snapshot_->apply(*delta);
  if (auto* culler = std::get_if<culling::CpuCuller>(culler_.get())) culler->update(touched);
#if SIGHTLINE_HAS_GL
  if (drawing_) return drawing_->update(*snapshot_, touched);
#endif
  return {};
}

core::Expected<void> Engine::rebuild() {
  if (auto delta = scene_->commit(); !delta) return tl::unexpected(delta.error());
  if (auto done = build(); !done) return done;
#if SIGHTLINE_HAS_GL
  if (drawing_) return drawing_->rebuild(*snapshot_);
#endif
  return {};
}

void Engine::finish() {
#if SIGHTLINE_HAS_GL
  if (drawing_) drawing_->finish();
#endif
}

MemoryReport Engine::memory() const {
  MemoryReport report;
  report.scene = scene_->memory_bytes();
  report.snapshot = snapshot_->memory_bytes();
  if (const auto* culler = std::get_if<culling::CpuCuller>(culler_.get())) report.bvh = culler->memory_bytes();
#if SIGHTLINE_HAS_GL
  if (drawing_) report.gpu = drawing_->memory_bytes();
#endif
  return report;
}

}  // namespace sightline::engine
