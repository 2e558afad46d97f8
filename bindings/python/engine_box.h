// An engine, its scene and its context, as Python holds them.
#pragma once

#include <memory>
#include <optional>

#include "sightline/bindings/python/progress.h"
#include "sightline/bindings/python/scene.h"
#include "sightline/engine/engine.h"
#include "sightline/gl/context.h"

namespace sightline::python {

/// After close() all calls fail.
class EngineBox {
 public:
  /// `get_proc`: None, or of the application's context, which is current.
  EngineBox(ScenePtr scene, engine::EngineConfig config, const py::object& get_proc, const py::object& progress);
  /// Calls no GL for an application's context: Python ends objects on any thread.
  ~EngineBox();
  EngineBox(const EngineBox&) = delete;
  EngineBox& operator=(const EngineBox&) = delete;

  void close();
  bool closed();
  const ScenePtr& scene() const { return scene_; }
  int width() const { return width_; }
  int height() const { return height_; }

  /// What `work` returns for the engine, called without the GIL. `scene_use`: what it does with the scene.
  template <class Work>
  auto call(const Work& work, Use scene_use = Use::kRead) {
    const LongCall use({gate_, Use::kWrite}, {scene_->gate, scene_use});
    if (!engine_) fail("engine: it is closed");
    return work(*engine_);
  }

  void resize(int width, int height);
  /// Within call(): the image may have another size now.
  void note_size(const engine::Engine& engine);

  void drop_context();
  void abandon_context();
  /// Whether everything is made. Nothing for `seconds`: at once. While a context is being taken in portions, `get_proc`
  /// is not looked at.
  bool use_context(const py::object& get_proc, std::optional<double> seconds);

 private:
  ScenePtr scene_;
  Gate gate_;
  int width_, height_;  // of the image, in pixels
  // The application's contexts, which the engine must not outlive: the one it draws with, and the one it is taking.
  std::unique_ptr<gl::Context> context_, next_context_;
  bool context_in_use_ = false;  // neither dropped nor abandoned
  std::optional<engine::Engine> engine_;
};

}  // namespace sightline::python
