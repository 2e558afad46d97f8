// Writer of glTF 2.0: what gltf_reader.h reads.
//
// What becomes what. The children of the written node become the scene's nodes, with their names, transforms and
// attributes (as extras); the written node's own items get a node named after it. World coordinates are metres with y
// up: the way there is part of the topmost transforms. Each item becomes a node without a name below its node, unless
// it can be its node's own mesh. kGltfInstancesFrom or more items of one node that share mesh and material become one
// node with EXT_mesh_gpu_instancing. A mesh is written once, with its normals, in its own coordinates, and every item
// refers to it. Analytic primitives are written as triangles within a chord tolerance, once for all that have the same
// parameters at nearly the same scale, and boxes, spheres and cylinders once for all with as many segments. Lines
// become lines. Materials have base colour, alpha and both sides. A placement that shears is baked into a mesh of its
// own, since glTF has no shear. Transforms keep all digits, those of instances some seven, relative to the node's
// extent.
//
// With `collections` the file follows the convention of web viewers for industry instead (internal/gltf_collections.h
// describes it): boxes, cylinders, cones, tori, dishes, spheres and slanted cylinders are rows of parameters, with z
// up, and come back as analytic items of the same shape. A cylinder that is stretched across, a cone with slanted ends
// and other primitives that the convention has no row for become triangles, one "InstanceMesh" for each shape. Lines
// are left out. Caps are rows of their own, as viewers of the convention want them. Their nodes have {"caps": true} in
// their extras, by which the reader knows that its solids have them already. Nodes are written without transforms, and
// those with items have their tree index in their extras, by which the reader finds names and attributes again. Numbers
// are floats, about a centre of their own where the model lies beyond 4 km; alpha is lost.
//
// As in OBJ, items that are hidden, or on no layer but those hidden by default (obstruction and insulation volumes),
// are left out, and nodes that held nothing else; so are meshes without triangles or with vertices that are not finite.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/scene.h"

namespace sightline::importers {

inline constexpr std::size_t kGltfInstancesFrom = 16;

struct GltfWriteOptions {
  /// Largest distance in metres between an analytic primitive and its triangles; finite and > 0.
  double tolerance = 0.001;
  /// Primitives as rows of parameters, for web viewers that know them.
  bool collections = false;
  /// Called like ImportOptions::progress: returning false cancels with kCancelled as the message.
  std::function<bool(double)> progress = {};
};

struct GltfWriteReport {
  std::array<std::uint64_t, core::kKindCount> items{};  ///< written, by kind
  std::uint64_t left_out = 0;                           ///< items hidden or without triangles
  std::uint64_t analytic = 0;                           ///< of the items: written as rows of parameters
  std::uint64_t meshes = 0;                             ///< distinct ones
  std::uint64_t vertices = 0, triangles = 0;            ///< of these meshes, each counted once
  std::uint64_t bytes = 0;                              ///< of the file, and of the .bin beside it
  /// Largest distance in metres between a written edge and the primitive that it stands for, as ObjWriteReport has it.
  double largest_chord_error = 0.0;
};

/// Writes `path`, which ends in .glb, or in .gltf with its numbers in a file of the same name with ".bin". Both appear
/// whole or not at all. Fails on other extensions, a path that cannot be written, a tolerance that is not > 0, a .glb
/// beyond 4 GiB, and in collections more than 2^24 nodes with items. Memory: the file's size.
SIGHTLINE_API core::Expected<GltfWriteReport> write_gltf(const core::Scene& scene, core::NodeId node,
                                                         const std::filesystem::path& path,
                                                         const GltfWriteOptions& options = {});

}  // namespace sightline::importers
