#include "sightline/apps/common/up_axis.h"

#include <algorithm>
#include <array>

#include "sightline/importers/internal/extension.h"

namespace sightline::apps {
namespace {

using core::dvec3;

template <class Visit>
void for_each_triangle(const core::Scene& scene, const Visit& visit) {
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
    if (!scene.contains_item(item) || scene.kind(item) != core::Kind::kMesh) continue;
    const core::Mesh& mesh = scene.mesh(scene.mesh_of(item));
    const core::Affine placed = scene.world_from_node(scene.node_of(item)) * scene.placement(item);
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      std::array<dvec3, 3> corners;
      for (std::size_t k = 0; k < 3; ++k)
        corners[k] = core::transform_point(placed, dvec3(mesh.positions[mesh.indices[i + k]]));
      visit(corners);
    }
  }
}

}  // namespace

bool leave_up_open(std::span<const std::string> files) {
  return std::all_of(files.begin(), files.end(), [](const std::string& file) {
    const std::string extension = importers::lower_case_extension(file);
    return extension == ".obj" || extension == ".ply" || extension == ".stl";
  });
}

bool seems_to_have_y_up(const core::Scene& scene) {
  constexpr double kBase = 0.03, kLeast = 0.05, kTimes = 3.0;
  constexpr double kThick = 0.02;  // else it is a sheet
  const core::AabbD box = scene.bounds(scene.root());
  const dvec3 size = box.size();
  if (box.empty() || size.y < kThick * std::max(size.x, size.z)) return false;
  dvec3 base(0.0);
  for_each_triangle(scene, [&](const std::array<dvec3, 3>& corners) {
    const dvec3 across = 0.5 * glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const dvec3 highest = glm::max(corners[0], glm::max(corners[1], corners[2]));
    for (int axis = 1; axis < 3; ++axis)
      if (highest[axis] <= box.min[axis] + kBase * size[axis]) base[axis] += std::max(0.0, -across[axis]);
  });
  const double y = base.y / std::max(size.x * size.z, 1e-300), z = base.z / std::max(size.x * size.y, 1e-300);
  return y >= kLeast && y >= kTimes * z;
}

}  // namespace sightline::apps
