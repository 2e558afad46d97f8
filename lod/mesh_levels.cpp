#include "sightline/lod/mesh_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sightline/core/affine.h"
#include "sightline/core/block_order.h"
#include "sightline/core/internal/hash.h"
#include "sightline/core/internal/openmp.h"
#include "sightline/lod/internal/cluster_groups.h"
#include "sightline/lod/internal/cluster_tree.h"
#include "sightline/lod/internal/simplify.h"
#include "sightline/lod/internal/solid_shells.h"
#include "sightline/lod/internal/surface_deviation.h"

namespace sightline::lod {
namespace {

using core::Aabb;
using core::dvec3;
using core::kNone;
using core::vec3;

constexpr std::uint32_t kGroupClusters = 8;
constexpr std::size_t kFewestTriangles = 32;  // of a group that is simplified: half of these are a box or two
constexpr double kLeastGain = 0.85;           // share of triangles that a simplification must not exceed

using Corners = std::vector<std::uint32_t>;

Aabb box_of(std::span<const vec3> positions, std::span<const std::uint32_t> corners) {
  Aabb box;
  for (const std::uint32_t corner : corners) box.grow({positions[corner], positions[corner]});
  return box;
}

/// For each vertex, the first vertex of the same position and normal.
std::vector<std::uint32_t> equal_vertices(const core::Mesh& mesh, std::span<const std::uint32_t> welded) {
  if (mesh.normals.empty()) return {welded.begin(), welded.end()};
  std::vector<std::uint32_t> next(mesh.positions.size(), kNone), equal(mesh.positions.size());
  for (std::uint32_t i = 0; i < equal.size(); ++i) {
    std::uint32_t at = welded[i];
    while (mesh.normals[at] != mesh.normals[i] && at != i && next[at] != kNone) at = next[at];
    if (at != i && mesh.normals[at] != mesh.normals[i]) next[at] = i, at = i;
    equal[i] = at;
  }
  return equal;
}

/// Distances of a triangle's surface, and of the original surface that it stands for, from the other one.
struct TriangleErrors {
  std::vector<float> out, back;

  void clear() { out.clear(), back.clear(); }
  void append(const TriangleErrors& other, std::size_t first, std::size_t count) {
    for (const auto part : {&TriangleErrors::out, &TriangleErrors::back}) {
      const auto begin = (other.*part).begin() + std::ptrdiff_t(first);
      (this->*part).insert((this->*part).end(), begin, begin + std::ptrdiff_t(count));
    }
  }
};

/// What becomes of a group.
struct Simplified {
  Corners corners;  // empty: nothing that is worth keeping
  TriangleErrors errors;
  Deviation deviation;  // from the original surface, but for the angle
};

/// Corners of triangles in the order in which clusters take them.
Corners ordered(std::span<const vec3> positions, std::span<const std::uint32_t> corners, int threads) {
  std::vector<Aabb> boxes(corners.size() / 3);
  for (std::size_t i = 0; i < boxes.size(); ++i) boxes[i] = box_of(positions, corners.subspan(3 * i, 3));
  const auto order = core::block_order(boxes, {.smallest_block = kClusterTriangles, .threads = threads});
  Corners result;
  result.reserve(corners.size());
  for (const std::uint32_t triangle : order)
    result.insert(result.end(), corners.begin() + 3 * triangle, corners.begin() + 3 * triangle + 3);
  return result;
}

/// Simplifies a group among its own points, so that time and memory follow its size.
class GroupSimplifier {
 public:
  GroupSimplifier(const core::Mesh& mesh, std::span<const std::uint32_t> welded)
      : mesh_(mesh), welded_(welded), number_of_(mesh.positions.size(), kNone) {}

  /// `shared`: by welded vertex, whether several groups have it.
  Simplified run(std::span<const std::uint32_t> corners, const TriangleErrors& errors,
                 std::span<const std::uint8_t> shared) {
    gather(corners, shared);
    const std::size_t triangles = corners.size() / 3;
    Simplified result;
    local_ = simplify(positions_, corners_, locked_, (triangles + 1) / 2);
    forget();
    if (local_.empty() || double(local_.size()) > kLeastGain * double(corners.size())) return result;
    local_ = ordered(positions_, local_, 1);
    for (const std::uint32_t corner : local_) result.corners.push_back(vertices_[corner]);
    prove(errors, result);
    return result;
  }

 private:
  void gather(std::span<const std::uint32_t> corners, std::span<const std::uint8_t> shared) {
    vertices_.clear(), positions_.clear(), locked_.clear(), corners_.clear();
    for (const std::uint32_t corner : corners) {
      std::uint32_t& number = number_of_[corner];
      if (number == kNone) {
        number = std::uint32_t(vertices_.size());
        vertices_.push_back(corner);
        positions_.push_back(mesh_.positions[corner]);
        locked_.push_back(shared[welded_[corner]]);
      }
      corners_.push_back(number);
    }
  }
  void forget() {
    for (const std::uint32_t vertex : vertices_) number_of_[vertex] = kNone;
  }
  /// Proves the deviation of the simplified triangles from the former ones and back, by points without regard to
  /// normals.
  void prove(const TriangleErrors& errors, Simplified& result) {
    points_.clear();
    for (std::uint32_t i = 0; i < vertices_.size(); ++i) {
      std::uint32_t& number = number_of_[welded_[vertices_[i]]];
      if (number == kNone) {
        number = std::uint32_t(points_.size());
        points_.emplace_back(positions_[i]);
      }
      point_of_.resize(vertices_.size());
      point_of_[i] = number;
    }
    for (const std::uint32_t vertex : vertices_) number_of_[welded_[vertex]] = kNone;
    for (std::uint32_t& corner : corners_) corner = point_of_[corner];
    coarse_.clear();
    for (const std::uint32_t corner : local_) coarse_.push_back(point_of_[corner]);
    const auto rounded_up = [](std::span<const double> distances, std::vector<float>& errors_up) {
      for (const double distance : distances) errors_up.push_back(core::round_up(distance));
    };
    result.deviation = proof_.bound({points_, corners_, errors.back}, {points_, coarse_});
    rounded_up(proof_.of_to(), result.errors.back);
    result.deviation.grow(proof_.bound({points_, coarse_}, {points_, corners_, errors.out}));
    rounded_up(proof_.of_from(), result.errors.out);
  }

  const core::Mesh& mesh_;
  std::span<const std::uint32_t> welded_;
  std::vector<std::uint32_t> number_of_;  // by vertex: its number in the group
  Corners vertices_, corners_, local_, point_of_, coarse_;
  std::vector<vec3> positions_;
  std::vector<std::uint8_t> locked_;
  std::vector<dvec3> points_;
  SurfaceDeviation proof_;
};

class Builder {
 public:
  Builder(const core::Mesh& mesh, int threads, const std::stop_token& stop)
      : mesh_(mesh), threads_(threads), stop_(stop), welded_(core::weld(mesh.positions)) {}

  /// `coarser`: with all levels.
  MeshLevels build(bool coarser) {
    Corners corners = mesh_.indices;
    levels_.solid_indices = solid_shells_first(mesh_.positions, corners);
    const std::vector<std::uint32_t> equal = equal_vertices(mesh_, welded_);
    for (std::uint32_t& corner : corners) corner = equal[corner];
    append_clusters(ordered(mesh_.positions, std::span(corners).first(levels_.solid_indices), threads_), kNone);
    if (stop_.stop_requested()) return {};
    append_clusters(ordered(mesh_.positions, std::span(corners).subspan(levels_.solid_indices), threads_), kNone);
    levels_.mesh_clusters = std::uint32_t(levels_.clusters.size());
    for (std::uint32_t first = 0; coarser && first < levels_.clusters.size();) {
      const auto end = std::uint32_t(levels_.clusters.size());
      if (!add_level(first, end)) break;
      first = end;
    }
    if (stop_.stop_requested()) return {};
    list_roots(levels_);
    return std::move(levels_);
  }

 private:
  std::span<const std::uint32_t> corners_of(const Cluster& cluster) const {
    return std::span(levels_.indices).subspan(cluster.first_index, cluster.index_count);
  }

  void append_clusters(const Corners& corners, std::uint32_t made_by) {
    const std::size_t most = 3 * kClusterTriangles;
    for (std::size_t begin = 0; begin < corners.size(); begin += most) {
      const std::size_t count = std::min(most, corners.size() - begin);
      const auto part = std::span(corners).subspan(begin, count);
      levels_.clusters.push_back(
          {std::uint32_t(levels_.indices.size()), std::uint32_t(count), made_by, kNone, box_of(mesh_.positions, part)});
      levels_.indices.insert(levels_.indices.end(), part.begin(), part.end());
    }
  }

  /// Simplifies the clusters first … end - 1. False when that gives nothing more.
  bool add_level(std::uint32_t first, std::uint32_t end) {
    const std::vector<std::uint32_t> groups = groups_of(first, end);
    std::vector<std::vector<std::uint32_t>> members;
    for (std::uint32_t i = 0; i < groups.size(); ++i) {
      if (groups[i] >= members.size()) members.resize(groups[i] + 1);
      members[groups[i]].push_back(first + i);
    }
    find_shared(members);
    const std::vector<Simplified> simplified = simplify_all(members, levels_.clusters[first].first_index / 3);
    errors_.clear();
    for (std::size_t i = 0; i < members.size(); ++i)
      if (!simplified[i].corners.empty()) add_group(members[i], simplified[i]);
    return levels_.clusters.size() > end;
  }

  std::vector<std::uint32_t> groups_of(std::uint32_t first, std::uint32_t end) const {
    const std::uint32_t count = end - first;
    if (count <= kGroupClusters) return std::vector<std::uint32_t>(count, 0);
    return group_clusters(count, contacts(first, end), kGroupClusters);
  }

  /// Edges at the border of each cluster, and of these the ones that two clusters have.
  std::vector<Contact> contacts(std::uint32_t first, std::uint32_t end) const;

  /// Marks the positions that several groups have.
  void find_shared(const std::vector<std::vector<std::uint32_t>>& members) {
    std::vector<std::uint32_t> group_of(welded_.size(), kNone);
    shared_.assign(welded_.size(), 0);
    for (std::uint32_t group = 0; group < members.size(); ++group)
      for (const std::uint32_t member : members[group])
        for (const std::uint32_t corner : corners_of(levels_.clusters[member])) {
          const std::uint32_t vertex = welded_[corner];
          if (group_of[vertex] == kNone) group_of[vertex] = group;
          if (group_of[vertex] != group) shared_[vertex] = 1;
        }
  }

  /// `first`: triangle of the first error.
  std::vector<Simplified> simplify_all(const std::vector<std::vector<std::uint32_t>>& members,
                                       std::uint32_t first) const {
    std::vector<Simplified> simplified(members.size());
#pragma omp parallel num_threads(members.size() < 4 ? 1 : core::team_of(threads_))
    {
      GroupSimplifier simplifier(mesh_, welded_);
      Corners corners;
      TriangleErrors errors;
#pragma omp for schedule(dynamic, 4)
      for (std::size_t i = 0; i < members.size(); ++i) {
        corners.clear(), errors.clear();
        for (const std::uint32_t member : members[i]) {
          const Cluster& cluster = levels_.clusters[member];
          const auto part = corners_of(cluster);
          corners.insert(corners.end(), part.begin(), part.end());
          if (cluster.made_by != kNone) errors.append(errors_, cluster.first_index / 3 - first, part.size() / 3);
        }
        if (corners.size() > 3 * kFewestTriangles && !stop_.stop_requested())
          simplified[i] = simplifier.run(corners, errors, shared_);
      }
    }
    return simplified;
  }

  void add_group(std::span<const std::uint32_t> members, const Simplified& simplified) {
    const std::uint32_t number = join_clusters(levels_, members);
    ClusterGroup& group = levels_.groups[number];
    const double error = simplified.deviation.distance;
    group.error =
        std::isfinite(error) ? std::max(group.error, core::round_up(error)) : std::numeric_limits<float>::infinity();
    group.angle = core::round_up(std::min(double(group.angle) + simplified.deviation.angle, std::numbers::pi));
    append_clusters(simplified.corners, number);
    errors_.append(simplified.errors, 0, simplified.errors.out.size());
  }

  const core::Mesh& mesh_;
  int threads_;
  std::stop_token stop_;
  std::vector<std::uint32_t> welded_;
  std::vector<std::uint8_t> shared_;  // by welded vertex
  TriangleErrors errors_;             // of the last level's triangles
  MeshLevels levels_;
};

std::vector<Contact> Builder::contacts(std::uint32_t first, std::uint32_t end) const {
  struct Edge {
    std::uint64_t ends;
    std::uint32_t cluster;
  };
  std::vector<Edge> borders, edges;
  for (std::uint32_t i = first; i < end; ++i) {
    edges.clear();
    const auto corners = corners_of(levels_.clusters[i]);
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const std::uint64_t a = welded_[corners[k]], b = welded_[corners[k % 3 == 2 ? k - 2 : k + 1]];
      if (a != b) edges.push_back({std::min(a, b) << 32 | std::max(a, b), i - first});
    }
    std::ranges::sort(edges, {}, &Edge::ends);
    for (std::size_t k = 0; k < edges.size();) {
      std::size_t next = k + 1;
      while (next < edges.size() && edges[next].ends == edges[k].ends) ++next;
      if (next == k + 1) borders.push_back(edges[k]);
      k = next;
    }
  }
  std::ranges::sort(
      borders, [](const Edge& a, const Edge& b) { return a.ends != b.ends ? a.ends < b.ends : a.cluster < b.cluster; });
  std::vector<std::uint64_t> pairs;
  for (std::size_t k = 0; k + 1 < borders.size(); ++k)
    if (borders[k].ends == borders[k + 1].ends && borders[k].cluster != borders[k + 1].cluster)
      pairs.push_back(std::uint64_t(borders[k].cluster) << 32 | borders[k + 1].cluster);
  std::ranges::sort(pairs);
  std::vector<Contact> contacts;
  for (std::size_t k = 0; k < pairs.size();) {
    std::size_t next = k + 1;
    while (next < pairs.size() && pairs[next] == pairs[k]) ++next;
    contacts.push_back({std::uint32_t(pairs[k] >> 32), std::uint32_t(pairs[k]), std::uint32_t(next - k)});
    k = next;
  }
  return contacts;
}

/// All coordinates are finite, and it is worth it.
bool can_divide(const core::Mesh& mesh) {
  const auto finite = [](const vec3& p) { return core::is_finite(dvec3(p)); };
  return needs_levels(mesh) && std::ranges::all_of(mesh.positions, finite);
}

}  // namespace

bool needs_levels(const core::Mesh& mesh) {
  return mesh.indices.size() > 3 * kFewestTriangles;
}

MeshLevels build_clusters(const core::Mesh& mesh, int threads, const std::stop_token& stop) {
  return can_divide(mesh) ? Builder(mesh, threads, stop).build(false) : MeshLevels();
}

MeshLevels build_levels(const core::Mesh& mesh, int threads, const std::stop_token& stop) {
  return can_divide(mesh) ? Builder(mesh, threads, stop).build(true) : MeshLevels();
}

}  // namespace sightline::lod
