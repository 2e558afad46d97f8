// A mesh with smaller facets, from the surfaces that its file states for its faces: for images that come so near that
// the outline of a shaft shows corners. Works without the file, and on what comes from a scene cache.
#pragma once

#include <cstddef>
#include <optional>

#include "sightline/core/mesh.h"

namespace sightline::lod {

/// Whether a file states for some face a surface that facets only approach: neither a plane nor of another kind.
SIGHTLINE_API bool has_curved_faces(const core::Mesh& mesh);

/// The largest distance between the middle of a triangle's side and the surfaces of its faces (core/mesh_extras.h), in
/// the mesh's own metres: how far facets lie off them, about. 0 for meshes without curved surfaces. 0.3 us per index.
SIGHTLINE_API double facet_gap(const core::Mesh& mesh);

/// Halves sides whose middle lies farther than `tolerance`, above 0, from the surfaces of their faces, until none does:
/// the new corner is the point of the surface nearest to the middle, where two faces meet one of both surfaces. So
/// outlines and the edges of faces get rounder, facets that meet go on doing so, and closed meshes stay closed. Faces
/// keep their surfaces, with the gap of the new corners; normals are those of the surfaces.
///
/// Left as they are: faces of other surfaces, but for sides that they share; sides along which a surface turns by more
/// than 45 degrees; those whose new corner would turn a triangle around, or lie on one of two surfaces alone; and all
/// from the pass on that would make more triangles than `most`. So the result may miss the tolerance: facet_gap()
/// tells. Nothing for a mesh whose facets are fine enough, and for facet groups.
SIGHTLINE_API std::optional<core::Mesh> finer_mesh(const core::Mesh& mesh, double tolerance,
                                                   std::size_t most = 1 << 20);

}  // namespace sightline::lod
