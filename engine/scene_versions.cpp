// Functions of Engine about edits and the order of the items.
#include <algorithm>
#include <utility>

#include "sightline/core/internal/access.h"
#include "sightline/core/internal/sort_unique.h"
#include "sightline/engine/internal/device_constants.h"
#include "sightline/engine/internal/engine_state.h"

namespace sightline::engine {
namespace {

constexpr double kFewSlots = 256.0;           // fewer are not worth a thread
constexpr std::size_t kCommittedPiece = 256;  // edits at a time, where a commit goes on later
constexpr double kShareOfSnapshot = 0.75;     // of the time that making an engine takes
// Frames and commits work so long for a new scene version that is to land: seconds, and a share of what the last frame
// took.
constexpr double kLeastPortion = 0.001, kLongestPortion = 0.008, kPortionShare = 0.25;

/// Adds slots below `size`, so that each is there once.
void add_slots(std::span<const core::Slot> slots, std::size_t size, std::vector<core::Slot>& touched) {
  for (const core::Slot slot : slots)
    if (slot < size) touched.push_back(slot);
  core::sort_unique(touched);
}

/// Takes some edits out of a delta, of which removals come first.
core::SceneDelta first_of(core::SceneDelta& delta) {
  core::SceneDelta piece;
  piece.materials = std::exchange(delta.materials, {});
  std::size_t room = kCommittedPiece;
  for (const auto list : {&core::SceneDelta::removed, &core::SceneDelta::changed, &core::SceneDelta::inserted}) {
    std::vector<core::ItemId>&from = delta.*list, &to = piece.*list;
    const auto count = std::ptrdiff_t(std::min(room, from.size()));
    to.assign(from.end() - count, from.end());
    from.erase(from.end() - count, from.end());
    room -= std::size_t(count);
  }
  return piece;
}

/// Remembers for picks which nodes hold these items. Items keep their nodes. With headroom, as a snapshot has it.
void note_nodes([[maybe_unused]] EngineState& s, [[maybe_unused]] std::span<const core::ItemId> items) {
#if SIGHTLINE_HAS_RAYTRACE
  const std::size_t slots = s.scene->item_slots();
  if (s.nodes.empty()) s.nodes.reserve(slots + slots * 3 / 8);
  s.nodes.resize(slots);
  for (const core::ItemId item : items)
    if (s.scene->contains_item(item)) s.nodes[to_index(item)] = s.scene->node_of(item);
#endif
}

/// All ids that the scene has given, those of removed items included.
std::vector<core::ItemId> all_ids(const core::Scene& scene) {
  std::vector<core::ItemId> ids(scene.item_slots());
  for (std::uint32_t i = 0; i < ids.size(); ++i) ids[i] = core::ItemId{i};
  return ids;
}

/// Updates everything that depends on the plan and on the order of the items, except the CPU culler.
core::Expected<void> follow_order(EngineState& s) {
  auto done = follow_plan_in_context(s, true);
  follow_hybrid(s);
  return done;
}

/// Works a little on what the backend needs for the new scene version. Whether it has all.
core::Expected<bool> prepare_incoming(EngineState& s, double most_seconds) {
  if (s.backend->lost()) drop_context(s);
  const double seconds =
      std::min(std::clamp(kPortionShare * s.frame_seconds, kLeastPortion, kLongestPortion), most_seconds);
  auto done = s.backend->advance_version(*s.incoming->snapshot, s.incoming->joints, s.live.plan.gpu_culls(),
                                         core::deadline_in(seconds));
  if (!done && s.backend->lost()) {
    drop_context(s);
    return true;
  }
  if (!done) abandon_rebuild(s);
  return done;
}

culling::ControllerConfig controller_config(const EngineState& s) {
  culling::ControllerConfig config = s.config.culling.controller;
  double& excess = config.presumed_gpu_excess;
  if (excess == 0.0 && s.backend->software()) excess = kSoftwareGpuExcess;
  return config;
}

}  // namespace

core::Expected<void> build(EngineState& s, const Engine::Progress& progress) {
  auto snapshot = std::make_unique<core::Snapshot>(*s.scene);
  note_nodes(s, all_ids(*s.scene));
  if (progress && !progress(kShareOfSnapshot)) return core::fail("engine: cancelled");
  s.overrides.restore(*snapshot);
  s.live = make_version(std::move(snapshot), plan_request(s));
  return follow_order(s);
}

core::Expected<void> land(EngineState& s, double most_seconds) {
  if (!s.rebuild) return {};
  if (s.rebuild->finished()) {
    s.rebuild.reset();
    return {};
  }
  if (!s.incoming) {
    SceneVersion made;
    if (!s.rebuild->take(made)) return {};
    s.incoming = std::move(made);
  }
  const auto kept = s.keep_state();
  const auto prepared = prepare_incoming(s, most_seconds);
  if (!prepared) return tl::unexpected(prepared.error());
  if (!*prepared) return {};
  s.new_tracer.interrupt(s.live);
  SceneVersion former = std::exchange(s.live, std::move(*s.incoming));
  s.incoming.reset();
  s.live.follow_plan(plan_request(s));  // settings may have changed since the rebuild began
  s.overrides.reorder(*s.live.snapshot);
  core::Expected<void> done;
  if (s.backend->ready()) {
    done = unless_lost(
        s, s.backend->take_version(*former.snapshot, *s.live.snapshot, s.live.joints, s.live.plan.gpu_culls()));
    s.gpu_behind = !done;
    note_context(s);
    follow_hybrid(s);
  } else {
    done = follow_order(s);
  }
  s.rebuild->retire(std::move(former));
  return done;
}

void abandon_rebuild(EngineState& s) {
  s.incoming.reset();
  s.rebuild.reset();
  s.backend->abandon_version();
}

void follow_in_incoming(EngineState& s, const core::SceneDelta& edited, std::span<const std::uint32_t> materials) {
  if (!s.incoming) return;
  std::vector<core::ItemId> items;
  for (const auto* list : {&edited.removed, &edited.changed, &edited.inserted})
    items.insert(items.end(), list->begin(), list->end());
  core::sort_unique(items);
  core::ItemCopies copies;
  core::copy_items(*s.live.snapshot, items, copies);
  s.backend->follow_later(catch_up(*s.incoming, items, copies), materials);
}

void follow_hybrid(EngineState& s) {
  const std::size_t items = s.live.snapshot->size();
  if (s.live.plan.culler != CullerChoice::kHybrid)
    s.hybrid.reset();
  else if (s.hybrid)
    s.hybrid->scene_changed(items);
  else
    s.hybrid.emplace(controller_config(s), items, s.frames);
  if (s.hybrid && (!s.backend->ready() || s.backend->traces())) s.hybrid->gpu_lost();
}

namespace {

/// Begins a rebuild in the background where edits have left too many slots vacant or out of order.
void rebuild_when_disordered(EngineState& s) {
  const double disorder = double(s.live.snapshot->disorder()), share = s.config.culling.rebuild_share;
  if (!s.rebuild && share > 0.0 && disorder > kFewSlots && disorder > share * double(s.live.snapshot->size()))
    s.rebuild = std::make_unique<BackgroundRebuild>(*s.live.snapshot, plan_request(s));
}

/// Shows what the scene now has of the edited items.
core::Expected<void> follow(EngineState& s, core::SceneDelta delta, core::Deadline deadline) {
  s.new_tracer.interrupt(s.live);
  if (s.config.culling.part.count > 1) return build(s);
  note_nodes(s, delta.inserted);
  const std::size_t former_size = s.live.snapshot->size();
  std::vector<core::Slot> touched;
  Overrides::Change overridden;
  const auto apply = [&] {
    touched = s.live.snapshot->apply(delta);
    overridden = s.overrides.follow(*s.live.snapshot, delta, touched);
    for (const core::Slot slot : overridden.touched) delta.changed.push_back(s.live.snapshot->item(slot));
  };
  s.rebuild ? s.rebuild->edit(delta, apply) : apply();
  if (!overridden.touched.empty()) add_slots(overridden.touched, former_size, touched);
  s.live.follow({delta.removed, delta.changed, delta.inserted, overridden.uncovered}, !delta.materials.empty(),
                former_size, touched);
  s.new_tracer.follow(s.live);
  const bool items_edited = delta.size() > delta.materials.size();  // materials do not change what frames cost
  if (s.hybrid && items_edited) s.hybrid->scene_changed(s.live.snapshot->size());
  rebuild_when_disordered(s);
  if (s.live.snapshot->size() > former_size && !s.draws_by_rays())
    plan_programs(s.live.plan, *s.live.snapshot, s.config.draw, "drawing is off");
  delta.materials.insert(delta.materials.end(), overridden.materials.begin(), overridden.materials.end());
  follow_in_incoming(s, delta, delta.materials);
  if (s.next_backend) s.next_backend->follow_later(touched, delta.materials);
  if (!s.backend->ready()) return {};
  const auto kept = s.keep_state();
  return update_backend(s, [&] {
    s.meshes_left = deadline != core::kNoDeadline;
    return s.backend->update(Backend::Edit::kItems, *s.live.snapshot, s.live.joints, touched, delta.materials,
                             deadline);
  });
}

/// Uploads meshes that follow() has left to later portions. Whether none are left.
core::Expected<bool> upload_meshes_left(EngineState& s, core::Deadline deadline) {
  if (!s.meshes_left || !s.backend->ready()) return true;
  const auto kept = s.keep_state();
  const auto done = update_backend(s, [&]() -> core::Expected<void> {
    const auto all = s.backend->upload_meshes(deadline);
    if (!all) return tl::unexpected(all.error());
    s.meshes_left = !*all;
    return {};
  });
  if (!done) return tl::unexpected(done.error());
  return !s.meshes_left;
}

/// Publishes and follows all that is edited, as a whole.
core::Expected<void> commit(EngineState& s) {
  if (auto published = s.scene->commit(); !published) return tl::unexpected(published.error());
  for (;;) {
    core::SceneDelta delta = s.edits_left.empty() ? s.edits.take() : std::exchange(s.edits_left, {});
    if (delta.empty()) break;
    if (auto done = follow(s, std::move(delta), core::kNoDeadline); !done) return done;
  }
  return upload_meshes_left(s, core::kNoDeadline).map([](bool) {});
}

/// Commits in pieces, which are published when those before are followed.
core::Expected<bool> commit(EngineState& s, core::Deadline deadline) {
  for (;;) {
    if (s.edits_left.empty()) {
      const auto published = core::Access::publish(*s.scene, kCommittedPiece);
      if (!published) return tl::unexpected(published.error());
      s.edits_left = s.edits.take();
      if (s.edits_left.empty() && !core::Access::has_edits(*s.scene)) return upload_meshes_left(s, deadline);
    }
    if (!s.edits_left.empty())
      if (auto done = follow(s, first_of(s.edits_left), deadline); !done) return tl::unexpected(done.error());
    if (core::over(deadline)) return false;
  }
}

}  // namespace

core::Expected<void> Engine::commit() {
  if (auto landed = land(*state_); !landed) return landed;
  return engine::commit(*state_);
}

core::Expected<bool> Engine::commit(double seconds) {
  const core::Deadline deadline = core::deadline_in(seconds);
  if (state_->config.culling.part.count > 1) return commit().map([] { return true; });
  if (auto landed = land(*state_, 0.5 * seconds); !landed) return tl::unexpected(landed.error());
  return engine::commit(*state_, deadline);
}

core::Expected<void> Engine::rebuild() {
  EngineState& s = *state_;
  if (auto delta = s.scene->commit(); !delta) return tl::unexpected(delta.error());
  s.edits = s.scene->subscribe();  // the new snapshot shows all edits
  s.edits_left = {};
  s.new_tracer.interrupt(s.live);
  abandon_rebuild(s);
  return build(s);
}

bool Engine::rebuilding() const {
  return state_->rebuild && !state_->rebuild->finished();
}

}  // namespace sightline::engine
