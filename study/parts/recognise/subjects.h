// What sightline-study recognise measures on: primitives, triangles that stand for them, and how far these, and what
// recognition makes of them, are from the primitives.
#pragma once

#include <optional>
#include <vector>

#include "sightline/core/scene.h"
#include "sightline/importers/recognise/internal/recognise.h"
#include "sightline/importers/recognise/internal/surface_distance.h"

namespace sightline::bench {

/// A primitive of a scene whose placement is a similarity. Points are in metres along the world's axes, from `origin`.
struct Original {
  core::ItemId item;
  core::Primitive primitive;
  core::Affine world_from_local;
  double scale;                                      ///< of world_from_local
  core::dvec3 origin;                                ///< the middle of its bounds, in whole metres
  importers::recognition::SurfaceDistance distance;  ///< in local units

  /// Metres from the surface.
  double distance_of(const core::dvec3& point) const;
};

/// All primitives with volume.
std::vector<Original> originals_of(const core::Scene& scene);

/// How finely primitives become triangles, and how these are written.
struct Fineness {
  int segments = 0;       ///< of a full circle; 0: as many as `chord` asks for
  double chord = 0.0;     ///< metres between triangles and surface
  double rounding = 0.0;  ///< coordinates are multiples of this, metres; 0: they are not rounded
};

/// The triangles, with normals.
core::Mesh triangles_of(const Original& original, const Fineness& fineness);

/// The largest distance of a corner, an edge's middle or a triangle's centre from the surface, metres.
double error_of_triangles(const Original& original, const core::Mesh& mesh);

/// The largest distance between the original's surface and those of the primitives, metres: from points of either to
/// the other. Where several primitives stand for one, ends that lie inside of it do not count.
double error_of_surfaces(const Original& original, const importers::RecognisedMesh& found);

/// The largest difference of the lengths that two primitives of one kind have (radii, heights, sizes, sweeps along the
/// outermost circle), metres. Nothing for kinds of which one solid has several sets of parameters.
std::optional<double> error_of_lengths(const Original& original, const core::Primitive& found);

}  // namespace sightline::bench
