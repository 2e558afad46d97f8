// Random scenes of extreme solids and meshes, at up to 1e7 m from the origin, and random rays at them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sightline/apps/bench/stability/reference.h"
#include "sightline/apps/bench/stability/shapes.h"
#include "sightline/apps/bench/stability/traced_rays.h"
#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::bench {

/// What one item is, for the reference.
struct TracedItem {
  core::Slot slot = core::kNone;
  core::Affine frame;
  core::dmat3 item_from_world;
  core::AabbD box;          // in its frame
  double diagonal = 0.0;    // of its box in the world
  core::dvec3 inside{0.0};  // a solid, if it is convex; in the world
  std::optional<core::Primitive> solid;
  std::optional<ReferenceSolid> reference;
  const core::Mesh* mesh = nullptr;
  bool closed = false;
  double mesh_size = 0.0;  // as tracer.h has it, in the mesh's units
};

/// A scene, its tracer, and where it is.
struct TracedScene {
  core::Scene scene;
  std::unique_ptr<core::Snapshot> snapshot;
  std::unique_ptr<raytrace::Tracer> tracer;
  std::vector<TracedItem> items;  // by slot
  core::dvec3 centre{0.0};        ///< items are about it, up to `half` away
  double half = 1.0;
};

/// Three to eight items of one kind, or mixed. Nothing if they make no scene.
std::unique_ptr<TracedScene> make_traced_scene(TracedKind kind, Random& random);

/// Rays at the items: through edges, along surfaces, across what is thin, along axes, and with ends next to what they
/// meet. In the order in which they are traced side by side.
std::vector<core::Ray> rays_at(const TracedScene& world, std::int64_t count, Random& random);

}  // namespace sightline::bench
