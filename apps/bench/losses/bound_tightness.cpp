#include "sightline/apps/bench/losses/bound_tightness.h"

#include <algorithm>
#include <limits>
#include <span>

#include "sightline/apps/bench/losses/triangle_distance.h"
#include "sightline/gpuscene/internal/gpu_scene.h"
#include "sightline/lod/internal/cut.h"

namespace sightline::bench {
namespace {

using core::dvec3;
using lod::MeshLevels;

constexpr std::size_t kMostGroups = 24, kMostSamples = 100;  // of an image; of a surface
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct ShownGroup {
  core::Slot slot;
  std::uint32_t group;
};

std::vector<ShownGroup> shown_groups(const lod::ImageError& image, const core::Snapshot& snapshot,
                                     const core::VisibleSet& visible, const gpuscene::MeshPool& meshes) {
  std::vector<ShownGroup> groups;
  lod::CutChooser chooser;
  std::vector<lod::IndexRange> ranges;
  visible.for_each_slot([&](core::Slot slot) {
    const bool mesh = !snapshot.vacant(slot) && int(snapshot.kind(slot)) >= core::kPrimitiveKindCount;
    const MeshLevels* levels = mesh ? meshes.levels(gpuscene::GpuScene::record_of(snapshot, slot)) : nullptr;
    if (!levels) return;
    chooser.choose(*levels, {image, snapshot.world_from_item(slot)}, ranges);
    auto cluster = levels->clusters.begin();
    for (const lod::IndexRange& range : ranges) {
      cluster = std::lower_bound(cluster, levels->clusters.end(), range.first,
                                 [](const lod::Cluster& c, std::uint32_t first) { return c.first_index < first; });
      for (; cluster != levels->clusters.end() && cluster->first_index < range.first + range.count; ++cluster)
        if (cluster->made_by != core::kNone &&
            (groups.empty() || groups.back().slot != slot || groups.back().group != cluster->made_by))
          groups.push_back({slot, cluster->made_by});
    }
  });
  return groups;
}

/// Evenly chosen elements, at most so many.
template <class T>
std::vector<T> some_of(const std::vector<T>& all, std::size_t most) {
  const std::size_t count = std::min(all.size(), most);
  std::vector<T> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  return some;
}

/// A surface as corners of triangles, in runs of neighbours with boxes.
class Surface {
 public:
  Surface(const MeshLevels& levels, const std::vector<core::vec3>& positions, std::vector<std::uint32_t> clusters)
      : levels_(levels), positions_(positions), clusters_(std::move(clusters)) {}

  double distance(const dvec3& point) const {
    double best = kInfinity;
    for (const std::uint32_t number : clusters_) {
      const lod::Cluster& cluster = levels_.clusters[number];
      const dvec3 outside = glm::max(glm::max(dvec3(cluster.box.min) - point, point - dvec3(cluster.box.max)), 0.0);
      if (glm::length(outside) >= best) continue;
      for (std::uint32_t i = cluster.first_index; i < cluster.first_index + cluster.index_count; i += 3)
        best = std::min(best, distance_to_triangle(corner(i) - point, corner(i + 1) - point, corner(i + 2) - point));
    }
    return best;
  }
  /// The largest distance of corners, middles of edges and of triangles from another surface.
  double farthest_from(const Surface& other) const {
    std::vector<std::uint32_t> first;  // index of each triangle
    for (const std::uint32_t number : clusters_)
      for (std::uint32_t i = 0; i < levels_.clusters[number].index_count; i += 3)
        first.push_back(levels_.clusters[number].first_index + i);
    double farthest = 0.0;
    for (const std::uint32_t i : some_of(first, kMostSamples)) {
      const dvec3 a = corner(i), b = corner(i + 1), c = corner(i + 2);
      for (const dvec3& point : {a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0})
        farthest = std::max(farthest, other.distance(point));
    }
    return farthest;
  }

 private:
  dvec3 corner(std::uint32_t index) const { return dvec3(positions_[levels_.indices[index]]); }

  const MeshLevels& levels_;
  const std::vector<core::vec3>& positions_;
  std::vector<std::uint32_t> clusters_;
};

/// The clusters of the mesh itself that a group was made of, through all levels.
std::vector<std::uint32_t> clusters_below(const MeshLevels& levels, std::uint32_t group) {
  std::vector<std::uint32_t> open{group}, own;
  std::vector<bool> met(levels.groups.size());
  while (!open.empty()) {
    const lod::ClusterGroup& next = levels.groups[open.back()];
    open.pop_back();
    for (const std::uint32_t member : std::span(levels.members).subspan(next.first_member, next.member_count)) {
      const std::uint32_t made_by = levels.clusters[member].made_by;
      if (made_by == core::kNone)
        own.push_back(member);
      else if (!met[made_by])
        met[made_by] = true, open.push_back(made_by);
    }
  }
  std::ranges::sort(own);
  return own;
}

/// From the simplified surface to the original one alone: of that, neighbouring groups may replace parts, too.
double measured_error(const MeshLevels& levels, const core::Mesh& mesh, std::uint32_t group) {
  std::vector<std::uint32_t> made;
  for (std::uint32_t i = levels.mesh_clusters; i < levels.clusters.size(); ++i)
    if (levels.clusters[i].made_by == group) made.push_back(i);
  const Surface simplified(levels, mesh.positions, std::move(made));
  const Surface original(levels, mesh.positions, clusters_below(levels, group));
  return simplified.farthest_from(original);
}

}  // namespace

std::vector<double> bound_tightness(const lod::ImageError& image, const core::Snapshot& snapshot,
                                    const core::VisibleSet& visible, const gpuscene::MeshPool& meshes) {
  std::vector<double> ratios;
  for (const ShownGroup& shown : some_of(shown_groups(image, snapshot, visible, meshes), kMostGroups)) {
    const MeshLevels& levels = *meshes.levels(gpuscene::GpuScene::record_of(snapshot, shown.slot));
    const double measured = measured_error(levels, snapshot.mesh(shown.slot), shown.group);
    const double proven = double(levels.groups[shown.group].error);
    if (measured > 0.0 && std::isfinite(measured)) ratios.push_back(proven / measured);
  }
  return ratios;
}

}  // namespace sightline::bench
