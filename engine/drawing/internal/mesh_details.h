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
#include "sightline/core/internal/stopping.h"
#include "sightline/gpuscene/internal/gpu_scene.h"

namespace sightline::engine {

/// Large meshes get clusters, and where levels are asked for all meshes that gain by them get levels: those that came
/// with them, else a thread builds each once. It starts with the first mesh. Meshes that no item has any more are
/// forgotten when the scene has followed that, and what is being built of them is cancelled.
class MeshDetails {
 public:
  ~MeshDetails();
  /// Follows which meshes the scene has got and given up. `levels`: they are asked for.
  void follow(gpuscene::GpuScene& scene, bool levels);
  /// After follow(): follows the new meshes that are left, and uploads what is ready, until the deadline but at least a
  /// little.
  core::Expected<void> advance(gpuscene::GpuScene& scene, bool levels, core::Deadline deadline);
  /// Begins to build levels before the first advance() that asks for them. The scene is that of the next one.
  void want_levels(gpuscene::GpuScene& scene);
  /// Keeps what a new engine would have, for a scene that was made anew: nothing of other meshes, and levels only where
  /// they are asked for.
  void keep_only(const gpuscene::GpuScene& scene, bool levels);
  /// Waits until everything that was asked for is built.
  void wait();
  /// Whether any mesh has clusters or will have some.
  bool any() const { return !known_.empty(); }
  std::size_t memory_bytes() const;

 private:
  using Levels = gpuscene::MeshPool::LevelsOfMesh;
  using Meshes = std::span<const std::shared_ptr<const core::Mesh>>;
  /// What is wanted of a mesh: levels, or clusters alone. `of` holds them once they are built.
  struct Wanted {
    Levels of;
    bool levels = false;
    std::stop_source stop;  // of building it; also tells whether two are of the same call of want()
  };

  void want(gpuscene::GpuScene& scene, Meshes meshes);
  void forget(const core::Mesh& mesh);
  void drop_cancelled();
  void give_built(gpuscene::GpuScene& scene);
  void run(const std::stop_token& stop);
  static void build(std::vector<Wanted>& work);

  std::unordered_map<const core::Mesh*, Wanted> known_;
  bool levels_wanted_ = false;
  std::size_t cancelled_ = 0;  // of wanted_, at most
  mutable std::mutex mutex_;   // guards what follows
  std::condition_variable changed_;
  std::vector<Wanted> wanted_, built_;
  bool works_ = false;
  std::jthread thread_;  // last: stops before the other members are destroyed
};

}  // namespace sightline::engine
