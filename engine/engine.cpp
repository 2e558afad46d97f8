#include "sightline/engine/engine.h"

#include <cassert>
#include <tuple>
#include <utility>

#include "sightline/engine/clock.h"

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
constexpr double kTryAgain = 0.5;    // seconds
// Measured on llvmpipe: 1.15 to 1.2 times the frame of the CPU's path (docs/hybrid-culling.md).
constexpr double kSoftwareGpuExcess = 0.1;

PlanRequest plan_request(const EngineConfig& config) {
  return {config.culler, config.draw, config.ids};
}

}  // namespace

Engine::Engine(core::Scene& scene, const EngineConfig& config) : scene_(&scene), config_(config) {}
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&& other) noexcept {
  rebuild_.reset();  // before what it reads
  scene_ = other.scene_;
  edits_ = std::move(other.edits_);
  config_ = other.config_;
  live_ = std::move(other.live_);
  visible_ = std::move(other.visible_);
  drawing_ = std::move(other.drawing_);
  next_try_ = other.next_try_;
  last_frame_began_ = other.last_frame_began_;
  frames_ = other.frames_;
  hybrid_ = other.hybrid_;
  late_ = std::move(other.late_);
  rebuild_ = std::move(other.rebuild_);
  return *this;
}
Engine::~Engine() = default;

core::Expected<Engine> Engine::create(core::Scene& scene, const EngineConfig& config) {
  if (auto delta = scene.commit(); !delta) return tl::unexpected(delta.error());
  Engine engine(scene, config);
  engine.edits_ = scene.subscribe();
  engine.config_.controller.frame_cost.rendering = config.draw;
  engine.build();
  if (auto done = engine.follow_generation(); !done) return tl::unexpected(done.error());
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
  return follow_generation();
}

/// What hangs on the plan and on the order of the items besides the CPU culler.
core::Expected<void> Engine::follow_generation() {
  auto done = make_drawing(true);
  follow_hybrid();
  return done;
}

void Engine::follow_hybrid() {
  const std::size_t items = live_.snapshot->size();
  if (live_.plan.culler != CullerChoice::kHybrid)
    hybrid_.reset();
  else if (hybrid_)
    hybrid_->scene_changed(items);
  else
    hybrid_.emplace(controller_config(), items, frames_);
  if (hybrid_ && !drawing_) hybrid_->gpu_lost();
}

culling::ControllerConfig Engine::controller_config() const {
  culling::ControllerConfig config = config_.controller;
#if SIGHTLINE_HAS_GL
  double& excess = config.frame_cost.presumed_gpu_excess;
  if (excess == 0.0 && drawing_ && drawing_->context().capabilities().software) excess = kSoftwareGpuExcess;
#endif
  return config;
}

core::Expected<void> Engine::set_culler(CullerChoice choice) {
  rebuild_.reset();  // it would land with the choice before
  const CullerChoice before = std::exchange(config_.culler, choice);
  live_.follow_plan(plan_request(config_));
  if (auto done = make_drawing(false); !done) {
    config_.culler = before;
    live_.follow_plan(plan_request(config_));
    note_gpu_form();
    return done;
  }
  follow_hybrid();
  return {};
}

core::Expected<void> Engine::resize(int width, int height) {
#if SIGHTLINE_HAS_GL
  if (drawing_ && config_.draw)
    if (auto done = unless_lost(drawing_->resize(width, height)); !done) return done;
#endif
  config_.width = width;
  config_.height = height;
  return {};
}

bool Engine::needs_gl() const {
  return config_.draw || live_.plan.gpu_culls();
}

/// Makes what the plan needs in the context: all of it for a new order of the items or a new context, else what is not
/// there. While the context is lost there is nothing to do.
core::Expected<void> Engine::make_drawing(bool new_order) {
  if (!needs_gl()) {
    drawing_.reset();
    return {};
  }
#if SIGHTLINE_HAS_GL
  core::Expected<void> done;
  const bool gpu_culls = live_.plan.gpu_culls();
  if (drawing_) {
    if (new_order)
      done = unless_lost(drawing_->rebuild(*live_.snapshot, gpu_culls));
    else if (gpu_culls)
      done = unless_lost(drawing_->add_culler(*live_.snapshot));
  } else if (next_try_ < 0.0) {
    auto drawing = Drawing::create(*live_.snapshot, config_, gpu_culls);
    if (!drawing) return tl::unexpected(drawing.error());
    drawing_ = std::move(*drawing);
  }
  note_gpu_form();
  return done;
#else
  (void)new_order;
  return core::fail("drawing and the GPU culler need OpenGL, and this build was made without it (SIGHTLINE_GL)");
#endif
}

/// Notices a lost context, and tries to replace one that is the engine's own.
void Engine::look_after_context() {
#if SIGHTLINE_HAS_GL
  if (drawing_ && drawing_->lost()) drop_context();
  if (next_try_ < 0.0 || config_.context || now_seconds() < next_try_ || !needs_gl()) return;
  next_try_ = -1.0;
  if (make_drawing(true)) {
    if (hybrid_) hybrid_->gpu_ready();
  } else {
    next_try_ = now_seconds() + kTryAgain;
  }
#endif
}

/// A context that is lost in the middle of something is dealt with in the next frame.
core::Expected<void> Engine::unless_lost(core::Expected<void> done) const {
#if SIGHTLINE_HAS_GL
  if (!done && drawing_->lost()) return {};
#endif
  return done;
}

void Engine::drop_context() {
  drawing_.reset();
  next_try_ = 0.0;
  if (hybrid_) hybrid_->gpu_lost();
}

core::Expected<void> Engine::use_context(gl::Context& context) {
#if SIGHTLINE_HAS_GL
  if (drawing_ && drawing_->lost()) drop_context();
#endif
  assert(!drawing_ && "the other context is still in use: drop_context()");
  const auto before = std::pair(config_.context, next_try_);
  config_.context = &context;
  next_try_ = -1.0;
  if (auto done = make_drawing(true); !done) {
    std::tie(config_.context, next_try_) = before;
    return done;
  }
  if (hybrid_) hybrid_->gpu_ready();
  return {};
}

/// The plan is made before there is a context to measure in.
void Engine::note_gpu_form() {
#if SIGHTLINE_HAS_GL
  const auto* culler = drawing_ && live_.plan.gpu_culls() ? drawing_->gpu_culler() : nullptr;
  if (culler) add_gpu_form(live_.plan, culler->form(), drawing_->why_gpu_form());
#endif
}

core::Expected<FrameReport> Engine::frame([[maybe_unused]] const core::View& view, const core::View& cull_view) {
  if (auto landed = land(); !landed) return tl::unexpected(landed.error());
  FrameReport report;
  report.frame = frames_++;
  const double begin = now_seconds();
  if (last_frame_began_ >= 0.0) report.frame_ms = 1e3 * (begin - last_frame_began_);
  last_frame_began_ = begin;
  look_after_context();
  [[maybe_unused]] const auto on_gpu = cull(cull_view, report);
  if (!on_gpu) return tl::unexpected(on_gpu.error());
#if SIGHTLINE_HAS_GL
  if (drawing_) {
    const double culled = now_seconds();
    auto done = *on_gpu ? drawing_->draw_culled(view, *live_.snapshot, report.frame)
                        : drawing_->draw(view, *live_.snapshot, visible_, report.frame);
    report.drawn = config_.draw && done;
    if (done = unless_lost(std::move(done)); !done) return tl::unexpected(done.error());
    report.draw_ms = 1e3 * (now_seconds() - culled);
    report.wait_ms = drawing_->waited_ms();
  }
#endif
  if (hybrid_) hybrid_->measured(report, describe_walk());
  return report;
}

/// True when the GPU did it: then the answer is there, and visible() empty.
core::Expected<bool> Engine::cull(const core::View& view, FrameReport& report) {
  visible_.clear();
  visible_.generation = live_.snapshot->generation();
#if SIGHTLINE_HAS_GL
  bool on_gpu = drawing_ && live_.plan.culler == CullerChoice::kGpu;
  if (hybrid_) {
    gather_late_reports();
    on_gpu = hybrid_->next(report.frame_ms) == culling::Path::kGpu;
    report.state = hybrid_->controller().state();
  }
  if (on_gpu) {
    const double begin = now_seconds();
    const auto done = drawing_->cull(view, *live_.snapshot, report.frame);
    if (done) {
      report.path = "gpu";
      report.cull_ms = 1e3 * (now_seconds() - begin);
      report.visible = report.tested = -1;
      return true;
    }
    if (hybrid_)
      hybrid_->gpu_lost();  // the CPU can do without
    else if (auto error = unless_lost(done); !error)
      return tl::unexpected(error.error());
  }
#endif
  cull_on_cpu(view, report);
  return false;
}

void Engine::cull_on_cpu(const core::View& view, FrameReport& report) {
  const double begin = now_seconds();
  std::visit([&](const auto& culler) { culler.cull(view, visible_); }, *live_.culler);
  report.cull_ms = 1e3 * (now_seconds() - begin);
  report.path = std::holds_alternative<culling::CpuCuller>(*live_.culler) ? "cpu" : "linear";
  report.visible = std::int64_t(live_.snapshot->count(visible_));
  report.tested = std::int64_t(visible_.counters.nodes_tested + visible_.counters.boxes_tested);
}

/// Only the dissertation's policy asks for it.
culling::FrameSample Engine::describe_walk() const {
  culling::FrameSample walk;
  const auto* culler = std::get_if<culling::CpuCuller>(live_.culler.get());
  if (culler && config_.controller.policy == culling::Policy::kSeedStateMachine)
    culler->describe(visible_.counters, walk);
  return walk;
}

void Engine::gather_late_reports() {
#if SIGHTLINE_HAS_GL
  constexpr std::size_t kMost = 64;
  if (!drawing_) return;
  if (hybrid_)
    while (const auto drawn = drawing_->take_drawn()) hybrid_->drawn(drawn->frame, drawn->gpu_ms);
  while (const auto feedback = drawing_->take_gpu_feedback()) {
    late_.push_back({feedback->frame, std::int64_t(feedback->visible), feedback->time_ms.value_or(-1.0)});
    if (hybrid_) hybrid_->measured(late_.back());
    if (late_.size() > kMost) late_.pop_front();
  }
#endif
}

std::optional<LateReport> Engine::take_late_report() {
  gather_late_reports();
  if (late_.empty()) return std::nullopt;
  const LateReport oldest = late_.front();
  late_.pop_front();
  return oldest;
}

const char* Engine::culler_name() const {
  switch (live_.plan.culler) {
    case CullerChoice::kGpu:
      return "gpu";
    case CullerChoice::kHybrid:
      return "hybrid";
    case CullerChoice::kCpu:
      return "cpu";
    default:
      return "linear";
  }
}

core::Expected<void> Engine::commit() {
  if (auto landed = land(); !landed) return landed;
  if (auto published = scene_->commit(); !published) return tl::unexpected(published.error());
  const core::SceneDelta delta = edits_.take();
  if (delta.empty()) return {};
  std::vector<core::Slot> touched;
  const auto apply = [&] { touched = live_.snapshot->apply(delta); };
  rebuild_ ? rebuild_->edit(delta, apply) : apply();
  live_.update(touched);
  const bool items_edited = delta.size() > delta.materials.size();  // colours change nothing of what frames cost
  if (hybrid_ && items_edited) hybrid_->scene_changed(live_.snapshot->size());
  const double disorder = double(live_.snapshot->disorder());
  if (!rebuild_ && config_.rebuild_share > 0.0 && disorder > kFewSlots &&
      disorder > config_.rebuild_share * double(live_.snapshot->size()))
    rebuild_ = std::make_unique<BackgroundRebuild>(*live_.snapshot, plan_request(config_));
#if SIGHTLINE_HAS_GL
  if (drawing_) return unless_lost(drawing_->update(*live_.snapshot, touched, delta.materials));
#endif
  return {};
}

core::Expected<void> Engine::rebuild() {
  if (auto delta = scene_->commit(); !delta) return tl::unexpected(delta.error());
  edits_ = scene_->subscribe();  // the new snapshot shows all edits
  rebuild_.reset();
  build();
  return follow_generation();
}

void Engine::paused() {
  last_frame_began_ = -1.0;
  if (hybrid_) hybrid_->paused();
}

void Engine::finish() {
#if SIGHTLINE_HAS_GL
  if (drawing_) drawing_->finish();
#endif
}

Drawing* Engine::drawing() {
#if SIGHTLINE_HAS_GL
  if (drawing_ && !drawing_->make_current()) return nullptr;
#endif
  return drawing_.get();
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
