// Internal to the importers: recovers instancing. Meshes that are equal up to a similarity (moved, turned, scaled by
// one factor) are kept once. CAD exports write such copies out in full.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "sightline/core/scene.h"
#include "sightline/importers/import.h"

namespace sightline::importers {

/// A copy may differ from the shared mesh by this share of its own diagonal, vertex by vertex: files round to some six
/// digits, and meshes are kept in float.
inline constexpr double kSharingTolerance = 4e-6;

/// Normals of a copy may differ by this much of a unit vector.
inline constexpr float kSharingNormalTolerance = 1e-3f;

/// Vertices that fix a mesh in space: one, the one farthest from it, and the one farthest from the line through both.
struct MeshAnchors {
  std::uint32_t a = 0, b = 0, c = 0;
};

/// Copies have the same triangles over the same number of vertices in the same order, the same polygons, and both or
/// neither have normals. Not copies are: mirrored meshes (their triangles run the other way round), facet groups whose
/// bits differ (they are written back to the bit), and meshes that differ in size by more than a factor of a million.
/// Copies are found by a hash of the triangles and of three numbers that no similarity changes, and are then compared
/// vertex by vertex. A few nanoseconds per vertex.
class MeshSharing {
 public:
  explicit MeshSharing(core::Scene& scene, MeshCopies copies = MeshCopies::kSimilar) : scene_(scene), copies_(copies) {}

  struct Use {
    core::MeshId mesh;
    core::Affine added_from_mesh;  ///< maps the mesh to where the added one was; the identity for a new mesh
    double error = 0.0;            ///< largest distance that a vertex was moved, in the added mesh's unit
    bool shared = false;
  };
  /// Adds the mesh to the scene, unless copies are shared and one added through this object before can stand for it.
  /// Fails as Scene::add_mesh does.
  core::Expected<Use> add(core::Mesh mesh);

 private:
  struct Known {
    core::MeshId mesh;
    MeshAnchors anchors;
  };

  core::Scene& scene_;
  MeshCopies copies_;
  std::unordered_map<std::uint64_t, std::vector<Known>> known_;
};

}  // namespace sightline::importers
