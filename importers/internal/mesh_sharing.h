// Internal to the importers: instancing recovered. Meshes that are the same but for a similarity - moved, turned,
// scaled by one factor - are kept once; CAD exports write such copies out in full.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "sightline/core/scene.h"
#include "sightline/importers/import.h"

namespace sightline::importers {

/// A copy may differ from what it shares by this much of its own diagonal, vertex by vertex: files round to some six
/// digits, and meshes are kept in float.
inline constexpr double kSharingTolerance = 4e-6;

/// Normals of a copy may differ by this much of a unit vector.
inline constexpr float kSharingNormalTolerance = 1e-3f;

/// Vertices that hold a mesh in place: one, the one farthest from it, and the one farthest from the line through both.
struct MeshAnchors {
  std::uint32_t a = 0, b = 0, c = 0;
};

/// Copies have the same triangles over the same number of vertices in the same order, the same polygons, normals both
/// or neither. Mirrored ones stay apart (their triangles run the other way round); so do facet groups whose bits
/// differ, which are written back to the bit, and what differs in size by more than a million. Found by hash: of the
/// triangles, and of three numbers that no similarity changes; compared vertex by vertex. A few nanoseconds a vertex.
class MeshSharing {
 public:
  /// `copies`: kExact or kSimilar.
  explicit MeshSharing(core::Scene& scene, MeshCopies copies = MeshCopies::kSimilar)
      : scene_(scene), exact_(copies == MeshCopies::kExact) {}

  struct Use {
    core::MeshId mesh;
    core::Affine added_from_mesh;  ///< maps the mesh to where the added one was; the identity for one that is new
    double error = 0.0;            ///< farthest that a vertex was moved, in the added mesh's unit
    bool shared = false;
  };
  /// Adds the mesh to the scene unless one added through here before can stand for it. Fails as Scene::add_mesh does.
  core::Expected<Use> add(core::Mesh mesh);

 private:
  struct Known {
    core::MeshId mesh;
    MeshAnchors anchors;
  };

  core::Scene& scene_;
  bool exact_;
  std::unordered_map<std::uint64_t, std::vector<Known>> known_;
};

}  // namespace sightline::importers
