#include "sightline/importers/gltf/internal/gltf_shapes.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/importers/internal/tessellated.h"

namespace sightline::importers {
namespace {

bool all_finite(const std::vector<core::vec3>& values) {
  return std::all_of(values.begin(), values.end(), [](const core::vec3& v) { return core::is_finite(core::dvec3(v)); });
}

}  // namespace

GltfShapes::Scaled GltfShapes::shape(core::ItemId item, const core::Affine& world_from_item) {
  const core::Kind kind = scene_.kind(item);
  if (int(kind) >= core::kPrimitiveKindCount) {
    const core::MeshId mesh = scene_.mesh_of(item);
    const auto [at, added] = of_meshes_.try_emplace(mesh.index, core::kNone);
    if (added) at->second = add(scene_.mesh(mesh), scene_.mesh(mesh).name, 0.0);
    return {at->second};
  }
  const SharedPrimitive shared = shared_primitive(scene_.primitive(item), world_from_item.linear);
  if (shared.empty()) return {};
  const auto [at, added] = of_primitives_.try_emplace(shared.key, core::kNone);
  if (added && kind == core::Kind::kLine) {
    at->second = add_line(std::get<core::Line>(shared.primitive));
  } else if (added) {
    const core::Mesh mesh = shared.triangles(tolerance_);
    at->second = add(mesh, core::name_of(kind), chord_error(mesh));
  }
  return {note_error(at->second, shared.bend), shared.scale};
}

std::uint32_t GltfShapes::baked(core::ItemId item, const core::dmat3& linear, const core::Affine& world_from_item) {
  const core::Kind kind = scene_.kind(item);
  const bool primitive = int(kind) < core::kPrimitiveKindCount;
  if (kind == core::Kind::kLine) return core::kNone;
  const double scale = largest_scale(world_from_item.linear);
  if (primitive && !(scale > 0.0)) return core::kNone;
  core::Mesh mesh = primitive ? gpuprims::tessellate(scene_.primitive(item), {.chord_tolerance = tolerance_ / scale,
                                                                              .max_segments = kMostSegments})
                              : scene_.mesh(scene_.mesh_of(item));
  const double error = primitive ? chord_error(mesh) : 0.0;
  const core::dmat3 normals = normal_map(linear);
  for (core::vec3& p : mesh.positions) p = core::vec3(linear * core::dvec3(p));
  for (core::vec3& n : mesh.normals) {
    const core::dvec3 normal = normals * core::dvec3(n);
    const double length = glm::length(normal);  // far from 1 where the map is in millimetres
    n = length > 0.0 ? core::vec3(normal / length) : core::vec3(0, 0, 1);
  }
  if (glm::determinant(linear) < 0.0)
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
  return note_error(add(mesh, primitive ? std::string(core::name_of(kind)) : mesh.name, error), scale);
}

std::uint32_t GltfShapes::note_error(std::uint32_t shape, double scale) {
  if (shape != core::kNone)
    report_.largest_chord_error = std::max(report_.largest_chord_error, scale * shapes_[shape].chord_error);
  return shape;
}

std::uint32_t GltfShapes::add(const core::Mesh& mesh, std::string_view name, double chord_error) {
  if (mesh.indices.empty() || !all_finite(mesh.positions)) return core::kNone;
  Shape shape;
  const std::uint32_t positions = output_.positions(mesh.positions);
  shape.members = fmt::format("\"attributes\":{{\"POSITION\":{}", positions);
  if (!mesh.normals.empty()) shape.members += fmt::format(",\"NORMAL\":{}", output_.normals(mesh.normals));
  shape.members += fmt::format("}},\"indices\":{}", output_.indices(mesh.indices, mesh.positions.size()));
  if (!name.empty()) shape.name = json_string(name);
  shape.chord_error = chord_error;
  ++report_.meshes;
  report_.vertices += mesh.positions.size();
  report_.triangles += mesh.indices.size() / 3;
  shapes_.push_back(std::move(shape));
  return std::uint32_t(shapes_.size() - 1);
}

std::uint32_t GltfShapes::add_line(const core::Line& line) {
  const std::vector<core::vec3> ends = {{line.from, 0, 0}, {line.to, 0, 0}};
  if (!all_finite(ends)) return core::kNone;
  shapes_.push_back({fmt::format("\"attributes\":{{\"POSITION\":{}}},\"mode\":1", output_.positions(ends)),
                     json_string(core::name_of(core::Kind::kLine)), 0.0});
  ++report_.meshes;
  report_.vertices += ends.size();
  return std::uint32_t(shapes_.size() - 1);
}

std::uint32_t GltfShapes::mesh(std::uint32_t shape, std::uint32_t material) {
  const auto [at, added] = meshes_.try_emplace({shape, material}, core::kNone);
  if (!added) return at->second;
  std::string look;
  if (material != core::kNone) {
    const auto [known, first] = materials_.try_emplace(material, 0);
    if (first) known->second = output_.material(scene_.material(scene_.material_at(material)));
    look = fmt::format(",\"material\":{}", known->second);
  }
  const Shape& of = shapes_[shape];
  const std::string name = of.name.empty() ? "" : fmt::format("\"name\":{},", of.name);
  return at->second = output_.mesh(fmt::format("{}\"primitives\":[{{{}{}}}]", name, of.members, look));
}

}  // namespace sightline::importers
