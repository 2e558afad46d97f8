// Faces of a mesh whose surfaces its file states. Internal to measure.
#pragma once

#include <optional>
#include <vector>

#include "sightline/analysis/measure/internal/shape.h"
#include "sightline/core/mesh_extras.h"

namespace sightline::measure {

/// In the world.
struct MeshFace {
  core::MeshSurface surface;
  std::vector<Feature> features;  ///< its axis and centres
  std::vector<Dimension> dimensions;
};

struct MeshFaces {
  std::vector<MeshFace> faces;
  std::vector<std::uint32_t> of_triangle;  ///< of the shape's: index of its face, or kNone. Empty where there are none
};

/// `shape`: of the mesh under the placement. Under a placement that turns circles into ellipses only planes are left.
MeshFaces find_mesh_faces(const core::Mesh& mesh, const core::Affine& world_from_item, const Shape& shape);

/// "a cylindrical face"
std::string_view face_words(core::MeshSurface::Kind kind);

}  // namespace sightline::measure
