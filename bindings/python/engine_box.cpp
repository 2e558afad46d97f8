#include "sightline/bindings/python/engine_box.h"

#include <cmath>

#include "sightline/bindings/python/get_proc.h"
#include "sightline/core/internal/store.h"

namespace sightline::python {

using engine::CullerChoice;

EngineBox::EngineBox(ScenePtr scene, engine::EngineConfig config, const py::object& get_proc,
                     const py::object& progress)
    : scene_(std::move(scene)), width_(config.width), height_(config.height) {
  Progress told(progress);
  if (!get_proc.is_none()) context_ = adopt_context(get_proc);
  config.context.application = context_.get();
  core::Expected<void> done;
  {
    const LongCall call({gate_, Use::kWrite}, {scene_->gate, Use::kWrite});
    done = core::store(engine::Engine::create(scene_->scene, config, told.function()), engine_);
  }
  told.rethrow();
  unwrap(std::move(done));
  context_in_use_ = !config.context.later && (config.draw || config.culling.culler == CullerChoice::kGpu ||
                                              config.culling.culler == CullerChoice::kHybrid);
}

EngineBox::~EngineBox() {
  if (engine_) context_.reset(), next_context_.reset();  // what the engine has in them is lost to it: it frees nothing
}

void EngineBox::close() {
  const LongCall call({gate_, Use::kWrite});
  engine_.reset();
  next_context_.reset();
  context_.reset();
}

bool EngineBox::closed() {
  gate_.pass(Use::kRead);
  return !engine_;
}

void EngineBox::note_size(const engine::Engine& engine) {
  width_ = engine.config().width;
  height_ = engine.config().height;
}

void EngineBox::resize(int width, int height) {
  unwrap(call([&](engine::Engine& e) {
    auto done = e.resize(width, height);
    note_size(e);
    return done;
  }));
}

void EngineBox::drop_context() {
  call([&](engine::Engine& e) {
    e.drop_context();
    context_in_use_ = false;
    next_context_.reset();
  });
}

void EngineBox::abandon_context() {
  call([&](engine::Engine& e) {
    context_.reset();
    next_context_.reset();
    context_in_use_ = false;
    e.drop_context();
  });
}

bool EngineBox::use_context(const py::object& get_proc, std::optional<double> seconds) {
  if (seconds && std::isnan(*seconds)) fail("seconds: expected a number or None, found nan");
  if (closed()) fail("engine: it is closed");
  std::unique_ptr<gl::Context> adopted;
  if (!next_context_ && !context_in_use_) adopted = adopt_context(get_proc);
  return unwrap(call([&](engine::Engine& e) -> core::Expected<bool> {
    if (context_in_use_) return core::fail("engine: the former context is in use: drop or abandon it first");
    if (adopted) next_context_ = std::move(adopted);
    if (!next_context_) return core::fail("engine: another thread has dropped the context meanwhile");
    auto done =
        seconds ? e.use_context(*next_context_, *seconds) : e.use_context(*next_context_).map([] { return true; });
    if (!done) next_context_.reset();
    if (!done || !*done) return done;
    context_ = std::move(next_context_);
    context_in_use_ = true;
    return true;
  }));
}

}  // namespace sightline::python
