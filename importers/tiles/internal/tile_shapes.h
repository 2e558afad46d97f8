// Internal to the writer of 3D Tiles: triangles of items at an error, once for all that share them.
#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <unordered_map>

#include "sightline/core/scene.h"
#include "sightline/importers/gltf/internal/shared_primitive.h"
#include "sightline/importers/tiles/internal/tile_items.h"
#include "sightline/lod/mesh_levels.h"

namespace sightline::importers {

/// Share of an error by which rounding may move a point along one axis: numbers with fewer digits take fewer bytes.
inline constexpr double kRoundingShare = 0.2;

class TileShapes {
 public:
  /// `tolerance`: between primitives and their triangles where an error of 0 is asked for, metres.
  TileShapes(const core::Scene& scene, double tolerance) : scene_(scene), tolerance_(tolerance) {}

  /// Triangles, or two positions without indices: a line. Never mirrored by their placement.
  struct Placed {
    const core::Mesh* mesh = nullptr;  ///< valid until trim(); null or empty: there is nothing to draw
    core::Affine world_from_mesh;
    double chord_error = 0.0;  ///< of a primitive, metres in the world
    double grid = 0.0;         ///< to a multiple of which positions in the world may be rounded; 0: they must stay
    bool empty() const { return !mesh || mesh->positions.empty(); }
  };
  /// What stands for an item within `error` metres: two-sided, and proved for meshes. 0: the mesh itself, or a
  /// primitive within the tolerance.
  Placed place(const TileItem& item, double error);

  /// Gives back memory of what can be made again.
  void trim();

 private:
  struct Shape {
    core::Mesh mesh;
    double chord_error = 0.0;  // of size 1
  };
  using PrimitiveKey = std::tuple<SharedPrimitive::Key, double, bool>;  // tolerance, mirrored
  using MeshKey = std::tuple<const core::Mesh*, int, bool>;             // exponent of the error, mirrored
  static constexpr int kExact = -10'000;

  Placed place_primitive(const TileItem& item, double tolerance, bool mirrored);
  Placed place_mesh(const TileItem& item, double error, bool mirrored);
  const lod::MeshLevels& levels_of(const core::Mesh& mesh);
  void note(const core::Mesh& mesh) { vertices_ += mesh.positions.size(); }

  const core::Scene& scene_;
  double tolerance_;
  std::map<PrimitiveKey, Shape> primitives_;
  std::map<MeshKey, core::Mesh> meshes_;
  std::unordered_map<const core::Mesh*, lod::MeshLevels> levels_;
  std::uint64_t vertices_ = 0;  // of primitives_ and meshes_
};

}  // namespace sightline::importers
