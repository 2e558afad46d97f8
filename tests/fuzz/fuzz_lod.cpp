// Levels of detail of meshes as no program writes them: bytes become positions, among them infinities, and triangles.
#include <bit>
#include <cstring>

#include "sightline/lod/internal/cut.h"
#include "sightline/lod/stored_levels.h"
#include "sightline/tests/fuzz/fuzz_target.h"
#include "sightline/tests/lod/surface_twin.h"

namespace {

using namespace sightline;

/// A byte for the form of the positions, two for their number, then positions, then triangles by two bytes a corner.
core::Mesh mesh_of(const std::uint8_t* data, std::size_t size) {
  core::Mesh mesh;
  if (size < 3) return mesh;
  const std::uint8_t form = data[0];
  const std::size_t count = 1 + (data[1] | std::size_t(data[2]) << 8) % 600, bytes = form % 2 ? 12 : 3;
  std::size_t at = 3;
  for (std::size_t i = 0; i < count && at + bytes <= size; ++i, at += bytes) {
    core::vec3 p;
    if (form % 2)
      std::memcpy(&p, data + at, bytes);
    else
      p = core::vec3(data[at], data[at + 1], data[at + 2]) * (form % 4 ? 1e-3f : 1.0f);
    mesh.positions.push_back(p);
  }
  if (mesh.positions.empty()) return mesh;
  for (; at + 2 <= size; at += 2)
    mesh.indices.push_back(std::uint32_t((data[at] | data[at + 1] << 8) % mesh.positions.size()));
  mesh.indices.resize(mesh.indices.size() / 3 * 3);
  if (form % 8 >= 4) mesh.normals.assign(mesh.positions.rbegin(), mesh.positions.rend());
  return mesh;
}

/// The bytes as levels of a torus that somebody has stored.
void read_as_levels(std::span<const std::byte> bytes) {
  static const core::Mesh torus = tests::bumpy_torus(8, 0.1);
  const auto levels = lod::decode(bytes, torus);
  if (!levels) return;
  for (const std::uint32_t index : levels->indices)
    fuzz::require(index < torus.positions.size(), "indices of vertices");
  const core::View view = *core::View::perspective({core::dvec3(20.0), core::dvec3(0.0)}, 0.8, 1.5, 0.1);
  std::vector<lod::IndexRange> ranges;
  lod::CutChooser().choose(*levels, {lod::ImageError(view, 300, 200, 1.0), core::Affine()}, ranges);
  for (const lod::IndexRange& range : ranges)
    fuzz::require(std::size_t(range.first) + range.count <= levels->indices.size(), "ranges of the indices");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const core::Mesh mesh = mesh_of(data, size);
  read_as_levels({reinterpret_cast<const std::byte*>(data), size});
  const lod::MeshLevels levels = lod::build_levels(mesh, 1);
  if (levels.empty()) return 0;
  const auto bytes = lod::encode(levels);
  const auto again = lod::decode(bytes, mesh);
  fuzz::require(again && lod::encode(*again) == bytes && again->indices == levels.indices,
                "levels as they were written");
  std::vector<std::uint32_t> coarsest;
  double error = 0.0;
  for (const lod::Cluster& cluster : levels.clusters) {
    fuzz::require(cluster.index_count <= 3 * lod::kClusterTriangles, "clusters of at most so many triangles");
    fuzz::require(cluster.first_index + cluster.index_count <= levels.indices.size(), "clusters within the indices");
    if (cluster.goes_into != core::kNone && std::isfinite(levels.groups[cluster.goes_into].error)) continue;
    if (cluster.made_by != core::kNone && std::isfinite(levels.groups[cluster.made_by].error))
      error = std::max(error, double(levels.groups[cluster.made_by].error));
    coarsest.insert(coarsest.end(), levels.indices.begin() + cluster.first_index,
                    levels.indices.begin() + cluster.first_index + cluster.index_count);
  }
  for (const std::uint32_t index : levels.indices) fuzz::require(index < mesh.positions.size(), "indices of vertices");
  const tests::SurfaceTwin full(mesh.positions, mesh.indices), coarse(mesh.positions, coarsest);
  tests::MeshRandom random(1);
  const double most = error + 1e-13 * full.size();
  fuzz::require(coarse.farthest_from(full, 30, random) <= most, "the coarsest level within its error");
  fuzz::require(full.farthest_from(coarse, 30, random) <= most, "the mesh within the coarsest level's error");
  return 0;
}
