// Meshes of exact surfaces, made finer where a view comes so near that their facets show (lod/finer_mesh.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <stop_token>
#include <unordered_map>
#include <vector>

#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"

namespace sightline::apps {

/// The scene's items keep their ids, and have a finer mesh in place of their own until coarse_again(). What stays:
/// faces whose surfaces no file states, and facets of meshes that are large already.
class FinerMeshes {
 public:
  static constexpr double kShownGap = 0.5;    ///< pixels by which facets may lie off their surfaces
  static constexpr double kWantedGap = 0.15;  ///< pixels, where they are made finer, so that a view may come nearer

  FinerMeshes() = default;
  ~FinerMeshes() { stop_.request_stop(); }
  FinerMeshes(const FinerMeshes&) = delete;
  FinerMeshes& operator=(const FinerMeshes&) = delete;

  /// Begins to make them in the background, for an image of that size in pixels, unless that goes on. The snapshot must
  /// be of what the scene has now. False where none are needed, and where the last call was for that image.
  bool begin(const core::Snapshot& snapshot, const core::View& view, int width, int height);
  std::size_t count() const { return coarse_of_.size(); }  ///< finer meshes that the scene has
  bool active() const { return made_.valid(); }            ///< from begin() until finish()
  bool ready() const;                                      ///< finish() would not wait
  /// Gives them to the scene's items, which somebody commits. False where nothing has changed.
  bool finish(core::Scene& scene);
  /// Gives all items the meshes that they came with. False where they have them.
  bool coarse_again(core::Scene& scene);
  /// Another scene follows.
  void forget();

 private:
  struct Job {
    std::uint32_t mesh = 0;  // index in the scene
    std::shared_ptr<const core::Mesh> coarse = {};
    double shown = 0.0;                      // the least gap that shows, in the mesh's own metres
    double gap = 0.0;                        // of `finer`, or without it of `coarse`
    std::shared_ptr<core::Mesh> finer = {};  // null: that is not needed, or not possible
  };
  static std::vector<Job> make(std::vector<Job> jobs, const std::stop_token& stop);
  bool give(core::Scene& scene, const std::unordered_map<std::uint32_t, core::MeshId>& others);

  std::unordered_map<std::uint32_t, double> gaps_;             // by mesh, once known; 0 where there is no finer one
  std::unordered_map<std::uint32_t, core::MeshId> coarse_of_;  // by finer mesh: what its items came with
  std::size_t triangles_ = 0;                                  // of finer meshes
  std::optional<core::View> view_;                             // of the last begin()
  int height_ = 0;
  std::stop_source stop_;
  std::future<std::vector<Job>> made_;
};

}  // namespace sightline::apps
