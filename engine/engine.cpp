#include "sightline/engine/engine.h"

#include <limits>
#include <utility>

#include "sightline/core/memory.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/engine/internal/engine_state.h"
#include "sightline/engine/internal/settings.h"

namespace sightline::engine {
namespace {

/// `picks`: the application has picked.
PlanRequest plan_request(const EngineConfig& config, bool rays, bool picks) {
  return {config.culling.culler,
          config.draw,
          rays,
          config.drawing.ids,
          config.culling.occlusion,
          config.losses.min_projected_area > 0.0f,
          config.losses.budget_ms > 0.0,
          config.losses.lod_error > 0.0,
          config.drawing.looks.depth_shading.any(),
          config.drawing.looks.hatching.any(),
          config.drawing.looks.edges.any(),
          picks || rays,
          config.culling.part};
}

core::Expected<void> check(const EngineConfig& config) {
  if (auto good = check_ranges(config); !good) return good;
  if (config.context.later && config.context.application)
    return core::fail("engine: context_later means that there is no context yet, and there is one");
  if (config.culling.part.count < 1 || config.culling.part.index < 0 ||
      config.culling.part.index >= config.culling.part.count)
    return core::fail("engine: part must have an index from 0 on and below its count");
  if (config.culling.culler == CullerChoice::kGpu && plan_request(config, false, false).needs_cpu())
    return core::fail("engine: min_projected_area and budget_ms need a culler on the CPU, and culler is gpu");
  return config.draw && config.drawing.renderer == Renderer::kRays ? check_rays(config) : core::Expected<void>();
}

/// Whether what a hybrid has learnt with one holds with the other, as far as settings go.
bool cost_alike(const EngineConfig& a, const EngineConfig& b) {
  return a.culling.controller == b.culling.controller && a.culling.sample_test == b.culling.sample_test &&
         a.culling.occlusion == b.culling.occlusion;
}

}  // namespace

EngineState::EngineState(core::Scene& scene_, const EngineConfig& config_)
    : scene(&scene_), edits(scene_.subscribe()), config(config_) {
  config.culling.controller.rendering = config.draw;
  if (config.context.later) next_try = std::numeric_limits<double>::infinity();
}

std::unique_ptr<KeptState> EngineState::keep_state() const {
  if (backend->ready()) return backend->keep_state();
  const bool changes_context =
      needs_gl() && !config.context.application && config.context.gl_state == GlState::kRestore;
  return changes_context ? keep_current_context() : nullptr;
}

bool EngineState::shows_unseen(const core::View& view, const core::View& cull_view) const {
  return config.draw && config.drawing.culled_colour && backend->ready() && !core::same_image(view, cull_view);
}

PlanRequest plan_request(const EngineState& s) {
  return plan_request(s.config, s.draws_by_rays(), s.picks || s.live.tracer);
}

core::Expected<Engine> Engine::create(core::Scene& scene, const EngineConfig& config, const Progress& progress) {
  if (auto good = check(config); !good) return tl::unexpected(good.error());
  if (auto delta = scene.commit(); !delta) return tl::unexpected(delta.error());
  auto state = std::make_unique<EngineState>(scene, config);
  if (auto done = build(*state, progress); !done) return tl::unexpected(done.error());
  if (progress) progress(1.0);
  return Engine(std::move(state));
}

Engine::Engine(std::unique_ptr<EngineState> state) : state_(std::move(state)) {}
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&&) noexcept = default;
Engine::~Engine() = default;

const EngineConfig& Engine::config() const {
  return state_->config;
}
const Plan& Engine::plan() const {
  return state_->live.plan;
}
const core::Snapshot& Engine::snapshot() const {
  return *state_->live.snapshot;
}
const gpuprims::Joints& EngineParts::joints(const Engine& engine) {
  return engine.state_->live.joints;
}
const core::VisibleSet& Engine::visible() const {
  return state_->visible;
}
const culling::Controller* Engine::controller() const {
  return state_->hybrid ? &state_->hybrid->controller() : nullptr;
}
void EngineParts::set_traces_motion(Engine& engine, bool traces) {
  engine.state_->new_tracer.for_motion = traces;
}

Drawing* EngineParts::drawing(Engine& engine) {
  return engine.state_->backend->drawing();
}

// --- settings --------------------------------------------------------------------------------------------------------

core::Expected<void> Engine::set_culler(CullerChoice choice) {
  EngineConfig changed = config();
  changed.culling.culler = choice;
  return configure(changed);
}

core::Expected<void> Engine::configure(const EngineConfig& config) {
  EngineState& s = *state_;
  if (auto good = check(config); !good) return good;
  if (const char* fixed = fixed_setting_that_differs(s.config, config))
    return core::fail(std::string("engine: another engine is needed for another ") + fixed +
                      "; resize() and use_context() change size and context");
  const EngineConfig before = std::exchange(s.config, config);
  s.config.culling.controller.rendering = config.draw;
  const CullerChoice culler_before = s.live.plan.culler;
  s.live.follow_plan(plan_request(s));
  if (auto done = follow_plan_in_context(s, false); !done) {
    s.config = before;
    s.live.follow_plan(plan_request(s));
    note_context(s);
    return done;
  }
  s.backend->configure(s.config);
  if (s.next_backend) s.next_backend->configure(s.config);
  const bool same_culler = s.live.plan.culler == culler_before;
  if (!same_culler) abandon_rebuild(s);  // it would land with the former culler
  if (same_culler && cost_alike(before, s.config)) return {};
  s.hybrid.reset();
  follow_hybrid(s);
  return {};
}

core::Expected<void> resize(EngineState& s, int width, int height) {
  const auto kept = s.keep_state();
  if (s.config.draw)
    if (auto done = unless_lost(s, s.backend->resize(width, height)); !done) return done;
  if (s.next_backend && s.config.draw)
    if (auto done = s.next_backend->resize(width, height); !done) {
      const bool lost = s.next_backend->lost();
      s.next_backend.reset();
      if (!lost) return done;
    }
  s.config.width = width;
  s.config.height = height;
  return {};
}

core::Expected<void> Engine::resize(int width, int height) {
  return engine::resize(*state_, width, height);
}

// --- images ----------------------------------------------------------------------------------------------------------

core::Expected<void> switch_image(EngineState& s, std::uint32_t number) {
  const auto kept = s.keep_state();
  const std::pair before(s.config.width, s.config.height);
  const auto known = s.image_sizes.find(number);
  const auto [width, height] = known != s.image_sizes.end() && number != s.image ? known->second : before;
  if (auto done = unless_lost(s, s.backend->use_image(number, width, height)); !done) return done;
  s.image_sizes[s.image] = before;
  s.image = number;
  s.config.width = width, s.config.height = height;
  return {};
}

core::Expected<void> Engine::use_image(std::uint32_t number) {
  return switch_image(*state_, number);
}

core::Expected<void> Engine::forget_image(std::uint32_t number) {
  if (number == state_->image)
    return core::fail("engine: forget_image: expected an image that is not in use, found " + std::to_string(number));
  state_->image_sizes.erase(number);
  if (!state_->backend->ready()) return {};
  const auto kept = state_->keep_state();
  state_->backend->forget_image(number);
  return {};
}

// --- reports ---------------------------------------------------------------------------------------------------------

std::string Engine::renderer() {
  const auto kept = state_->keep_state();
  Backend& backend = *state_->backend;
  if (traces_until_context(config())) return "";
  return backend.traces() || backend.drawing() ? backend.report().renderer : std::string();
}

std::vector<std::string> Engine::take_gl_errors() {
  const auto kept = state_->keep_state();
  return state_->backend->take_gl_errors();
}

MemoryReport Engine::memory() const {
  const EngineState& s = *state_;
  MemoryReport report;
  report.scene = s.scene->memory_bytes();
  report.snapshot = s.overrides.memory_bytes();
  for (const SceneVersion* version : {&s.live, s.incoming ? &*s.incoming : nullptr}) {
    if (!version) continue;
    report.snapshot += version->snapshot->memory_bytes() + version->joints.memory_bytes();
    if (const auto* culler = std::get_if<culling::CpuCuller>(version->culler.get()))
      report.bvh += culler->memory_bytes();
    report.tracer += tracer_bytes(*version);
  }
  const BackendReport drawn = s.backend->report();
  report.gpu = drawn.gpu_bytes;
  report.levels = drawn.levels_bytes;
  report.tracer += drawn.points_bytes;
  report.scratch = core::scratch_bytes();
  return report;
}

void Engine::paused() {
  state_->last_frame_began = -1.0;
  if (state_->hybrid) state_->hybrid->paused();
}

core::Expected<void> Engine::finish_levels() {
  const auto kept = state_->keep_state();
  if (auto followed = make_gpu_follow(*state_); !followed) return followed;
  return unless_lost(*state_, state_->backend->finish_levels());
}

void Engine::finish() {
  const auto kept = state_->keep_state();
  state_->backend->finish();
}

}  // namespace sightline::engine
