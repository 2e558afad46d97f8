// Embree 3 as a peer of the ray tracer: the same triangles and solids, the same rays.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/mesh.h"
#include "sightline/core/primitive.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::bench {

/// A ray as Embree takes it.
struct FloatRay {
  core::vec3 origin, direction;
  float t_min, t_max;
};

/// A solid for Embree's user geometry: hit where gpuprims' reference intersectors say, in double.
struct PeerSolid {
  core::Primitive solid;
  core::dmat3 item_from_world;
  core::dvec3 origin;  ///< of the item
  core::AabbD box;     ///< in the world
};

/// One scene of one mesh and of solids, either of which may be empty, built with medium quality.
class EmbreePeer {
 public:
  /// `robust`: watertight. `threads` build.
  EmbreePeer(const core::Mesh& mesh, std::vector<PeerSolid> solids, bool robust, int threads);
  ~EmbreePeer();
  EmbreePeer(const EmbreePeer&) = delete;
  EmbreePeer& operator=(const EmbreePeer&) = delete;

  double build_ms() const { return build_ms_; }
  /// What Embree says that it has allocated since its device was made, vertices and indices included.
  std::int64_t bytes() const;
  /// Traces rays one by one. Returns the number that hit; `t` gets the distances, infinity where nothing is hit.
  std::size_t single(std::span<const FloatRay> rays, std::span<float> t) const;
  /// Traces packets of sixteen, rays in an order in which neighbours are coherent.
  std::size_t packets(std::span<const FloatRay> rays, std::span<float> t) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
  double build_ms_ = 0.0;
};

}  // namespace sightline::bench
