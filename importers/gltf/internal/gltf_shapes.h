// Internal to the glTF writer: each geometry once, whatever refers to it.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "sightline/core/scene.h"
#include "sightline/importers/gltf/gltf_writer.h"
#include "sightline/importers/gltf/internal/gltf_output.h"
#include "sightline/importers/gltf/internal/shared_primitive.h"

namespace sightline::importers {

class GltfShapes {
 public:
  GltfShapes(const core::Scene& scene, double tolerance, GltfOutput& output, GltfWriteReport& report)
      : scene_(scene), tolerance_(tolerance), output_(output), report_(report) {}

  /// A shape, and the scale along the item's own axes that makes the item of it.
  struct Scaled {
    std::uint32_t shape = core::kNone;
    core::dvec3 scale{1.0};
  };
  /// The shape of an item that is placed by `world_from_item`; kNone when there is nothing to draw. Primitives of the
  /// same parameters share a shape when their scales lie within the same eighth of an octave. Cylinders, spheres and
  /// boxes are of size 1, so that all of them with as many segments share one.
  Scaled shape(core::ItemId item, const core::Affine& world_from_item);
  /// The shape under `linear`, for a placement that glTF cannot hold. Mirrored triangles are turned to face outwards.
  std::uint32_t baked(core::ItemId item, const core::dmat3& linear, const core::Affine& world_from_item);
  /// The file's mesh of a shape in a material of the scene; kNone: without one.
  std::uint32_t mesh(std::uint32_t shape, std::uint32_t material);

 private:
  struct Shape {
    std::string members;  // of the mesh primitive, but for the material
    std::string name;     // as JSON; empty: none
    double chord_error = 0.0;
  };

  std::uint32_t add(const core::Mesh& mesh, std::string_view name, double chord_error);
  std::uint32_t add_line(const core::Line& line);
  std::uint32_t note_error(std::uint32_t shape, double scale);

  const core::Scene& scene_;
  double tolerance_;
  GltfOutput& output_;
  GltfWriteReport& report_;
  std::vector<Shape> shapes_;
  std::unordered_map<std::uint32_t, std::uint32_t> of_meshes_;
  std::map<SharedPrimitive::Key, std::uint32_t> of_primitives_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> meshes_;
  std::unordered_map<std::uint32_t, std::uint32_t> materials_;
};

}  // namespace sightline::importers
