// Internal to the glTF reader: plant models in the convention of web viewers for industry (Cognite Reveal's sector
// files, as rvmsharp writes them). In these files nodes hold parameters of primitives instead of triangles.
//
// A node named after a kind of primitive holds one accessor for each parameter, as attributes of
// EXT_mesh_gpu_instancing. Coordinates are metres with z up, angles radians. All kinds have `_treeIndex` (the part of
// the plant; float) and `_color` (sRGB, four bytes; alpha is ignored, as the viewers of the convention do, since
// writers leave it 0).
//
//   BoxCollection               _instanceMatrix of the cube -1/2 … 1/2
//   QuadCollection              … of its square in z = 0
//   CircleCollection            … of the disc of radius 1/2 in z = 0; _normal
//   NutCollection               … of a hexagonal prism along z, corners at radius 1/2, one on the y axis
//   GeneralRingCollection       … of the ring from radius 1/2 (1 - _thickness) to 1/2 in z = 0, from _angle over
//                               _arcAngle about z; _normal
//   TorusSegmentCollection      … of a torus about z: _radius, _tubeRadius, from x over _arcAngle
//   ConeCollection              wall from _centerA, _radiusA to _centerB, _radiusB, circles across the axis; the part
//                               from _angle over _arcAngle about the axis from B to A, measured from _localXAxis
//   EccentricConeCollection     wall between two circles across _normal: _centerA, _radiusA, _centerB, _radiusB
//   EllipsoidSegmentCollection  _center, _horizontalRadius across _normal and _verticalRadius along it; the cap down to
//                               _height below the pole that _normal points at
//   GeneralCylinderCollection   wall of _radius from _centerB to _centerA, between _planeA and _planeB: outward normals
//                               in the frame x = _localXAxis, z from B to A. The planes cut the axis short of the
//                               centres by tan(angle to the axis) times the radius; the fourth number is not used
//   TrapeziumCollection         _vertex1 … _vertex4: triangles 1 2 4 and 1 4 3
//   InstanceMesh                a mesh with an _instanceMatrix for each copy
//   TriangleMesh                a mesh with _treeIndex and COLOR_0 for each vertex
//
// All but nuts, trapezia and parts of cones become primitives, exactly (up to their float parameters). Walls become the
// solids that they bound, since the convention keeps caps as circles and rings beside them. Nuts and trapezia become
// exact meshes. A part of a cone, or of a cylinder with slanted ends, becomes flat facets within kFacetError of its
// radius. One node named with the tree index holds all items of that part, over all collections. One material stands
// for each colour.
//
// Our own writer (gltf_writer.h) adds two things in extras, which others ignore: "treeIndex" of a node that is the part
// itself, with its name and attributes, and "caps" of a collection that closes the walls of others, which solids do
// not need.
#pragma once

#include <functional>
#include <string_view>
#include <unordered_map>

#include "sightline/importers/gltf/internal/gltf_geometry.h"

namespace sightline::importers {

inline constexpr double kFacetError = 1e-3;

class GltfCollections {
 public:
  GltfCollections(ImportJob& job, GltfDocument& document) : job_(job), document_(document) {}

  /// Whether the file follows the convention: some attribute is called _treeIndex.
  static bool follows_convention(const GltfDocument& document);
  static bool is_collection(std::string_view node_name);

  /// Makes `node`, at `file_from_node`, the node of a part. Nothing changes when the map has no inverse.
  void name_part(std::uint32_t tree_index, core::NodeId node, const core::Affine& file_from_node);

  using Progress = std::function<void(double)>;  ///< receives the share of one node that is done
  /// Adds the primitives of a node. `node` holds those that belong to no part.
  void add(std::string_view kind, const Json& attributes, core::NodeId node, const core::Affine& file_from_node,
           const std::string& where, const Progress& progress);
  /// Adds a mesh of many parts: one item for each run of triangles of one part and colour.
  void add_triangles(const GltfSources& sources, const Json& attributes, core::NodeId node,
                     const core::Affine& file_from_node, const std::string& where, const Progress& progress);

  /// The node that an item of a part hangs on, and the item's placement there. `tree_index` null: `fallback`.
  struct Place {
    core::NodeId node;
    core::Affine from_item;
  };
  Place place(const double* tree_index, core::NodeId fallback, const core::Affine& file_from_node,
              const core::Affine& node_from_item);
  /// `colour`: an accessor's four numbers, of which the last is ignored; null: none.
  core::MaterialId material(const double* colour, const GltfAccessor* accessor);

 private:
  ImportJob& job_;
  GltfDocument& document_;
  struct Part {
    core::NodeId node;
    core::Affine node_from_file;
  };
  std::unordered_map<std::uint32_t, Part> parts_;
  std::unordered_map<std::uint32_t, core::MaterialId> materials_;
  core::MeshId nut_;
};

}  // namespace sightline::importers
