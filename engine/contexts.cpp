// The engine and its context: made, lost, dropped, and given by the application, at once or in portions.
#include <cassert>
#include <limits>
#include <tuple>
#include <utility>

#include "sightline/core/internal/deadline.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/internal/clock.h"
#include "sightline/engine/internal/engine_impl.h"

namespace sightline::engine {
namespace {

constexpr double kTryAgain = 0.5;  // seconds between tries to make a context

}  // namespace

/// Makes what the plan needs in the context: everything for a new order of the items or a new context, otherwise what
/// is missing. Does nothing while the context is lost.
core::Expected<void> Engine::Impl::make_drawing(bool new_order) {
  if (new_order) coming_.reset();
  if (!needs_gl()) {
    drawing_.reset();
    return {};
  }
  [[maybe_unused]] const auto kept = keep_state();
  core::Expected<void> done;
  const bool gpu_culls = live_.plan.gpu_culls();
  if (drawing_) {
    if (new_order)
      done = unless_lost(drawing_->rebuild(*live_.snapshot, live_.joints, gpu_culls));
    else if (gpu_culls)
      done = unless_lost(drawing_->add_culler(*live_.snapshot));
  } else if (next_try_ < 0.0) {
    auto drawing = Drawing::create(*live_.snapshot, live_.joints, config_, overrides_, gpu_culls);
    if (!drawing) return tl::unexpected(drawing.error());
    drawing_ = std::move(*drawing);
  }
  if (drawing_ && done) done = unless_lost(drawing_->use_picture(picture_, config_.width, config_.height));
  note_context();
  return done;
}

/// Detects a lost context, and tries to replace it if the engine made it.
void Engine::Impl::look_after_context() {
  if (drawing_ && drawing_->lost()) drop_context();
  if (next_try_ < 0.0 || config_.context || now_seconds() < next_try_ || !needs_gl()) return;
  next_try_ = -1.0;
  if (make_drawing(true)) {
    if (hybrid_) hybrid_->gpu_ready();
  } else {
    next_try_ = now_seconds() + kTryAgain;
  }
}

/// Ignores an error that comes from losing the context: the next frame handles the loss.
core::Expected<void> Engine::Impl::unless_lost(core::Expected<void> done) const {
  if (!done && drawing_->lost()) return {};
  return done;
}

void Engine::Impl::drop_context() {
  drawing_.reset();
  coming_.reset();
  next_try_ = config_.context_later ? std::numeric_limits<double>::infinity() : 0.0;
  if (hybrid_) hybrid_->gpu_lost();
}

core::Expected<void> Engine::Impl::use_context(gl::Context& context) {
  if (drawing_ && drawing_->lost()) drop_context();
  assert(!drawing_ && "the other context is still in use: drop_context()");
  return take_context(context, nullptr);
}

core::Expected<bool> Engine::Impl::use_context(gl::Context& context, double seconds) {
  if (drawing_ && drawing_->lost()) drop_context();
  assert(!drawing_ && "the other context is still in use: drop_context()");
  if (coming_ && (coming_in_ != &context || coming_->lost())) coming_.reset();
  const auto taken = [] { return true; };
  if (!needs_gl()) return take_context(context, nullptr).map(taken);
  const core::Deadline deadline = core::deadline_in(seconds);
  if (!coming_) {
    EngineConfig config = config_;
    config.context = &context;
    auto begun = Drawing::begin(config, overrides_);
    if (!begun) return tl::unexpected(begun.error());
    coming_ = std::move(*begun);
    coming_in_ = &context;
    if (coming_->lost()) {
      coming_.reset();
      return core::fail("engine: the context is lost");
    }
  }
  auto done = coming_->advance(*live_.snapshot, live_.joints, live_.plan.gpu_culls(), deadline);
  if (done && !*done) return false;
  if (done && coming_->lost()) done = core::fail("engine: the context is lost");
  if (!done) {
    coming_.reset();
    return done;
  }
  return take_context(context, std::move(coming_)).map(taken);
}

/// `made`: all that there is to draw; null: it is made now.
core::Expected<void> Engine::Impl::take_context(gl::Context& context, std::unique_ptr<Drawing> made) {
  coming_.reset();
  const auto before = std::pair(config_.context, next_try_);
  config_.context = &context;
  next_try_ = -1.0;
  const bool new_order = !made;
  drawing_ = std::move(made);
  if (auto done = make_drawing(new_order); !done) {
    drawing_.reset();
    std::tie(config_.context, next_try_) = before;
    return done;
  }
  if (std::exchange(config_.context_later, false)) {
    hybrid_.reset();  // what it presumes depends on the context
    follow_hybrid();
  }
  if (hybrid_) hybrid_->gpu_ready();
  return {};
}

/// Adds to the plan what is known only once there is a context: how it was made, and the variant of the GPU culler.
void Engine::Impl::note_context() {
  if (!drawing_) return;
  add_context(live_.plan, !config_.context, drawing_->platform());
  if (!live_.plan.gpu_culls()) return;
  if (const auto variant = drawing_->gpu_variant()) add_gpu_variant(live_.plan, *variant, drawing_->why_gpu_variant());
}

}  // namespace sightline::engine
