#include "sightline/importers/internal/world_meshes.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/importers/import.h"
#include "sightline/importers/internal/tessellated.h"

namespace sightline::importers {

core::Expected<WorldMeshReport> for_each_world_mesh(
    const WorldMeshes& meshes,
    const std::function<core::Expected<void>(const core::Mesh&, const core::Affine&, std::uint32_t)>& visit) {
  const core::Scene& scene = meshes.scene;
  const double tolerance = meshes.tolerance;
  if (!(tolerance > 0.0) || !std::isfinite(tolerance))
    return core::fail(fmt::format("expected a tolerance above 0 m, found {}", tolerance));
  WorldMeshReport report;
  core::Expected<void> done;
  std::uint64_t items = 0, passed = 0;
  scene.for_each_node(meshes.node, [&](core::NodeId node, const auto&...) {
    for (core::ItemId item = scene.first_item(node); item != core::kNoItem; item = scene.next_item(item)) ++items;
  });
  const auto visit_item = [&](core::ItemId item, const core::Scene::ItemState& state) -> core::Expected<void> {
    if (meshes.progress && !meshes.progress(double(passed++) / double(items)))
      return core::fail(std::string(kCancelled));
    const core::Kind kind = scene.kind(item);
    const bool primitive = int(kind) < core::kPrimitiveKindCount;
    core::Mesh made;
    if (primitive && kind != core::Kind::kLine) {
      const double scale = largest_scale(state.world_from_item.linear);
      made = gpuprims::tessellate(scene.primitive(item),
                                  {.chord_tolerance = tolerance / scale, .max_segments = kMostSegments});
      report.largest_chord_error = std::max(report.largest_chord_error, scale * chord_error(made));
    }
    const core::Mesh& mesh = primitive ? made : scene.mesh(scene.mesh_of(item));
    if (mesh.indices.empty() || (state.layers & core::kDefaultLayerMask) == 0) return void(++report.left_out), done;
    ++report.items[std::size_t(kind)];
    report.normals = report.normals && !mesh.normals.empty();
    report.vertices += mesh.positions.size();
    report.triangles += mesh.indices.size() / 3;
    return visit(mesh, state.world_from_item, state.material);
  };
  scene.for_each_node(meshes.node, [&](core::NodeId node, const core::Affine& world, bool visible, std::uint32_t layers,
                                       core::MaterialId material) {
    for (core::ItemId item = scene.first_item(node); item != core::kNoItem && done; item = scene.next_item(item))
      done = visit_item(item, scene.state(item, world, visible, layers, material));
  });
  return done ? core::Expected<WorldMeshReport>(report) : tl::unexpected(done.error());
}

}  // namespace sightline::importers
