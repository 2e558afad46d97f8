// Internal to the importers: analytic primitives recognised in triangle meshes (docs/guide/recognition.md).
//
// After R. de Toledo, B. Levy, J.-C. Paul, "Reverse engineering for industrial-environment CAD models" (TMCE 2008),
// who use the order in which tessellators write their vertices. Here the rings of vertices are found from the
// triangles' neighbours alone, so that neither order nor connectivity of a file matters.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/affine.h"
#include "sightline/core/mesh.h"
#include "sightline/core/primitive.h"
#include "sightline/core/scene.h"
#include "sightline/importers/import.h"

namespace sightline::importers {

struct RecognisedPrimitive {
  core::Primitive primitive;
  core::Affine mesh_from_primitive;  ///< a rotation and a translation
  std::uint32_t triangles = 0;       ///< that it replaces
  /// Largest distance between these and its surface, both ways: measured at corners, edges' middles and centres, and
  /// across the ends as far as their polygons are within the circles. Vertices closer than 2^-22 of the mesh's largest
  /// coordinate count as one.
  double deviation = 0.0;
  double along = 0.0;  ///< no such distance goes farther than this along the primitive's z axis
};

struct RecognisedMesh {
  std::vector<RecognisedPrimitive> primitives;  ///< in the order of their solids' first triangles
  core::Mesh rest;                              ///< what is left, with its normals; not set when nothing was recognised
  std::array<std::uint64_t, kRefusalCount> refused{};  ///< solids, by Refusal
};

/// Primitives in a mesh that passes core::validate(). `tolerance`: how far vertices may lie from a surface, in the
/// mesh's units; 0: what the mesh itself tells. The same mesh gives the same result, to the bit. Time is linear but for
/// edges that many triangles share; memory beside the result is at most 400 bytes per triangle.
RecognisedMesh recognise(const core::Mesh& mesh, double tolerance = 0.0);

/// Replaces the mesh items from `first` on by primitives, where recognised, with the node, material and visibility of
/// the mesh's item. A mesh that several items share is looked at once. Reports progress from 0 to 1; false from it
/// stops, and the call returns false.
bool recognise_items(core::Scene& scene, core::ItemId first, double tolerance,
                     const std::function<bool(double)>& progress, RecognitionReport& report);

}  // namespace sightline::importers
