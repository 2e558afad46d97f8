// What importers and scene caches keep with a mesh beside its triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/core/mesh.h"

namespace sightline::core {

/// A face of a mesh, and the surface that its file states for it, in the mesh's coordinates. Written to scene caches as
/// it lies in memory.
struct MeshSurface {
  enum class Kind : std::uint32_t { kOther, kPlane, kCylinder, kCone, kSphere, kTorus };
  Kind kind = Kind::kOther;
  std::uint32_t end_triangle = 0;          ///< the face's triangles begin at the end of the face before
  dvec3 origin{0.0}, axis{0.0, 0.0, 1.0};  ///< the axis is a unit vector: a plane's normal; a sphere has none
  double radius = 0.0;                     ///< of a torus: of the circle of the tube's centre; of a cone: at the origin
  double tube_radius = 0.0;                ///< of a torus
  double slope = 0.0;  ///< of a cone: tangent of its half angle, by which the radius grows along the axis
  double gap = 0.0;    ///< no corner of the face's triangles lies farther from the surface
};
static_assert(sizeof(MeshSurface) == 11 * sizeof(double));

/// "cylinder"; "other" for surfaces of no kind.
SIGHTLINE_API std::string_view name_of(MeshSurface::Kind kind);

/// The point of the whole surface nearest to `p`; `p` itself for other kinds. Of several, as on an axis, any.
SIGHTLINE_API dvec3 nearest_point(const MeshSurface& surface, const dvec3& p);

/// Bytes that lie in a file, and of which nothing is in memory.
class SIGHTLINE_API StoredBytes {
 public:
  virtual ~StoredBytes() = default;
  /// Verified. Any thread may call it, several at once. Fails where the file cannot be read or is damaged.
  virtual Expected<std::vector<std::byte>> bytes() const = 0;
};

/// A mesh in memory has these as Mesh::extras.
struct MeshExtras {
  /// What is stored of exactly these triangles, in the form of the room that made it: levels of detail
  /// (lod/stored_levels.h). May be null.
  std::shared_ptr<const StoredBytes> stored;
  std::shared_ptr<const std::vector<MeshSurface>> surfaces;  ///< of all triangles, in their order; may be null
};

/// MeshExtras::stored, or null.
inline const StoredBytes* bytes_stored_with(const Mesh& mesh) {
  return mesh.extras ? mesh.extras->stored.get() : nullptr;
}

/// Surfaces that came with a mesh. Of a mesh that was changed afterwards they may be wrong: surface_of() tells.
inline std::span<const MeshSurface> surfaces_stored_with(const Mesh& mesh) {
  return mesh.extras && mesh.extras->surfaces ? std::span<const MeshSurface>(*mesh.extras->surfaces)
                                              : std::span<const MeshSurface>();
}

/// Index of a triangle's face among surfaces_stored_with(), or kNone where it has none of a known kind on which the
/// triangle's corners lie.
SIGHTLINE_API std::uint32_t surface_of(const Mesh& mesh, std::uint32_t triangle);

}  // namespace sightline::core
