// engine: the conductor an application embeds. Takes a committed scene, plans what it needs, and per view culls and
// draws it.
//
//   core::Scene scene = …;
//   auto engine = engine::Engine::create(scene, {.draw = true, .width = 1280, .height = 720});
//   auto report = engine->frame(view);
//   write_png(engine->drawing()->target().read_colour(), "out.png");
#pragma once

#include <memory>
#include <variant>

#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/cpu_culler.h"
#include "sightline/culling/linear_culler.h"
#include "sightline/engine/plan.h"

namespace sightline::gl {
class Context;
}

namespace sightline::engine {

class Drawing;

struct EngineConfig {
  CullerChoice culler = CullerChoice::kAutomatic;
  bool draw = false;  ///< false: no GL at all
  int width = 1280, height = 720;
  bool ids = false;       ///< item-id image beside colour and depth
  bool gl_debug = false;  ///< collect driver messages; slower
  gl::Context* context =
      nullptr;  ///< a current context to draw with, owned by the application; null: one is made offscreen
  double chord_tolerance = 2e-5;  ///< metres, for the kinds that are tessellated
};

/// Times in milliseconds of wall clock.
struct FrameReport {
  double cull_ms = 0.0;  ///< the culler alone
  double draw_ms =
      0.0;  ///< waiting for the frame before the last, making and submitting the draw lists; 0 without drawing
  double frame_ms = 0.0;  ///< since the last frame began, at most two frames being in flight; 0 for the first frame
  std::uint64_t visible = 0, tested = 0;  ///< items; hierarchy and item boxes
};

struct MemoryReport {
  std::size_t scene = 0, snapshot = 0, bvh = 0, gpu = 0;  ///< bytes
};

class Engine {
 public:
  /// Commits the scene's pending edits and builds everything the plan names. The scene must outlive the engine. Fails
  /// with the scene's error, or GL's when drawing was asked for (also when this build has no GL).
  static core::Expected<Engine> create(core::Scene& scene, const EngineConfig& config = {});

  Engine(Engine&&) noexcept;
  Engine& operator=(Engine&&) noexcept;
  ~Engine();

  /// Culls and, when drawing is on, draws into drawing()->target() without waiting for it.
  core::Expected<FrameReport> frame(const core::View& view);

  /// Takes over the scene's edits since the last commit. Moves, hides and removals are refitted in place; insertions go
  /// to the culler's linear tail and rebuild what lies in GPU memory. rebuild() restores full speed after many.
  core::Expected<void> commit();
  core::Expected<void> rebuild();

  /// Waits until everything submitted is drawn.
  void finish();

  const Plan& plan() const { return plan_; }
  const core::Snapshot& snapshot() const { return *snapshot_; }
  const core::VisibleSet& visible() const { return visible_; }
  Drawing* drawing() { return drawing_.get(); }  ///< null when drawing is off
  MemoryReport memory() const;
  const char* culler_name() const { return std::holds_alternative<culling::LinearCuller>(*culler_) ? "linear" : "cpu"; }

 private:
  Engine(core::Scene& scene, const EngineConfig& config);
  core::Expected<void> build();

  core::Scene* scene_;
  EngineConfig config_;
  std::unique_ptr<core::Snapshot> snapshot_;  // at a fixed address: the cullers borrow its bounds
  std::unique_ptr<std::variant<culling::LinearCuller, culling::CpuCuller>> culler_;
  Plan plan_;
  core::VisibleSet visible_;
  std::unique_ptr<Drawing> drawing_;
  double last_frame_began_ = -1.0;  // seconds on the steady clock
};

}  // namespace sightline::engine
