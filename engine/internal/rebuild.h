// A new scene version, made in the background while the old one stays in use. Internal to engine.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <thread>
#include <variant>
#include <vector>

#include "sightline/core/internal/snapshot_copies.h"
#include "sightline/core/internal/stopping.h"
#include "sightline/core/snapshot.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/frustum/linear_culler.h"
#include "sightline/engine/plan.h"
#include "sightline/gpuprims/internal/joints.h"

namespace sightline::raytrace {
class Tracer;
}

namespace sightline::engine {

using Culler = std::variant<culling::LinearCuller, culling::CpuCuller>;

/// Arguments of make_plan besides the snapshot and its joints.
struct PlanRequest {
  CullerChoice culler = CullerChoice::kAutomatic;
  bool draw = false, rays = false, ids = false;  // rays: they draw
  OcclusionChoice occlusion = OcclusionChoice::kAutomatic;
  bool contribution = false, budget = false;  // asked for; the CPU must then cull what is drawn
  bool levels = false;                        // of detail are asked for
  bool depth_shading = false, hatching = false, edges = false;
  bool pick = false;  // orders come with a tracer
  ScenePart part = {};

  bool needs_cpu() const { return draw && (contribution || budget); }
  bool draws_by_gl() const { return draw && !rays; }
};

/// A bit per slot; no words where there are none. Lines have a rule of their own for what they colour.
std::vector<std::uint64_t> slots_of_lines(const core::Snapshot& snapshot);

/// Everything that depends on one order of the items.
struct SceneVersion {
  std::unique_ptr<core::Snapshot> snapshot;  // at a fixed address: the culler borrows its bounds
  gpuprims::Joints joints;                   // none unless the request draws
  std::vector<std::uint64_t> lines;          // a bit per slot that holds a line; empty where none does
  std::unique_ptr<Culler> culler;
  std::shared_ptr<raytrace::Tracer> tracer;  // null before the first pick, or frame within a budget that traces
  Plan plan;

  /// Follows an edit of the snapshot, whose apply() has touched these slots: updates the joints, which adds to
  /// `touched`, and the culler. `edited`: items that were changed, removed or added. `materials`: whether any were
  /// edited. `former_size`: that of the snapshot.
  void follow(std::initializer_list<std::span<const core::ItemId>> edited, bool materials, std::size_t former_size,
              std::vector<core::Slot>& touched);
  /// Follows overrides of touched slots. `uncovered`: items that no longer cover the ends of others. `boxes`: whether
  /// the slots became vacant, or no longer are.
  void follow_overrides(std::span<const core::ItemId> uncovered, bool boxes, std::vector<core::Slot>& touched);
  /// Null unless the culler has one.
  const culling::Hierarchy* hierarchy() const {
    const auto* cpu = std::get_if<culling::CpuCuller>(culler.get());
    return cpu ? &cpu->hierarchy() : nullptr;
  }
  /// Makes a new plan, and the culler that it names unless there is one.
  void follow_plan(const PlanRequest& request);

 private:
  void follow_boxes(std::size_t former_size, std::span<const core::Slot> touched);
};

Plan make_plan(const core::Snapshot& snapshot, const gpuprims::Joints& joints, const PlanRequest& request);
/// `stop`: the result may then lack a tracer.
SceneVersion make_version(std::unique_ptr<core::Snapshot> snapshot, const PlanRequest& request,
                          const std::stop_token& stop = {});

/// Makes an order show its items as copies from another one do. Items that were removed must be in ItemCopies::removed,
/// even where others have got their ids. Returns the slots that were touched below the former size of its snapshot, in
/// rising order.
std::vector<core::Slot> catch_up(SceneVersion& version, std::span<const core::ItemId> edited,
                                 const core::ItemCopies& copies);

/// One rebuild. Its thread copies the live snapshot in pieces, builds from the copy, catches up with the edits made
/// meanwhile, and waits for take(). It never reads the scene. All calls must come from the thread that edits the
/// live snapshot.
class BackgroundRebuild {
 public:
  /// Starts at once. `live` must outlive the rebuild, or go to retire().
  BackgroundRebuild(const core::Snapshot& live, const PlanRequest& request);
  /// Stops the thread and waits for it, less than the time of one build.
  ~BackgroundRebuild() { core::request_stop(thread_, mutex_, changed_); }
  BackgroundRebuild(const BackgroundRebuild&) = delete;
  BackgroundRebuild& operator=(const BackgroundRebuild&) = delete;

  /// Calls `apply`, which edits the live snapshot by `delta`. Waits for the copy of one piece at most, well below a
  /// millisecond.
  void edit(const core::SceneDelta& delta, const std::function<void()>& apply);

  /// Gives away the new scene version if it is ready and shows all edits. From then on it follows edits by catch_up().
  /// Never waits for the build.
  bool take(SceneVersion& out);
  /// After take(): lets the background thread free the order that is no longer in use.
  void retire(SceneVersion&& old);
  /// True some time after retire(), when nothing is left to do: destroying the object then takes no time.
  bool finished() const { return finished_; }

 private:
  enum class State { kWorking, kReady, kTaken, kRetired };

  void run(const std::stop_token& stop, const PlanRequest& request);
  bool copy_all(const std::stop_token& stop, core::ItemCopies& items);
  bool copy_missed(const std::stop_token& stop, std::span<const core::ItemId> missed, core::ItemCopies& items);
  /// Locks the mutex as soon as no edit is under way. False: the thread must stop.
  bool lock(std::unique_lock<std::mutex>& lock, const std::stop_token& stop);

  const core::Snapshot* live_;
  std::mutex mutex_;  // guards all that follows, and the live snapshot
  std::condition_variable changed_;
  std::atomic<bool> editing_{false}, finished_{false};
  State state_ = State::kWorking;
  SceneVersion version_;                        // the ready one, or one to be freed
  bool behind_ = false;                         // an edit is not yet in order_: of items in missed_, or of materials
  std::vector<core::ItemId> missed_, removed_;  // removed_: those of missed_ that were removed
  std::jthread thread_;                         // last: stops before the other members are destroyed
};

}  // namespace sightline::engine
