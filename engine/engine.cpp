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

constexpr double kFewSlots = 256.0;  // not worth a thread

PlanRequest plan_request(const EngineConfig& config) {
  return {config.culler, config.draw, config.ids};
}

double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Engine::Engine(core::Scene& scene, const EngineConfig& config) : scene_(&scene), config_(config) {}
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&& other) noexcept {
  rebuild_.reset();  // before what it reads
  scene_ = other.scene_;
  config_ = other.config_;
  live_ = std::move(other.live_);
  visible_ = std::move(other.visible_);
  drawing_ = std::move(other.drawing_);
  last_frame_began_ = other.last_frame_began_;
  frames_ = other.frames_;
  rebuild_ = std::move(other.rebuild_);
  return *this;
}
Engine::~Engine() = default;

core::Expected<Engine> Engine::create(core::Scene& scene, const EngineConfig& config) {
  if (auto delta = scene.commit(); !delta) return tl::unexpected(delta.error());
  Engine engine(scene, config);
  engine.build();
  if (config.draw || config.culler == CullerChoice::kGpu) {
#if SIGHTLINE_HAS_GL
    auto drawing = Drawing::create(*engine.live_.snapshot, config);
    if (!drawing) return tl::unexpected(drawing.error());
    engine.drawing_ = std::move(*drawing);
#else
    return core::fail("drawing and the GPU culler need OpenGL, and this build was made without it (SIGHTLINE_GL)");
#endif
  }
  return engine;
}

void Engine::build() {
  live_ = make_generation(std::make_unique<core::Snapshot>(*scene_), plan_request(config_));
}

/// Takes a new order over when one is ready.
core::Expected<void> Engine::land() {
  if (!rebuild_) return {};
  if (rebuild_->finished()) {
    rebuild_.reset();
    return {};
  }
  if (!rebuild_->exchange(live_)) return {};
#if SIGHTLINE_HAS_GL
  if (drawing_) return drawing_->rebuild(*live_.snapshot);
#endif
  return {};
}

core::Expected<FrameReport> Engine::frame(const core::View& view) {
  if (auto landed = land(); !landed) return tl::unexpected(landed.error());
  FrameReport report;
  report.frame = frames_++;
  const double begin = now_seconds();
  if (last_frame_began_ >= 0.0) report.frame_ms = 1e3 * (begin - last_frame_began_);
  last_frame_began_ = begin;
  const bool gpu = live_.plan.culler == CullerChoice::kGpu;
  if (auto done = cull(view, report.frame); !done) return tl::unexpected(done.error());
  const double culled = now_seconds();
  report.cull_ms = 1e3 * (culled - begin);
  report.visible = gpu ? -1 : std::int64_t(live_.snapshot->count(visible_));
  report.tested = gpu ? -1 : std::int64_t(visible_.counters.nodes_tested + visible_.counters.boxes_tested);
#if SIGHTLINE_HAS_GL
  if (drawing_) {
    auto done = gpu ? drawing_->draw_culled(view, *live_.snapshot) : drawing_->draw(view, *live_.snapshot, visible_);
    if (!done) return tl::unexpected(done.error());
    report.draw_ms = 1e3 * (now_seconds() - culled);
  }
#endif
  return report;
}

core::Expected<void> Engine::cull(const core::View& view, [[maybe_unused]] std::uint64_t frame) {
  visible_.generation = live_.snapshot->generation();
#if SIGHTLINE_HAS_GL
  if (live_.plan.culler == CullerChoice::kGpu) {
    visible_.clear();
    return drawing_->cull(view, *live_.snapshot, frame);
  }
#endif
  std::visit([&](const auto& culler) { culler.cull(view, visible_); }, *live_.culler);
  return {};
}

std::optional<LateReport> Engine::take_late_report() {
#if SIGHTLINE_HAS_GL
  if (drawing_)
    if (const auto feedback = drawing_->take_gpu_feedback())
      return LateReport{feedback->frame, std::int64_t(feedback->visible), feedback->time_ms.value_or(-1.0)};
#endif
  return std::nullopt;
}

const char* Engine::culler_name() const {
  switch (live_.plan.culler) {
    case CullerChoice::kGpu:
      return "gpu";
    case CullerChoice::kCpu:
      return "cpu";
    default:
      return "linear";
  }
}

core::Expected<void> Engine::commit() {
  if (auto landed = land(); !landed) return landed;
  auto delta = scene_->commit();
  if (!delta) return tl::unexpected(delta.error());
  if (delta->empty()) return {};
  if (rebuild_) rebuild_->begin_edit();
  const std::vector<core::Slot> touched = live_.snapshot->apply(*delta);
  if (rebuild_) rebuild_->end_edit(*delta);
  live_.update(touched);
  const double disorder = double(live_.snapshot->disorder());
  if (!rebuild_ && config_.rebuild_share > 0.0 && disorder > kFewSlots &&
      disorder > config_.rebuild_share * double(live_.snapshot->size()))
    rebuild_ = std::make_unique<BackgroundRebuild>(*live_.snapshot, plan_request(config_));
#if SIGHTLINE_HAS_GL
  if (drawing_) return drawing_->update(*live_.snapshot, touched);
#endif
  return {};
}

core::Expected<void> Engine::rebuild() {
  if (auto delta = scene_->commit(); !delta) return tl::unexpected(delta.error());
  rebuild_.reset();
  build();
#if SIGHTLINE_HAS_GL
  if (drawing_) return drawing_->rebuild(*live_.snapshot);
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
  report.snapshot = live_.snapshot->memory_bytes();
  if (const auto* culler = std::get_if<culling::CpuCuller>(live_.culler.get())) report.bvh = culler->memory_bytes();
#if SIGHTLINE_HAS_GL
  if (drawing_) report.gpu = drawing_->memory_bytes();
#endif
  return report;
}

}  // namespace sightline::engine
