#include "sightline/study/tables/ray_models.h"

#include <utility>

#include "sightline/apps/common/tessellated_scene.h"
#include "sightline/core/snapshot.h"

namespace sightline::study {
namespace {

rays::GeneratedMesh triangles_of(const core::Scene& scene) {
  constexpr int kSegments = 24;
  const core::Scene whole = apps::tessellated(scene, kSegments);
  const core::Snapshot snapshot(whole);
  std::vector<core::dvec3> positions;
  std::vector<std::uint32_t> indices;
  core::AabbD bounds;
  for (core::Slot s = 0; s < snapshot.size(); ++s) {
    if (snapshot.vacant(s) || snapshot.kind(s) != core::Kind::kMesh) continue;
    const core::Affine world_from_item = snapshot.world_from_item(s);
    const core::Mesh& mesh = snapshot.mesh(s);
    const std::uint32_t first = std::uint32_t(positions.size());
    for (const core::vec3& p : mesh.positions) {
      positions.push_back(core::transform_point(world_from_item, core::dvec3(p)));
      bounds.grow(positions.back());
    }
    for (const std::uint32_t i : mesh.indices) indices.push_back(first + i);
  }
  std::vector<core::vec3> centred;
  centred.reserve(positions.size());
  for (const core::dvec3& p : positions) centred.push_back(core::vec3(p - bounds.centre()));
  return {std::move(centred), std::move(indices)};
}

}  // namespace

core::Expected<rays::GeneratedMesh> load_triangles(apps::ModelOptions options, const std::string& file) {
  options.files = {file};
  auto loaded = apps::load_model(options);
  if (!loaded) return tl::unexpected(loaded.error());
  return triangles_of(*loaded->scene);
}

}  // namespace sightline::study
