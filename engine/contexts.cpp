// The engine and its context: made, lost, dropped, and given by the application, at once or in portions.
#include <cassert>
#include <limits>
#include <tuple>
#include <utility>

#include "sightline/core/internal/clock.h"
#include "sightline/core/internal/store.h"
#include "sightline/engine/internal/engine_state.h"
#include "sightline/engine/internal/settings.h"

namespace sightline::engine {
namespace {

constexpr double kTryAgain = 0.5;  // seconds between tries to make a context

/// Makes a backend that shows the live order.
core::Expected<std::unique_ptr<Backend>> make_complete_backend(const EngineState& s) {
  auto made = make_backend(s.config, s.overrides);
  if (!made) return made;
  const auto kept = (*made)->keep_state();
  auto done = (*made)->rebuild(*s.live.snapshot, s.live.joints, s.live.plan.gpu_culls());
  if (!done) return tl::unexpected(done.error());
  return made;
}

}  // namespace

core::Expected<void> follow_plan_in_context(EngineState& s, bool new_version) {
  if (new_version) s.next_backend.reset();
  if (!s.needs_backend()) {
    s.backend = std::make_unique<Backend>();
    return {};
  }
  const auto kept = s.keep_state();
  core::Expected<void> done;
  const bool gpu_culls = s.live.plan.gpu_culls();
  if (s.backend->ready()) {
    if (new_version) {
      done = unless_lost(s, s.backend->rebuild(*s.live.snapshot, s.live.joints, gpu_culls));
      s.gpu_behind = !done;
    } else if (gpu_culls) {
      done = unless_lost(s, s.backend->add_culler(*s.live.snapshot));
    }
  } else if (s.next_try < 0.0 || traces_until_context(s.config)) {
    const bool by_rays = s.draws_by_rays();
    done = core::store(make_complete_backend(s), s.backend);
    if (!done) return done;
    if (s.draws_by_rays() != by_rays) s.live.follow_plan(plan_request(s));  // there is no GL
  }
  if (done) done = unless_lost(s, s.backend->use_image(s.image, s.config.width, s.config.height));
  note_context(s);
  return done;
}

core::Expected<void> make_gpu_follow(EngineState& s) {
  return s.gpu_behind ? follow_plan_in_context(s, true) : core::Expected<void>();
}

void look_after_context(EngineState& s) {
  if (s.backend->lost()) drop_context(s);
  if (s.next_try < 0.0 || s.config.context.application || core::now_seconds() < s.next_try || !s.needs_gl()) return;
  s.next_try = -1.0;
  if (follow_plan_in_context(s, true)) {
    if (s.hybrid) s.hybrid->gpu_ready();
  } else {
    s.next_try = core::now_seconds() + kTryAgain;
  }
}

core::Expected<void> unless_lost(const EngineState& s, core::Expected<void> done) {
  if (!done && s.backend->lost()) return {};
  return done;
}

void drop_context(EngineState& s) {
  s.backend = std::make_unique<Backend>();
  s.gpu_behind = false;
  s.next_backend.reset();
  s.next_try = s.config.context.later ? std::numeric_limits<double>::infinity() : 0.0;
  if (s.hybrid) s.hybrid->gpu_lost();
}

void note_context(EngineState& s) {
  if (!s.backend->ready() || traces_until_context(s.config)) return;
  const BackendReport report = s.backend->report();
  if (s.backend->traces()) return set_entry(s.live.plan, {"images by rays", true, report.why_rays});
  add_context(s.live.plan, !s.config.context.application, report.platform);
  if (!s.live.plan.gpu_culls()) return;
  if (report.gpu_variant) add_gpu_variant(s.live.plan, *report.gpu_variant, report.why_gpu_variant);
}

namespace {

/// Draws in a context of the application's from now on. `made`: a backend that has everything to draw; null: it is made
/// now.
core::Expected<void> take_context(EngineState& s, gl::Context& context, std::unique_ptr<Backend> made) {
  s.next_backend.reset();
  const auto before = std::tuple(s.config.context.application, s.config.context.later, s.next_try);
  s.config.context.application = &context;
  const bool first = std::exchange(s.config.context.later, false);
  s.next_try = -1.0;
  const bool new_version = !made;
  s.backend = made ? std::move(made) : std::make_unique<Backend>();
  if (auto done = follow_plan_in_context(s, new_version); !done) {
    s.backend = std::make_unique<Backend>();
    std::tie(s.config.context.application, s.config.context.later, s.next_try) = before;
    if (traces_until_context(s.config)) (void)core::store(make_backend(s.config, s.overrides), s.backend);
    return done;
  }
  if (first) {
    s.hybrid.reset();  // what it presumes depends on the context
    follow_hybrid(s);
  }
  if (s.hybrid) s.hybrid->gpu_ready();
  return {};
}

core::Expected<void> begin_next_backend(EngineState& s, gl::Context& context) {
  EngineConfig config = s.config;
  config.context.application = &context;
  config.context.later = false;
  auto begun = make_backend(config, s.overrides);
  if (!begun) return tl::unexpected(begun.error());
  if ((*begun)->lost()) return core::fail("engine: the context is lost");
  s.next_backend = std::move(*begun);
  return {};
}

}  // namespace

void Engine::drop_context() {
  engine::drop_context(*state_);
}

core::Expected<void> Engine::use_context(gl::Context& context) {
  if (state_->draws_by_rays()) return core::fail("engine: renderer rays draws without a context");
  if (state_->backend->lost()) drop_context();
  assert((!state_->backend->ready() || traces_until_context(config())) &&
         "the other context is still in use: drop_context()");
  return take_context(*state_, context, nullptr);
}

core::Expected<bool> Engine::use_context(gl::Context& context, double seconds) {
  EngineState& s = *state_;
  if (s.draws_by_rays()) return core::fail("engine: renderer rays draws without a context");
  if (s.backend->lost()) drop_context();
  assert((!s.backend->ready() || traces_until_context(s.config)) &&
         "the other context is still in use: drop_context()");
  if (s.next_backend && (s.next_backend->report().application != &context || s.next_backend->lost()))
    s.next_backend.reset();
  const auto taken = [] { return true; };
  if (!s.needs_gl()) return take_context(s, context, nullptr).map(taken);
  const core::Deadline deadline = core::deadline_in(seconds);
  if (!s.next_backend)
    if (auto begun = begin_next_backend(s, context); !begun) return tl::unexpected(begun.error());
  auto done = s.next_backend->advance(*s.live.snapshot, s.live.joints, s.live.plan.gpu_culls(), deadline);
  if (done && !*done) return false;
  if (done && s.next_backend->lost()) done = core::fail("engine: the context is lost");
  if (!done) {
    s.next_backend.reset();
    return done;
  }
  return take_context(s, context, std::move(s.next_backend)).map(taken);
}

}  // namespace sightline::engine
