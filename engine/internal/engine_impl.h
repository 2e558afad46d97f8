// The engine behind Engine. Its functions are in engine.cpp, those about contexts in contexts.cpp, and those that ask
// something between frames in queries.cpp. Internal to engine.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sightline/core/internal/deadline.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/internal/drawing_or_none.h"
#include "sightline/engine/internal/hybrid.h"
#include "sightline/engine/internal/overrides.h"
#include "sightline/engine/internal/picking.h"
#include "sightline/engine/internal/rebuild.h"

namespace sightline::engine {

/// Engine documents each function.
class Engine::Impl {
 public:
  Impl(core::Scene& scene, const EngineConfig& config);

  /// Builds everything that the plan names. The scene must be committed.
  core::Expected<void> build(const Progress& progress = {});
  core::Expected<FrameReport> frame(const core::View& view, const core::View& cull_view,
                                    const core::ExternalTarget* target);
  core::Expected<std::vector<FrameReport>> frame(std::span<const core::View> views,
                                                 std::span<const core::ExternalTarget> targets);
  core::Expected<void> use_picture(std::uint32_t number);
  core::Expected<void> forget_picture(std::uint32_t number);
  core::Expected<LossReport> loss(const core::View& view);
  core::Expected<culling::CullStates> cull_states(const core::View& view);
  core::Expected<FrameReport> frame_part(const core::View& whole, const PicturePart& part);
  std::optional<LateReport> take_late_report();
  /// Whether all edits are followed.
  core::Expected<bool> commit(core::Deadline deadline);
  core::Expected<void> rebuild();
  bool rebuilding() const { return rebuild_ && !rebuild_->finished(); }
  const EngineConfig& config() const { return config_; }
  core::Expected<void> configure(const EngineConfig& config);
  core::Expected<void> resize(int width, int height);
  core::Expected<void> set_override(std::span<const core::ItemId> items, const ItemStyle& style);
  core::Expected<void> clear_override(std::span<const core::ItemId> items);
  core::Expected<void> clear_overrides();
  core::Expected<void> hide(std::span<const core::ItemId> items);
  core::Expected<void> show(std::span<const core::ItemId> items);
  core::Expected<void> isolate(std::span<const core::NodeId> nodes);
  core::Expected<void> show_all();
  const Overrides& overrides() const { return overrides_; }
  core::Expected<std::vector<core::ItemId>> items_below(std::span<const core::NodeId> nodes) const;
  void drop_context();
  core::Expected<void> use_context(gl::Context& context);
  core::Expected<bool> use_context(gl::Context& context, double seconds);
  void paused();
  void finish();
  const Plan& plan() const { return live_.plan; }
  const core::Snapshot& snapshot() const { return *live_.snapshot; }
  const gpuprims::Joints& joints() const { return live_.joints; }
  const core::VisibleSet& visible() const { return visible_; }
  const culling::Controller* controller() const { return hybrid_ ? &hybrid_->controller() : nullptr; }
  Drawing* drawing();
  /// Held where GL is called, so that calls which need no GL do not ask it.
  Drawing::KeptState keep_state() const {
    if (drawing_) return drawing_->keep_state();
    const bool changes_context = needs_gl() && !config_.context && config_.gl_state == GlState::kRestore;
    return changes_context ? Drawing::keep_current() : Drawing::KeptState();
  }
  MemoryReport memory() const;
  /// Fails, naming the call, where an item is unknown as of the last commit().
  core::Expected<void> known(const char* call, std::span<const core::ItemId> items) const;
  core::Expected<std::vector<core::ItemId>> items_in(const core::View& view, const PixelRectangle& rectangle,
                                                     culling::RegionRule rule) const;
  std::vector<core::ItemId> items_in(const core::View& volume, culling::RegionRule rule) const;
#if SIGHTLINE_HAS_RAYTRACE
  core::Expected<std::vector<raytrace::VisibleItem>> visible_items_in(const core::View& view,
                                                                      const PixelRectangle& rectangle, int samples);
  void prepare_picks() {
    picks_ = true;
    new_tracer_.begin(live_);
  }
  bool preparing_picks() const {
    return !new_tracer_.ready();
  }
  core::Expected<std::optional<Pick>> pick(const core::View& view, double x, double y, Ghosts ghosts);
  core::Expected<std::optional<Pick>> pick(const raytrace::Ray& ray, const raytrace::RayFilter& filter, Ghosts ghosts);
#endif

 private:
  bool needs_gl() const {
    return config_.draw || live_.plan.gpu_culls();
  }
  void follow_hybrid();
  culling::ControllerConfig controller_config() const;
  core::Expected<void> make_drawing(bool new_order);
  void look_after_context();
  core::Expected<void> fit_target(const core::ExternalTarget& target);
  core::Expected<FrameReport> frame(const core::View& view, const core::View& cull_view,
                                    const core::ExternalTarget* target, double began);
  core::Expected<void> unless_lost(core::Expected<void> done) const;
  core::Expected<void> follow(core::SceneDelta delta);
  core::Expected<void> land();
  core::Expected<bool> prepare_landing();
  void abandon_rebuild();
  void follow_in_landing(const core::SceneDelta& edited, std::span<const std::uint32_t> materials);
  core::Expected<void> follow_order();
  core::Expected<void> take_context(gl::Context& context, std::unique_ptr<Drawing> made);
  void note_context();
  void note_nodes(std::span<const core::ItemId> inserted);
  void note_all_nodes();
  template <class Edit>
  core::Expected<void> override_items(const Edit& edit);
  core::Expected<bool> cull(const core::View& cull_view, const core::View& view, bool on_cpu, FrameReport& report);
  void cull_on_cpu(const core::View& view, FrameReport& report);
  culling::FrameSample describe_walk() const;
  void gather_late_reports();

  core::Scene* scene_;
  core::SceneSubscription edits_;
  core::SceneDelta edits_left_;  // that a commit in portions has taken and not followed
  EngineConfig config_;
  Order live_;
  std::optional<Order> landing_;  // a new order, for which the drawing makes what it lacks
  Overrides overrides_;
  core::VisibleSet visible_;
  core::VisibleSet overlaid_;  // what is visible where the GPU culls, for what is drawn over its picture
  std::uint32_t picture_ = 0;  // in use, of the size of config_
  std::map<std::uint32_t, std::pair<int, int>> sizes_;  // of the others
  std::unique_ptr<Drawing> drawing_;
  std::unique_ptr<Drawing> coming_;         // that use_context() makes in portions, while there is no drawing_
  const gl::Context* coming_in_ = nullptr;  // the context of it
  double next_try_ = -1.0;                  // when to try to make a context, in seconds; below 0: none is missing
  double last_frame_began_ = -1.0;          // seconds on the steady clock
  double frame_seconds_ = 0.0;              // that the last frame took
  std::uint64_t frames_ = 0;
  bool picks_ = false;  // the application has picked
#if SIGHTLINE_HAS_RAYTRACE
  core::LargeArray<core::NodeId> nodes_;  // by item: that holds it, so that picks do not read the scene
#endif
  std::optional<Hybrid> hybrid_;
  std::deque<LateReport> late_;
  // Last: they read live_ until they are destroyed.
  BackgroundTracer new_tracer_;
  std::unique_ptr<BackgroundRebuild> rebuild_;
};

}  // namespace sightline::engine
