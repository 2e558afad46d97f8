#include "sightline/importers/ply/internal/ply_writer.h"

#include <cmath>
#include <limits>

#include "sightline/importers/internal/tessellated.h"
#include "sightline/importers/internal/triangle_file.h"

namespace sightline::importers {
namespace {

std::uint8_t byte_of(float channel) {
  return std::uint8_t(std::lround(255.0f * std::min(1.0f, std::max(0.0f, channel))));
}

}  // namespace

core::Expected<WorldMeshReport> write_ply(const WorldMeshes& meshes, const std::filesystem::path& path) {
  bool normals = false;
  const auto begin = [&](TriangleFile& file, const WorldMeshReport& counts) -> core::Expected<void> {
    if (counts.vertices > std::uint64_t(std::numeric_limits<std::int32_t>::max()))
      return core::fail("the model takes more than 2,147,483,647 vertices, which readers of PLY cannot count");
    normals = counts.normals;
    file.put(std::string_view(fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment metres, z up\nelement vertex {}\nproperty double x\n"
        "property double y\nproperty double z\n{}property uchar red\nproperty uchar green\nproperty uchar blue\n"
        "property uchar alpha\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        counts.vertices, normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
        counts.triangles)));
    return {};
  };
  const auto vertices = [&](TriangleFile& file, const core::Mesh& mesh, const core::Affine& world,
                            std::uint32_t material) {
    const core::MaterialId id = meshes.scene.material_at(material);
    const core::Material look = id.valid() ? meshes.scene.material(id) : core::Material();
    const core::dmat3 map_normal = normal_map(world.linear);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const core::dvec3 at = core::transform_point(world, core::dvec3(mesh.positions[i]));
      for (int axis = 0; axis < 3; ++axis) file.put(at[axis]);
      if (normals) {
        const core::dvec3 normal = map_normal * core::dvec3(mesh.normals[i]);
        const double length = glm::length(normal);
        for (int axis = 0; axis < 3; ++axis) file.put(float(length > 0.0 ? normal[axis] / length : axis / 2));
      }
      for (int channel = 0; channel < 3; ++channel) file.put(byte_of(look.colour[channel]));
      file.put(byte_of(look.alpha));
    }
  };
  std::uint64_t first = 0;
  const auto faces = [&](TriangleFile& file, const core::Mesh& mesh, const core::Affine& world, std::uint32_t) {
    const bool mirrored = glm::determinant(world.linear) < 0.0;
    for (std::size_t triangle = 0; triangle < mesh.indices.size() / 3; ++triangle) {
      file.put(std::uint8_t(3));
      for (const std::uint32_t corner : corners_of(mesh, triangle, mirrored)) file.put(std::int32_t(first + corner));
    }
    first += mesh.positions.size();
  };
  const MeshPass passes[] = {vertices, faces};
  return write_triangle_file(meshes, path, begin, passes);
}

}  // namespace sightline::importers
