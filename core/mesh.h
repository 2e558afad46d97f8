// Triangle meshes as the scene keeps them: shared between items, immutable once added.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/api.h"
#include "sightline/core/error.h"

namespace sightline::core {

struct MeshExtras;

/// What came with a mesh from its file beside its triangles (core/mesh_extras.h); nothing for most. Whoever copies a
/// mesh may change the copy, which therefore comes without what is true of the original alone: levels of detail.
class SIGHTLINE_API MeshExtrasSlot {
 public:
  MeshExtrasSlot() = default;
  explicit MeshExtrasSlot(MeshExtras extras);
  MeshExtrasSlot(const MeshExtrasSlot& other);
  MeshExtrasSlot& operator=(const MeshExtrasSlot& other);
  MeshExtrasSlot(MeshExtrasSlot&&) noexcept = default;
  MeshExtrasSlot& operator=(MeshExtrasSlot&&) noexcept = default;
  ~MeshExtrasSlot() = default;

  explicit operator bool() const { return extras_ != nullptr; }
  const MeshExtras* operator->() const { return extras_.get(); }

 private:
  std::shared_ptr<const MeshExtras> extras_;
};

/// Indexed triangles in local coordinates (float; importers re-centre far coordinates in double first and put the
/// centre into the item's placement). `normals` is empty or as long as `positions`. Every index is below
/// positions.size().
struct Mesh {
  std::string name;
  std::vector<vec3> positions;
  std::vector<vec3> normals;
  std::vector<std::uint32_t> indices;  ///< three per triangle, counter-clockwise from outside

  /// The polygons that the triangles came from, kept so that a facet group can be written back: contour k has
  /// contour_sizes[k] consecutive vertices, polygon j has polygon_contours[j] consecutive contours, together all
  /// vertices in order. Empty for a plain mesh.
  std::vector<std::uint32_t> contour_sizes;
  std::vector<std::uint32_t> polygon_contours;

  MeshExtrasSlot extras = {};

  bool is_facet_group() const { return !polygon_contours.empty(); }
};

/// Fails unless counts and indices are as described at Mesh; the error says what was expected and what was found.
/// Coordinates may be anything.
SIGHTLINE_API Expected<void> validate(const Mesh& mesh);

/// For each vertex, the first vertex at its position. A vertex with a NaN matches only itself.
SIGHTLINE_API std::vector<std::uint32_t> weld(std::span<const vec3> positions);

/// What a mesh's triangles enclose, if anything.
enum class Enclosure : std::uint8_t {
  kNothing,  ///< open: some edge has no neighbour, or one of the same direction
  kInside,   ///< a solid, its triangles counter-clockwise from outside
  kOutside,  ///< a solid whose triangles are clockwise from outside
};

/// Tells solids from sheets. `mesh` must pass validate(). A mesh is closed when every edge, as a pair of positions,
/// occurs equally often in both directions. Vertices duplicated for their normals count as one. Sorts the mesh's edges:
/// at most 0.2 us per index.
SIGHTLINE_API Enclosure enclosure(const Mesh& mesh);

}  // namespace sightline::core
