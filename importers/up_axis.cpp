#include "sightline/importers/internal/up_axis.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace sightline::importers {
namespace {

using core::AabbD;
using core::dvec3;

struct PlacedMesh {
  const core::Mesh* mesh;
  core::Affine file_from_mesh;
  AabbD box;  // in the file's coordinates
};

/// The meshes below a node, in its coordinates.
std::vector<PlacedMesh> meshes_below(const core::Scene& scene, core::NodeId top) {
  std::vector<PlacedMesh> meshes;
  const core::Affine world_from_file = scene.world_from_node(top);
  const core::dmat3 linear = glm::inverse(world_from_file.linear);
  const core::Affine file_from_world{linear, -(linear * world_from_file.origin)};
  scene.for_each_node(top, [&](core::NodeId node, const core::Affine& world, bool, std::uint32_t, core::MaterialId) {
    for (core::ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item)) {
      if (scene.kind(item) != core::Kind::kMesh) continue;
      const core::Affine placed = file_from_world * world * scene.placement(item);
      const AabbD box = scene.bounds_under(item, placed);
      if (!box.empty()) meshes.push_back({&scene.mesh(scene.mesh_of(item)), placed, box});
    }
  });
  return meshes;
}

/// Areas of the bases of y and z, and of what lies opposite to them.
struct Bases {
  dvec3 low{0.0}, high{0.0};

  void add(const std::array<dvec3, 3>& corners, const AabbD& lower, const AabbD& upper) {
    const dvec3 across = 0.5 * glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const dvec3 lowest = glm::min(corners[0], glm::min(corners[1], corners[2]));
    const dvec3 highest = glm::max(corners[0], glm::max(corners[1], corners[2]));
    for (int axis = 1; axis < 3; ++axis) {
      if (highest[axis] <= lower.max[axis]) low[axis] += std::max(0.0, -across[axis]);
      if (lowest[axis] >= upper.min[axis]) high[axis] += std::max(0.0, across[axis]);
    }
  }
};

}  // namespace

std::optional<UpAxis> up_axis_in_comment(std::string_view text) {
  std::string words = " ";
  for (const char c : text) {
    const char lower = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    if ((lower >= 'a' && lower <= 'z') || (lower >= '0' && lower <= '9'))
      words += lower;
    else if (words.back() != ' ')
      words += ' ';
  }
  words += ' ';
  for (const auto& [name, axis] : {std::pair('y', UpAxis::kY), {'z', UpAxis::kZ}})
    for (const std::string_view pattern : {" ? up ", " ?up ", " ? axis up ", " ? axis is up ", " ? is up ", " up ? ",
                                           " up axis ? ", " up axis is ? ", " upaxis ? "}) {
      std::string wanted(pattern);
      std::replace(wanted.begin(), wanted.end(), '?', name);
      if (words.find(wanted) != std::string::npos) return axis;
    }
  return {};
}

bool seems_to_have_y_up(const core::Scene& scene, core::NodeId file_node) {
  constexpr double kBase = 0.03, kLeast = 0.05, kTimes = 3.0;
  constexpr double kThick = 0.02;  // else it is a sheet
  const std::vector<PlacedMesh> meshes = meshes_below(scene, file_node);
  AabbD box;
  for (const PlacedMesh& mesh : meshes) box.grow(mesh.box);
  if (box.empty()) return false;
  const dvec3 size = box.size();
  if (!(size.y >= kThick * std::max(size.x, size.z))) return false;
  const AabbD lower{box.min, box.min + kBase * size}, upper{box.max - kBase * size, box.max};
  Bases bases;
  for (const PlacedMesh& placed : meshes) {
    const AabbD& own = placed.box;
    if (own.min.y > lower.max.y && own.min.z > lower.max.z && own.max.y < upper.min.y && own.max.z < upper.min.z)
      continue;
    const core::Mesh& mesh = *placed.mesh;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      std::array<dvec3, 3> corners;
      for (std::size_t k = 0; k < 3; ++k)
        corners[k] = core::transform_point(placed.file_from_mesh, dvec3(mesh.positions[mesh.indices[i + k]]));
      bases.add(corners, lower, upper);
    }
  }
  const double across_y = std::max(size.x * size.z, 1e-300), across_z = std::max(size.x * size.y, 1e-300);
  const double y = bases.low.y / across_y;
  const double others = std::max({bases.high.y / across_y, bases.low.z / across_z, bases.high.z / across_z});
  return y >= kLeast && y >= kTimes * others;
}

}  // namespace sightline::importers
