#include "sightline/importers/stl/internal/stl_writer.h"

#include <limits>

#include "sightline/importers/internal/triangle_file.h"

namespace sightline::importers {
namespace {

void put(TriangleFile& file, const core::vec3& v) {
  for (int axis = 0; axis < 3; ++axis) file.put(v[axis]);
}

}  // namespace

core::Expected<WorldMeshReport> write_stl(const WorldMeshes& meshes, const std::filesystem::path& path) {
  const auto begin = [](TriangleFile& file, const WorldMeshReport& counts) -> core::Expected<void> {
    if (counts.triangles > std::numeric_limits<std::uint32_t>::max())
      return core::fail("the model takes more than 4,294,967,295 triangles, which STL cannot count");
    std::string header = "metres, z up";  // the first word must not be "solid", which begins texts
    header.resize(80, ' ');
    file.put(std::string_view(header));
    file.put(std::uint32_t(counts.triangles));
    return {};
  };
  const MeshPass triangles = [](TriangleFile& file, const core::Mesh& mesh, const core::Affine& world, std::uint32_t) {
    const bool mirrored = glm::determinant(world.linear) < 0.0;
    for (std::size_t triangle = 0; triangle < mesh.indices.size() / 3; ++triangle) {
      core::dvec3 at[3];
      const auto corners = corners_of(mesh, triangle, mirrored);
      for (std::size_t i = 0; i < 3; ++i) at[i] = core::transform_point(world, core::dvec3(mesh.positions[corners[i]]));
      const core::dvec3 normal = glm::cross(at[1] - at[0], at[2] - at[0]);
      const double length = glm::length(normal);
      put(file, length > 0.0 ? core::vec3(normal / length) : core::vec3(0.0f));
      for (const core::dvec3& corner : at) put(file, core::vec3(corner));
      file.put(std::uint16_t(0));
    }
  };
  return write_triangle_file(meshes, path, begin, {&triangles, 1});
}

}  // namespace sightline::importers
