#include "sightline/lod/mesh_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "sightline/core/affine.h"
#include "sightline/core/block_order.h"
#include "sightline/core/internal/hash.h"
#include "sightline/core/internal/openmp.h"
#include "sightline/lod/internal/cluster_groups.h"
#include "sightline/lod/internal/cluster_tree.h"
#include "sightline/lod/internal/loose_parts.h"
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
constexpr double kAsFew = 1.1;                // times the triangles are as few

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

/// Which of the vertices at a place coarser triangles use. Each has the normal of some of the faces that meet there:
/// one where they are smooth, one for each side of a crease, and one for each face where faces are flat.
class VerticesAtPlaces {
 public:
  /// `equal`: as equal_vertices() has it.
  VerticesAtPlaces(const core::Mesh& mesh, std::span<const std::uint32_t> welded, std::span<const std::uint32_t> equal)
      : mesh_(mesh) {
    const auto is_own = [&](std::uint32_t i) { return equal[i] == i; };
    first_.assign(welded.size() + 1, 0);
    for (std::uint32_t i = 0; i < welded.size(); ++i) first_[welded[i]] += is_own(i);
    std::uint32_t sum = 0;
    for (std::uint32_t& first : first_) sum += first, first = sum;
    vertices_.resize(sum);
    for (auto i = std::uint32_t(welded.size()); i-- > 0;)
      if (is_own(i)) vertices_[--first_[welded[i]]] = i;
    if (mesh.normals.empty()) return;
    double agree = 0.0;
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const vec3 normal = normal_of(&mesh.indices[i]);
      for (std::size_t k = 0; k < 3; ++k) agree += double(glm::dot(normal, mesh.normals[mesh.indices[i + k]]));
    }
    inward_ = agree < 0.0;
  }

  /// Appends a triangle of welded vertices, by vertices there whose normals are nearest to its own.
  void append(const std::uint32_t (&triangle)[3], Corners& corners) const {
    const vec3 normal = normal_of(triangle);
    for (const std::uint32_t place : triangle) corners.push_back(nearest(place, inward_ ? -normal : normal));
  }

 private:
  /// A triangle's, by its corners, of any length.
  vec3 normal_of(const std::uint32_t* t) const {
    const vec3& a = mesh_.positions[t[0]];
    return glm::cross(mesh_.positions[t[1]] - a, mesh_.positions[t[2]] - a);
  }
  std::uint32_t nearest(std::uint32_t place, const vec3& normal) const {
    const auto here = std::span(vertices_).subspan(first_[place], first_[place + 1] - first_[place]);
    if (here.size() == 1) return here[0];
    return *std::ranges::max_element(here, {}, [&](std::uint32_t i) { return glm::dot(mesh_.normals[i], normal); });
  }

  const core::Mesh& mesh_;
  std::vector<std::uint32_t> first_, vertices_;  // in vertices_, by welded vertex
  bool inward_ = false;                          // normals point against the sense of the triangles
};

/// Simplifies a group among its own points, by their positions, so that time and memory follow its size.
class GroupSimplifier {
 public:
  GroupSimplifier(const core::Mesh& mesh, std::span<const std::uint32_t> welded, const VerticesAtPlaces& vertices)
      : mesh_(mesh), welded_(welded), vertices_(vertices), number_of_(mesh.positions.size(), kNone) {}

  /// `shared`: by welded vertex, whether several groups have it.
  Simplified run(std::span<const std::uint32_t> corners, const TriangleErrors& errors,
                 std::span<const std::uint8_t> shared) {
    gather(corners, shared);
    for (const std::uint32_t place : places_) number_of_[place] = kNone;
    const std::size_t target = corners.size() / 6, most = std::size_t(kLeastGain * double(corners.size()));
    Simplified result;
    coarse_ = simplify(positions_, corners_, locked_, target);
    if (!coarse_.empty() && coarse_.size() <= most) take_coarse(errors, result);
    // Collapses make flat parts of loose ones, and then of these anything, since quadrics see no difference.
    const std::size_t allowed = result.corners.empty() ? most : std::size_t(kAsFew * double(coarse_.size()));
    coarse_ = without_loose_parts(positions_, corners_, locked_, target);
    if (coarse_.empty() || coarse_.size() > allowed) return result;
    Simplified fewer;
    take_coarse(errors, fewer);
    const bool better = result.corners.empty() || fewer.deviation.distance < result.deviation.distance;
    return better ? fewer : result;
  }

 private:
  void gather(std::span<const std::uint32_t> corners, std::span<const std::uint8_t> shared) {
    places_.clear(), positions_.clear(), locked_.clear(), corners_.clear();
    for (const std::uint32_t corner : corners) {
      const std::uint32_t place = welded_[corner];
      std::uint32_t& number = number_of_[place];
      if (number == kNone) {
        number = std::uint32_t(places_.size());
        places_.push_back(place);
        positions_.push_back(mesh_.positions[place]);
        locked_.push_back(shared[place]);
      }
      corners_.push_back(number);
    }
  }
  void take_coarse(const TriangleErrors& errors, Simplified& result) {
    coarse_ = ordered(positions_, coarse_, 1);
    for (std::size_t i = 0; i < coarse_.size(); i += 3)
      vertices_.append({places_[coarse_[i]], places_[coarse_[i + 1]], places_[coarse_[i + 2]]}, result.corners);
    prove(errors, result);
  }
  /// Proves the deviation of the simplified triangles from the former ones and back, without regard to normals.
  void prove(const TriangleErrors& errors, Simplified& result) {
    points_.assign(positions_.begin(), positions_.end());
    const auto rounded_up = [](std::span<const double> distances, std::vector<float>& errors_up) {
      for (const double distance : distances) errors_up.push_back(core::round_up(distance));
    };
    result.deviation = proof_.bound({points_, corners_, errors.back}, {points_, coarse_});
    rounded_up(proof_.of_to(), result.errors.back);
    near_.assign(proof_.near_to().begin(), proof_.near_to().end());
    result.deviation.grow(
        proof_.bound({points_, coarse_}, {points_, corners_, errors.out}, {result.deviation.distance, near_}));
    rounded_up(proof_.of_from(), result.errors.out);
  }

  const core::Mesh& mesh_;
  std::span<const std::uint32_t> welded_;
  const VerticesAtPlaces& vertices_;
  std::vector<std::uint32_t> number_of_;  // by welded vertex: its number in the group
  Corners places_, corners_, coarse_;     // places: welded vertices, by number
  Corners near_;                          // by coarse triangle: a former one near it
  std::vector<vec3> positions_;
  std::vector<std::uint8_t> locked_;
  std::vector<dvec3> points_;
  SurfaceDeviation proof_;
};

class Builder {
 public:
  Builder(const core::Mesh& mesh, int threads, const std::stop_token& stop)
      : mesh_(mesh),
        threads_(threads),
        stop_(stop),
        welded_(core::weld(mesh.positions)),
        equal_(equal_vertices(mesh, welded_)) {}

  /// `coarser`: with all levels.
  MeshLevels build(bool coarser) {
    Corners corners = mesh_.indices;
    levels_.solid_indices = solid_shells_first(mesh_.positions, corners);
    for (std::uint32_t& corner : corners) corner = equal_[corner];
    append_clusters(ordered(mesh_.positions, std::span(corners).first(levels_.solid_indices), threads_), kNone);
    if (stop_.stop_requested()) return {};
    append_clusters(ordered(mesh_.positions, std::span(corners).subspan(levels_.solid_indices), threads_), kNone);
    levels_.mesh_clusters = std::uint32_t(levels_.clusters.size());
    if (coarser) vertices_.emplace(mesh_, welded_, equal_);
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
    shared_ = shared_by_groups(members, first);
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

  /// Marks the welded vertices of triangles that owners have which several owners have.
  class Sharing {
   public:
    explicit Sharing(const Builder& builder)
        : builder_(builder), owner_(builder.welded_.size(), kNone), shared_(owner_.size(), 0) {}
    void mark(const Cluster& cluster, std::uint32_t owner) {
      for (const std::uint32_t corner : builder_.corners_of(cluster)) {
        const std::uint32_t vertex = builder_.welded_[corner];
        if (owner_[vertex] == kNone) owner_[vertex] = owner;
        if (owner_[vertex] != owner) shared_[vertex] = 1;
      }
    }
    std::vector<std::uint8_t> take() { return std::move(shared_); }

   private:
    const Builder& builder_;
    std::vector<std::uint32_t> owner_;
    std::vector<std::uint8_t> shared_;
  };

  /// The positions that several groups have, or a group and a cluster before `first`, which stays as it is.
  std::vector<std::uint8_t> shared_by_groups(const std::vector<std::vector<std::uint32_t>>& members,
                                             std::uint32_t first) const {
    Sharing sharing(*this);
    for (std::uint32_t group = 0; group < members.size(); ++group)
      for (const std::uint32_t member : members[group]) sharing.mark(levels_.clusters[member], group);
    for (const Cluster& cluster : std::span(levels_.clusters).first(first))
      if (cluster.goes_into == kNone) sharing.mark(cluster, std::uint32_t(members.size()));
    return sharing.take();
  }
  std::vector<std::uint8_t> shared_by_clusters(std::uint32_t first, std::uint32_t end) const {
    Sharing sharing(*this);
    for (std::uint32_t i = first; i < end; ++i) sharing.mark(levels_.clusters[i], i);
    return sharing.take();
  }

  /// `first`: triangle of the first error.
  std::vector<Simplified> simplify_all(const std::vector<std::vector<std::uint32_t>>& members,
                                       std::uint32_t first) const {
    std::vector<Simplified> simplified(members.size());
#pragma omp parallel num_threads(members.size() < 4 ? 1 : core::team_of(threads_))
    {
      GroupSimplifier simplifier(mesh_, welded_, *vertices_);
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
  std::vector<std::uint32_t> welded_, equal_;
  std::optional<VerticesAtPlaces> vertices_;
  std::vector<std::uint8_t> shared_;  // by welded vertex
  TriangleErrors errors_;             // of the last level's triangles
  MeshLevels levels_;
};

std::vector<Contact> Builder::contacts(std::uint32_t first, std::uint32_t end) const {
  struct Edge {
    std::uint64_t ends;
    std::uint32_t cluster;
  };
  // Only edges between vertices that several clusters have can lie at a border between two.
  const std::vector<std::uint8_t> shared = shared_by_clusters(first, end);
  std::vector<Edge> borders, edges;
  for (std::uint32_t i = first; i < end; ++i) {
    edges.clear();
    const auto corners = corners_of(levels_.clusters[i]);
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const std::uint64_t a = welded_[corners[k]], b = welded_[corners[k % 3 == 2 ? k - 2 : k + 1]];
      if (a != b && shared[a] && shared[b]) edges.push_back({std::min(a, b) << 32 | std::max(a, b), i - first});
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
