// Internal to the importers: normals for meshes whose file has none.
#pragma once

#include "sightline/core/mesh.h"

namespace sightline::importers {

/// Gives a mesh without normals those of smooth surfaces between creases: at each vertex, faces that meet in edges bent
/// by at most `angle` (radians, 0 to pi) have one normal, the mean of theirs weighted by their angles at the vertex (G.
/// Thürmer, C. Wüthrich, "Computing vertex normals from polygonal facets", 1998). Positions that are equal become one
/// vertex for each such normal. Triangles keep their order and their corners' places. Edges of faces that face opposite
/// ways count as creases.
void add_crease_normals(core::Mesh& mesh, double angle);

}  // namespace sightline::importers
