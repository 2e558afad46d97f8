// Levels of detail of an engine's meshes, built in the background. Internal to engine.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <thread>
#include <unordered_map>
#include <vector>

#include "sightline/core/internal/deadline.h"
#include "sightline/core/snapshot.h"
#include "sightline/gpuscene/internal/gpu_scene.h"

namespace sightline::engine {

/// Each mesh is built once, by a thread that starts with the first advance(): before, this costs nothing. Meshes that
/// no item has are forgotten with the next scene.
class MeshDetails {
 public:
  /// Gives a scene, of that snapshot, the levels that are ready and that it lacks, until the deadline but at least
  /// some; and has those built that are not.
  core::Expected<void> advance(const core::Snapshot& snapshot, gpuscene::GpuScene& scene, core::Deadline deadline);
  /// Follows an edit of slots (Snapshot::apply) and appended ones.
  void follow(const core::Snapshot& snapshot, std::span<const core::Slot> touched);
  /// The next advance() is with another scene, which has no levels yet.
  void forget_scene() { known_slots_ = 0; }
  /// Waits until all levels that were asked for are built.
  void wait();
  std::size_t memory_bytes() const;

 private:
  using Levels = gpuscene::GpuScene::LevelsOfMesh;

  void begin(const core::Snapshot& snapshot);
  void want(const core::Snapshot& snapshot, core::Slot slot);
  void take_built();
  void run(const std::stop_token& stop);
  static void build(std::vector<Levels>& work, const std::stop_token& stop);

  std::unordered_map<const core::Mesh*, Levels> known_;  // levels are null until they are built
  std::vector<Levels> given_;                            // ready, for the scene of advance()
  core::Slot known_slots_ = 0;                           // slots whose meshes are known; 0: no scene
  std::mutex mutex_;                                     // guards what follows
  std::condition_variable_any changed_;
  std::vector<std::shared_ptr<const core::Mesh>> wanted_;
  std::vector<Levels> built_;
  bool works_ = false;
  std::jthread thread_;  // last: stops before the other members are destroyed
};

}  // namespace sightline::engine
