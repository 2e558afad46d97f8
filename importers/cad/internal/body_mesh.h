// Internal to the importers: triangles of exact surfaces, by Open CASCADE's mesher, as meshes of ours.
#pragma once

#include <cstdint>
#include <vector>

#include <BRepBuilderAPI_ModifyShape.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include "sightline/core/mesh.h"

namespace sightline::importers {

/// A face, and the number of its look.
struct StyledFace {
  TopoDS_Face face;
  std::uint32_t style = 0;
};

/// A solid, or faces that are none.
struct Body {
  TopoDS_Shape shape;
  std::vector<StyledFace> faces;
};

/// Whether a face has a surface, and not triangles alone.
bool has_surface(const TopoDS_Face& face);
/// Whether a body has triangles alone.
bool is_tessellated(const Body& body);

/// The body that a change has made.
Body changed(const Body& body, BRepBuilderAPI_ModifyShape& change);

struct BodyMesh {
  struct OfStyle {
    std::uint32_t style;
    core::Mesh mesh;
  };
  std::vector<OfStyle> meshes;  ///< of styles in rising order
  core::dvec3 centre{0.0};      ///< to be added to all positions
  std::uint64_t failed_faces = 0;
  double deviation = 0.0;  ///< the largest distance found between triangles and surfaces, and between their rims
  /// Faces by their number in the body, from 1, whose triangles have another area than their borders enclose.
  std::vector<std::size_t> wrong_faces;
  std::size_t open_edges = 0;  ///< of triangles of a solid, that have no neighbour
};

/// Both in the body's unit; an angle in radians between neighbouring facets of a curve.
struct MeshQuality {
  double tolerance, angle;
};

/// Meshes a body. Faces share their vertices' positions along edges, so a closed solid gives closed triangles, of all
/// styles together. Normals are the surfaces'. Measures the deviation at four points of each triangle and between the
/// points of each edge; where that is above the tolerance, meshes finer, up to three times and as long as that helps. A
/// face with a wrong area counts as far off as a strip along its border would be that has the difference.
/// Faces keep their surfaces (core::MeshExtras) where these are planes, cylinders, cones, spheres or tori.
/// Faces that cannot be meshed are left out and counted. A tessellated body keeps its triangles, and its normals where
/// it has some. Several threads may mesh bodies that share no face.
BodyMesh mesh_body(const Body& body, const MeshQuality& quality);

}  // namespace sightline::importers
