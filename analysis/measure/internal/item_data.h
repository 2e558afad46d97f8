// What an Item holds. Internal to measure.
#pragma once

#include "sightline/analysis/measure/internal/mesh_faces.h"
#include "sightline/analysis/measure/internal/shape.h"
#include "sightline/analysis/measure/item.h"

namespace sightline::measure {

/// Corner and edges of a mesh triangle that count as features.
struct TriangleFeatures {
  bool edges[3] = {};  ///< edge i goes from corner i to the next one
  bool corners[3] = {};
};

struct Item::Data {
  core::Kind kind;
  Shape shape;
  std::vector<Feature> features;            ///< of a primitive
  std::vector<Dimension> dimensions;        ///< of a primitive
  std::vector<TriangleFeatures> triangles;  ///< of a mesh, in the order of the shape's
  MeshFaces faces;                          ///< of a mesh
};

/// One entry for each triangle of a mesh's shape. An edge is sharp where the triangles on both sides turn by more than
/// 20 degrees, and where it has not exactly two sides. A corner is where sharp edges meet, other than two in one line.
std::vector<TriangleFeatures> find_triangle_features(const Shape& mesh);

}  // namespace sightline::measure
