// Clusters and levels of detail of an engine's meshes, built in the background. Internal to engine.
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
#include "sightline/gpuscene/internal/gpu_scene.h"

namespace sightline::engine {

/// Large meshes get clusters, and where levels are asked for all meshes that gain by them get levels: those that came
/// with them, else a thread builds each once. It starts with the first mesh. Meshes that no item has are forgotten with
/// the next scene.
class MeshDetails {
 public:
  /// Gives a scene what is ready and it lacks, until the deadline but at least some, and has built what is not.
  /// `levels`: they are asked for.
  core::Expected<void> advance(gpuscene::GpuScene& scene, bool levels, core::Deadline deadline);
  /// Begins to build levels before the first advance() that asks for them. The scene is that of the next one.
  void want_levels(const gpuscene::GpuScene& scene);
  /// The next advance() is with another scene, which has nothing yet.
  void forget_scene() { scene_known_ = false; }
  /// Waits until everything that was asked for is built.
  void wait();
  /// Whether any mesh has clusters or will have some.
  bool any() const { return !known_.empty(); }
  std::size_t memory_bytes() const;

 private:
  using Levels = gpuscene::MeshPool::LevelsOfMesh;
  /// What is wanted of a mesh: levels, or clusters alone. `of` holds them once they are built.
  struct Wanted {
    Levels of;
    bool levels = false;
  };

  void want(std::span<const std::shared_ptr<const core::Mesh>> meshes);
  void begin(const gpuscene::GpuScene& scene);
  void take_built();
  void run(const std::stop_token& stop);
  static void build(std::vector<Wanted>& work, const std::stop_token& stop);

  std::unordered_map<const core::Mesh*, Wanted> known_;
  std::vector<Levels> given_;  // ready, for the scene of advance()
  bool scene_known_ = false, levels_wanted_ = false;
  std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  std::vector<Wanted> wanted_, built_;
  bool works_ = false;
  std::jthread thread_;  // last: stops before the other members are destroyed
};

}  // namespace sightline::engine
