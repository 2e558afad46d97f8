// The state behind Engine, and the functions on it that several source files share. Internal to engine.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "sightline/core/internal/deadline.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/internal/backend.h"
#include "sightline/engine/internal/hybrid.h"
#include "sightline/engine/internal/overrides.h"
#include "sightline/engine/internal/picking.h"
#include "sightline/engine/internal/rebuild.h"

namespace sightline::engine {

/// Plain state: Engine's functions work on it. engine.cpp has those about settings, frames.cpp those about frames,
/// scene_versions.cpp those about edits and the order of the items, styles.cpp those about what this engine shows
/// otherwise than the scene, contexts.cpp those about the context, and queries.cpp those that ask something between
/// frames.
struct EngineState {
  EngineState(core::Scene& scene, const EngineConfig& config);

  core::Scene* scene;
  core::SceneSubscription edits;
  core::SceneDelta edits_left;  // taken from `edits` by a commit in portions, and not followed yet
  EngineConfig config;
  SceneVersion live;
  std::optional<SceneVersion> incoming;  // a new scene version, for which the backend uploads what it lacks
  Overrides overrides;
  core::VisibleSet visible;
  core::VisibleSet overlaid;  // visible items where the GPU culls, for what is drawn over its image
  std::uint32_t image = 0;    // in use, of the size of `config`
  std::map<std::uint32_t, std::pair<int, int>> image_sizes;        // of the other images
  std::unique_ptr<Backend> backend = std::make_unique<Backend>();  // never null
  std::unique_ptr<Backend> next_backend;  // that use_context() makes in portions, while `backend` is not ready; or null
  bool meshes_left = false;               // a commit in portions may have left meshes to be uploaded
  bool gpu_behind = false;  // an update of the backend has failed: it shows the snapshot only once it is made anew
  double next_try = -1.0;   // when to try to make a context, in seconds; below 0: none is missing
  double last_frame_began = -1.0;  // seconds on the steady clock
  double frame_seconds = 0.0;      // duration of the last frame
  std::uint64_t frames = 0;
  bool picks = false;  // the application has picked
#if SIGHTLINE_HAS_RAYTRACE
  core::LargeArray<core::NodeId> nodes;  // by item: the node that holds it, so that picks do not read the scene
#endif
  std::optional<Hybrid> hybrid;
  std::deque<LateReport> late;
  // Last: they read `live` until they are destroyed.
  BackgroundTracer new_tracer;
  std::unique_ptr<BackgroundRebuild> rebuild;

  bool needs_backend() const {
    return config.draw || live.plan.gpu_culls();
  }
  bool draws_by_rays() const {
    return config.draw && (config.drawing.renderer == Renderer::kRays || (backend->traces() && !config.context.later));
  }
  bool needs_gl() const {
    return (config.draw && !draws_by_rays()) || live.plan.gpu_culls();
  }
  /// Held where GL is called, so that calls which need no GL do not ask it.
  std::unique_ptr<KeptState> keep_state() const;
  /// Whether a frame shows, in a colour of their own, the items that the image of its culling view would not show.
  bool shows_unseen(const core::View& view, const core::View& cull_view) const;
  /// A frame of the live scene.
  Frame frame(const core::View& view, const core::View& cull_view) const {
    return {view, cull_view, *live.snapshot, live.lines, live.hierarchy()};
  }
};

// --- engine.cpp ---
/// Arguments of the plan that the settings ask for.
PlanRequest plan_request(const EngineState& s);
core::Expected<void> resize(EngineState& s, int width, int height);
core::Expected<void> switch_image(EngineState& s, std::uint32_t number);

// --- scene_versions.cpp ---
/// Builds everything that the plan names. The scene must be committed.
core::Expected<void> build(EngineState& s, const Engine::Progress& progress = {});
/// Brings in a new scene version when one is ready and the backend has what it needs for it. Works for that for a part
/// of a frame's time, and for `most_seconds` at most.
core::Expected<void> land(EngineState& s, double most_seconds = 1.0);
void abandon_rebuild(EngineState& s);
/// Makes the hybrid culler follow the plan, the scene and the context.
void follow_hybrid(EngineState& s);
/// Makes a new scene version that is about to land follow an edit. `edited`: of the live order, which shows it already.
void follow_in_incoming(EngineState& s, const core::SceneDelta& edited, std::span<const std::uint32_t> materials);

// --- contexts.cpp ---
/// Makes what the plan needs in the context: everything for a new scene version or a new context, otherwise what
/// is missing. Does nothing while the context is lost.
core::Expected<void> follow_plan_in_context(EngineState& s, bool new_version);
/// Makes everything anew where the backend could not follow an edit.
core::Expected<void> make_gpu_follow(EngineState& s);
/// Ignores an error that comes from losing the context: the next frame handles the loss.
core::Expected<void> unless_lost(const EngineState& s, core::Expected<void> done);
/// Result of an update of the backend for an edit, which `update()` makes. Where an update fails, and where one has
/// failed before, everything is made anew instead, at once or by the next call that needs it.
template <class Update>
core::Expected<void> update_backend(EngineState& s, const Update& update) {
  if (s.gpu_behind) return make_gpu_follow(s);
  auto done = unless_lost(s, update());
  s.gpu_behind = !done;
  return done;
}
/// Detects a lost context, and tries to replace it if the engine made it.
void look_after_context(EngineState& s);
void drop_context(EngineState& s);
/// Adds to the plan what is known only once there is a context: how it was made, and the variant of the GPU culler.
void note_context(EngineState& s);

// --- styles.cpp ---
/// Fails, naming the call, where an item is unknown as of the last commit().
core::Expected<void> known(const EngineState& s, const char* call, std::span<const core::ItemId> items);

}  // namespace sightline::engine
