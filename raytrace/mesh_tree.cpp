#include "sightline/raytrace/internal/mesh_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/core/internal/openmp.h"
#include "sightline/raytrace/internal/wide_tree.h"

namespace sightline::raytrace {
namespace {

using core::vec3;

bool finite(const vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// 1 over the power of two in (x / 2, x], within what floats hold.
double per_unit_of(double x) {
  const double limited = std::clamp(x, 0x1p-100, 0x1p127);
  return inverse_power_of_two(limited);
}

void fill(TriangleBlock& block, const core::Mesh& mesh, float per_unit, const BoxRef* refs, std::uint32_t count) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
    block.triangles[lane] = lane < count ? refs[lane].id : core::kNone;
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      vec3 p(kNaN);
      if (lane < count) p = per_unit * mesh.positions[mesh.indices[3 * std::size_t(refs[lane].id) + corner]];
      for (int axis = 0; axis < 3; ++axis) block.corners[corner][axis][lane] = p[axis];
    }
  }
}

}  // namespace

core::Enclosure enclosure_of(const MeshTree& tree) {
  core::Mesh mesh;
  for (std::uint32_t place = 0; place < tree.blocks.size() * kLanes; ++place) {
    if (tree.triangle(place) == core::kNone) continue;
    dvec3 corners[3];
    tree.corners(place, corners);
    for (const dvec3& corner : corners) {
      mesh.indices.push_back(std::uint32_t(mesh.positions.size()));
      mesh.positions.emplace_back(corner);
    }
  }
  return core::enclosure(mesh);
}

MeshTree build_mesh_tree(const core::Mesh& mesh, [[maybe_unused]] int threads, const std::stop_token& stop) {
  MeshTree result;
  const std::size_t count = mesh.indices.size() / 3;
  double size = 0.0;
  for (const vec3& p : mesh.positions)
    if (finite(p)) size = std::max(size, double(std::max(std::fabs(p.x), std::max(std::fabs(p.y), std::fabs(p.z)))));
  result.per_unit = per_unit_of(size);
  const auto per_unit = float(result.per_unit);

  core::LargeArray<BoxRef> refs;
  refs.reserve(count);
  core::AabbD bounds;
  for (std::size_t i = 0; i < count; ++i) {
    if (looks_for_stop(i) && stop.stop_requested()) return result;
    const std::uint32_t* corner = &mesh.indices[3 * i];
    const vec3 a = per_unit * mesh.positions[corner[0]], b = per_unit * mesh.positions[corner[1]],
               c = per_unit * mesh.positions[corner[2]];
    if (!finite(a) || !finite(b) || !finite(c)) continue;
    const vec3 low = glm::min(glm::min(a, b), c), high = glm::max(glm::max(a, b), c);
    refs.push_back({{low.x, low.y, low.z}, std::uint32_t(i), {high.x, high.y, high.z}});
    bounds.grow({dvec3(low), dvec3(high)});
  }
  if (refs.empty()) return result;
  BuiltTree tree = build_wide_tree(refs, kLanes, threads, 0, stop);
  if (stop.stop_requested()) return result;
  result.empty = false;
  result.space = space_around(bounds);
  result.root = tree.nodes.empty() ? kLeafBit : 0;
  result.nodes = std::move(tree.nodes);
  result.blocks.resize(tree.leaves.size());
#pragma omp parallel for schedule(static) num_threads(core::team_of(threads)) if (tree.leaves.size() > 4096)
  for (std::size_t i = 0; i < tree.leaves.size(); ++i)
    fill(result.blocks[i], mesh, per_unit, &refs[tree.leaves[i].first], tree.leaves[i].count);
  return result;
}

}  // namespace sightline::raytrace
