// A new order of the items, made in the background while the old one stays in use. Internal to engine.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <variant>
#include <vector>

#include "sightline/core/snapshot.h"
#include "sightline/culling/cpu_culler.h"
#include "sightline/culling/linear_culler.h"
#include "sightline/engine/plan.h"

namespace sightline::engine {

using Culler = std::variant<culling::LinearCuller, culling::CpuCuller>;

/// What make_plan wants to know beside the snapshot.
struct PlanRequest {
  CullerChoice culler = CullerChoice::kAutomatic;
  bool draw = false, ids = false;
};

/// What follows from one order of the items.
struct Generation {
  std::unique_ptr<core::Snapshot> snapshot;  // at a fixed address: the culler borrows its bounds
  std::unique_ptr<Culler> culler;
  Plan plan;

  /// Lets the culler follow what Snapshot::apply has touched.
  void update(std::span<const core::Slot> touched);
  /// Plans anew, and makes the culler that the plan names unless it is there.
  void follow_plan(const PlanRequest& request);
};

Generation make_generation(std::unique_ptr<core::Snapshot> snapshot, const PlanRequest& request);

/// One rebuild. Copies the live snapshot in pieces, works on the copy, catches up with what was edited meanwhile, and
/// waits to be taken. The scene is never read. All calls from the thread that edits the live snapshot.
class BackgroundRebuild {
 public:
  /// Starts at once. `live` must outlive the rebuild or be handed to exchange().
  BackgroundRebuild(const core::Snapshot& live, const PlanRequest& request);
  /// Stops and waits: for less than the time of one build.
  ~BackgroundRebuild() = default;
  BackgroundRebuild(const BackgroundRebuild&) = delete;
  BackgroundRebuild& operator=(const BackgroundRebuild&) = delete;

  /// Lets `apply` edit the live snapshot by `delta`. Waits for one piece at most, well below a millisecond.
  void edit(const core::SceneDelta& delta, const std::function<void()>& apply);

  /// When the new generation is ready and shows all edits, puts it in place of the live one, which the background
  /// thread frees. Never waits for the build.
  bool exchange(Generation& live);
  /// Exchanged, and nothing left to do: destroying it takes no time.
  bool finished() const { return finished_; }

 private:
  enum class State { kWorking, kReady, kExchanged };

  void run(const std::stop_token& stop, const PlanRequest& request);
  bool copy_all(const std::stop_token& stop, core::Snapshot::Items& items);
  bool copy_missed(const std::stop_token& stop, std::vector<core::ItemId> missed, core::Snapshot::Items& items);
  /// Holds the mutex unless somebody edits. False: stop.
  bool lock(std::unique_lock<std::mutex>& lock, const std::stop_token& stop);

  const core::Snapshot* live_;
  std::mutex mutex_;  // of all that follows, and of the live snapshot
  std::condition_variable_any changed_;
  std::atomic<bool> editing_{false}, finished_{false};
  State state_ = State::kWorking;
  Generation generation_;  // ready, or to be freed
  bool behind_ = false;    // something was edited that is not yet in generation_: these, or materials
  std::vector<core::ItemId> missed_;
  std::jthread thread_;  // last: stops before the rest goes
};

}  // namespace sightline::engine
