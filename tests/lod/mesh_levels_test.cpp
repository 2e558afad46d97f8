// Levels of meshes: the finest shows the mesh, every cut shows it within the proven error, and closed meshes stay
// closed.
#include "sightline/lod/mesh_levels.h"

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "sightline/lod/coarse_mesh.h"
#include "sightline/lod/internal/cluster_groups.h"
#include "sightline/lod/internal/surface_deviation.h"
#include "sightline/lod/stored_levels.h"
#include "sightline/tests/lod/surface_twin.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::mesh_levels_test {
namespace {

using lod::Cluster;
using lod::MeshLevels;

std::vector<NamedMesh> all_meshes(std::uint64_t seed) {
  std::vector<NamedMesh> meshes = ordinary_meshes();
  for (NamedMesh& mesh : hostile_meshes(seed)) meshes.push_back(std::move(mesh));
  return meshes;
}

/// Triangles of a cut: clusters that nothing simplifies further, of groups that are simplified.
std::vector<std::uint32_t> corners_of(const MeshLevels& levels, const std::function<bool(std::uint32_t)>& simplified) {
  std::vector<std::uint32_t> corners;
  for (const Cluster& cluster : levels.clusters)
    if ((cluster.made_by == core::kNone || simplified(cluster.made_by)) &&
        (cluster.goes_into == core::kNone || !simplified(cluster.goes_into)))
      corners.insert(corners.end(), levels.indices.begin() + cluster.first_index,
                     levels.indices.begin() + cluster.first_index + cluster.index_count);
  return corners;
}

/// Groups of a random cut: each only if the groups below it are.
std::vector<bool> random_cut(const MeshLevels& levels, double share, MeshRandom& random) {
  std::vector<bool> may(levels.groups.size(), true), cut(levels.groups.size());
  std::vector<std::vector<std::uint32_t>> above(levels.groups.size());
  for (const Cluster& cluster : levels.clusters)
    if (cluster.made_by != core::kNone && cluster.goes_into != core::kNone)
      above[cluster.made_by].push_back(cluster.goes_into);
  for (std::uint32_t group = 0; group < cut.size(); ++group) {
    cut[group] = may[group] && std::isfinite(levels.groups[group].error) && between(random, 0, 1) < share;
    if (!cut[group])
      for (const std::uint32_t other : above[group]) may[other] = false;
  }
  return cut;
}

/// What a cut draws: its clusters, each with the error and the box of the group that has made it.
struct Drawn {
  SurfaceTwin surface;
  double error;
  core::Aabb box;

  bool stands_for(const core::dvec3& p, double rounding) const {
    for (int i = 0; i < 3; ++i)
      if (p[i] < double(box.min[i]) - rounding || p[i] > double(box.max[i]) + rounding) return false;
    return surface.distance(p) <= error + rounding;
  }
};
std::vector<Drawn> drawn(const core::Mesh& mesh, const MeshLevels& levels, const std::vector<bool>& cut) {
  std::vector<Drawn> drawn;
  for (const Cluster& cluster : levels.clusters) {
    if (cluster.index_count == 0 || (cluster.made_by != core::kNone && !cut[cluster.made_by]) ||
        (cluster.goes_into != core::kNone && cut[cluster.goes_into]))
      continue;
    const auto corners = std::span(levels.indices).subspan(cluster.first_index, cluster.index_count);
    const bool original = cluster.made_by == core::kNone;
    drawn.push_back({SurfaceTwin(mesh.positions, corners), original ? 0.0 : levels.groups[cluster.made_by].error,
                     original ? cluster.box : levels.groups[cluster.made_by].box});
  }
  return drawn;
}

using Triangle = std::array<float, 18>;
std::multiset<Triangle> triangles(const core::Mesh& mesh, std::span<const std::uint32_t> corners) {
  std::multiset<Triangle> all;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    Triangle t{};
    for (std::size_t k = 0; k < 9; ++k) {
      t[k] = mesh.positions[corners[i + k / 3]][int(k % 3)];
      if (!mesh.normals.empty()) t[9 + k] = mesh.normals[corners[i + k / 3]][int(k % 3)];
    }
    all.insert(t);
  }
  return all;
}

TEST(MeshLevels, FirstClustersAreTheMesh) {
  for (const NamedMesh& named : all_meshes(1)) {
    const MeshLevels levels = lod::build_levels(named.mesh);
    const auto count = [&](std::uint32_t first, std::uint32_t end) {
      std::size_t indices = 0;
      for (std::uint32_t i = first; i < end; ++i) indices += levels.clusters[i].index_count;
      return indices;
    };
    ASSERT_EQ(count(0, levels.mesh_clusters), named.mesh.indices.size()) << named.name;
    EXPECT_EQ(count(0, std::uint32_t(levels.clusters.size())), levels.indices.size()) << named.name;
    EXPECT_EQ(triangles(named.mesh, std::span(levels.indices).first(named.mesh.indices.size())),
              triangles(named.mesh, named.mesh.indices))
        << named.name;
  }
}

TEST(MeshLevels, HoldTogether) {
  for (const NamedMesh& named : all_meshes(2)) {
    SCOPED_TRACE(named.name);
    const MeshLevels levels = lod::build_levels(named.mesh);
    std::uint32_t next = 0;
    for (const Cluster& cluster : levels.clusters) {
      EXPECT_EQ(cluster.first_index, next);
      next += cluster.index_count;
      EXPECT_TRUE(cluster.index_count > 0 || !std::isfinite(levels.groups[cluster.made_by].error));
      EXPECT_LE(cluster.index_count, 3 * lod::kClusterTriangles);
      for (std::uint32_t i = 0; i < cluster.index_count; ++i) {
        const core::vec3& p = named.mesh.positions[levels.indices[cluster.first_index + i]];
        EXPECT_TRUE(glm::all(glm::greaterThanEqual(p, cluster.box.min)) &&
                    glm::all(glm::lessThanEqual(p, cluster.box.max)));
      }
      if (cluster.goes_into == core::kNone) continue;
      const lod::ClusterGroup& above = levels.groups[cluster.goes_into];
      core::Aabb box = above.box;
      box.grow(cluster.box);
      EXPECT_TRUE(box.min == above.box.min && box.max == above.box.max);
      if (cluster.made_by == core::kNone) continue;
      const lod::ClusterGroup& below = levels.groups[cluster.made_by];
      EXPECT_LT(cluster.made_by, cluster.goes_into);
      EXPECT_LE(below.error, above.error);
      EXPECT_LE(below.angle, above.angle);
      box.grow(below.box);
      EXPECT_TRUE(box.min == above.box.min && box.max == above.box.max);
    }
  }
}

/// Locally, as views need it: by the error of the group that has made what is drawn there, and in its box.
TEST(MeshLevels, EveryCutLiesWithinTheProvenError) {
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(1)); ++seed)
    for (const NamedMesh& named : all_meshes(seed)) {
      SCOPED_TRACE(named.name + ", seed " + std::to_string(seed));
      MeshRandom random(seed);
      const MeshLevels levels = lod::build_levels(named.mesh);
      const SurfaceTwin mesh(named.mesh.positions, named.mesh.indices);
      const double rounding = 1e-14 * mesh.size();
      for (const double share : {0.5, 0.8, 0.95, 1.0}) {
        const std::vector<Drawn> parts = drawn(named.mesh, levels, random_cut(levels, share, random));
        ASSERT_FALSE(parts.empty());
        for (int i = 0; i < repeated(6000); ++i) {
          const Drawn& part = parts[random() % parts.size()];
          ASSERT_LE(mesh.distance(part.surface.sample(random)), part.error + rounding);
          const core::dvec3 p = mesh.sample(random);
          ASSERT_TRUE(std::ranges::any_of(parts, [&](const Drawn& d) { return d.stands_for(p, rounding); }));
        }
      }
    }
}

/// The least float that is not less.
float up(double x) {
  const auto nearest = float(x);
  return double(nearest) < x ? std::nextafter(nearest, std::numeric_limits<float>::infinity()) : nearest;
}

/// Repeats the proof of each group from what its levels say, with errors of triangles in arrays of the whole mesh.
class ProofTwin {
 public:
  ProofTwin(const core::Mesh& mesh, const MeshLevels& levels)
      : mesh_(mesh),
        levels_(levels),
        welded_(core::weld(mesh.positions)),
        out_(levels.indices.size() / 3),
        back_(out_.size()) {}

  /// Groups come in the order in which they were made.
  void check(std::uint32_t number) {
    const lod::ClusterGroup& group = levels_.groups[number];
    float error = 0.0f, angle = 0.0f;
    std::vector<std::uint32_t> fine, coarse;  // triangles
    for (std::uint32_t i = 0; i < group.member_count; ++i) {
      const Cluster& cluster = levels_.clusters[levels_.members[group.first_member + i]];
      add(cluster, fine);
      if (cluster.made_by == core::kNone) continue;
      error = std::max(error, levels_.groups[cluster.made_by].error);
      angle = std::max(angle, levels_.groups[cluster.made_by].angle);
    }
    for (const Cluster& cluster : levels_.clusters)
      if (cluster.made_by == number) add(cluster, coarse);
    points_.clear(), number_of_.clear();
    const std::vector<std::uint32_t> from = numbered(fine), to = numbered(coarse);
    lod::SurfaceDeviation proof;
    lod::Deviation deviation = proof.bound({points_, from, of(back_, fine)}, {points_, to});
    for (std::size_t i = 0; i < coarse.size(); ++i) back_[coarse[i]] = up(proof.of_to()[i]);
    const std::vector<std::uint32_t> starts(proof.near_to().begin(), proof.near_to().end());
    deviation.grow(proof.bound({points_, to}, {points_, from, of(out_, fine)}, {deviation.distance, starts}));
    for (std::size_t i = 0; i < coarse.size(); ++i) out_[coarse[i]] = up(proof.of_from()[i]);
    ASSERT_EQ(group.error, std::max(error, up(deviation.distance)));
    ASSERT_EQ(group.angle, up(std::min(double(angle) + deviation.angle, std::numbers::pi)));
  }

 private:
  static void add(const Cluster& cluster, std::vector<std::uint32_t>& triangles) {
    for (std::uint32_t i = 0; i < cluster.index_count / 3; ++i) triangles.push_back(cluster.first_index / 3 + i);
  }
  static std::vector<float> of(const std::vector<float>& errors, const std::vector<std::uint32_t>& triangles) {
    std::vector<float> some;
    for (const std::uint32_t triangle : triangles) some.push_back(errors[triangle]);
    return some;
  }
  /// Corners by points that are numbered in the order of their first use.
  std::vector<std::uint32_t> numbered(const std::vector<std::uint32_t>& triangles) {
    std::vector<std::uint32_t> corners;
    for (const std::uint32_t triangle : triangles)
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t place = welded_[levels_.indices[3 * triangle + k]];
        const auto [at, fresh] = number_of_.try_emplace(place, std::uint32_t(points_.size()));
        if (fresh) points_.emplace_back(mesh_.positions[place]);
        corners.push_back(at->second);
      }
    return corners;
  }

  const core::Mesh& mesh_;
  const MeshLevels& levels_;
  std::vector<std::uint32_t> welded_;
  std::vector<float> out_, back_;  // by triangle: from the original, and of the original that it stands for
  std::vector<core::dvec3> points_;
  std::map<std::uint32_t, std::uint32_t> number_of_;  // by welded vertex
};

TEST(MeshLevels, EachGroupHasTheErrorOfItsProof) {
  for (const NamedMesh& named : ordinary_meshes()) {
    SCOPED_TRACE(named.name);
    const MeshLevels levels = lod::build_levels(named.mesh);
    ProofTwin twin(named.mesh, levels);
    for (std::uint32_t group = 0; group < levels.groups.size(); ++group)
      if (std::isfinite(levels.groups[group].error)) twin.check(group);
  }
}

/// Full clusters, groups of few clusters and enough triangles, and no group that gains little.
TEST(MeshLevels, GroupsAreWorthIt) {
  for (const NamedMesh& named : ordinary_meshes()) {
    SCOPED_TRACE(named.name);
    const MeshLevels levels = lod::build_levels(named.mesh);
    std::vector<std::uint32_t> held(levels.groups.size()), made(levels.groups.size());
    for (std::size_t i = 0; i < levels.clusters.size(); ++i) {
      const Cluster& cluster = levels.clusters[i];
      if (cluster.goes_into != core::kNone) held[cluster.goes_into] += cluster.index_count / 3;
      if (cluster.made_by != core::kNone) made[cluster.made_by] += cluster.index_count / 3;
      const bool last = i + 1 == levels.clusters.size() || levels.clusters[i + 1].made_by != cluster.made_by ||
                        cluster.first_index + cluster.index_count == levels.solid_indices;
      EXPECT_TRUE(last || cluster.index_count == 3 * lod::kClusterTriangles) << i;
    }
    for (std::size_t i = 0; i < held.size(); ++i) {
      if (!std::isfinite(levels.groups[i].error)) continue;
      EXPECT_LE(levels.groups[i].member_count, 8u);
      EXPECT_GT(held[i], 32u);
      EXPECT_GT(made[i], 0u);
      EXPECT_LE(double(made[i]), 0.85 * double(held[i]));
    }
  }
}

/// The clusters first … end - 1 that share edges, and how many: edges that both have once.
std::vector<lod::Contact> contacts_twin(const MeshLevels& levels, const std::vector<std::uint32_t>& welded,
                                        std::uint32_t first, std::uint32_t end) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> clusters_at;  // by edge
  for (std::uint32_t i = first; i < end; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
    const std::uint32_t* const t = &levels.indices[levels.clusters[i].first_index];
    for (std::uint32_t k = 0; k < levels.clusters[i].index_count; ++k) {
      const auto edge = std::minmax(welded[t[k]], welded[t[k % 3 == 2 ? k - 2 : k + 1]]);
      if (edge.first != edge.second) ++uses[edge];
    }
    for (const auto& [edge, count] : uses)
      if (count == 1) clusters_at[edge].push_back(i - first);
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edges;  // by pair of clusters
  for (const auto& [edge, clusters] : clusters_at)
    for (std::size_t k = 1; k < clusters.size(); ++k) ++edges[{clusters[k - 1], clusters[k]}];
  std::vector<lod::Contact> contacts;
  for (const auto& [pair, count] : edges) contacts.push_back({pair.first, pair.second, count});
  return contacts;
}

/// Level by level. Groups that gained nothing are missing. Sheets on each other share edges within a cluster.
TEST(MeshLevels, GroupWhatSharesManyEdges) {
  std::vector<NamedMesh> meshes = ordinary_meshes();
  const core::Mesh sheet = terrain(30, 1.0);
  meshes.push_back({"a sheet beside two", joined(joined(sheet, sheet, {}), sheet, {10.0f, 0.0f, 0.0f})});
  for (const NamedMesh& named : meshes) {
    SCOPED_TRACE(named.name);
    const MeshLevels levels = lod::build_levels(named.mesh);
    const std::vector<std::uint32_t> welded = core::weld(named.mesh.positions);
    std::uint32_t first = 0, end = levels.mesh_clusters, group = 0;
    while (first < end) {
      const auto most = end - first <= 8
                            ? std::vector<std::uint32_t>(end - first, 0)
                            : lod::group_clusters(end - first, contacts_twin(levels, welded, first, end), 8);
      std::map<std::uint32_t, std::vector<std::uint32_t>> members;
      for (std::uint32_t i = first; i < end; ++i) members[most[i - first]].push_back(i);
      std::uint32_t next = end;
      for (const auto& [number, clusters] : members) {
        if (group == levels.groups.size() || !std::isfinite(levels.groups[group].error)) break;
        const auto held = std::span(levels.members).subspan(levels.groups[group].first_member);
        if (held[0] != clusters[0]) continue;
        ASSERT_EQ(levels.groups[group].member_count, clusters.size());
        ASSERT_TRUE(std::ranges::equal(clusters, held.first(clusters.size())));
        while (next < levels.clusters.size() && levels.clusters[next].made_by == group) ++next;
        ++group;
      }
      first = end, end = next;
    }
    for (; group < levels.groups.size(); ++group) ASSERT_FALSE(std::isfinite(levels.groups[group].error));
  }
}

/// Each corner of a coarser triangle has, of the normals at its place, the one that is nearest to the triangle's own.
TEST(MeshLevels, TakeTheNearestNormals) {
  const core::Mesh bare = terrain(40, 1.0);
  const core::Mesh patches = with_normals(bare, [](std::size_t triangle) { return triangle / 50; });
  const core::Mesh flat = with_normals(bare, [](std::size_t triangle) { return triangle; });
  for (const float outward : {1.0f, -1.0f})
    for (core::Mesh mesh : {patches, flat, smooth_cylinder(200)}) {
      for (core::vec3& normal : mesh.normals) normal *= outward;
      for (std::size_t i = 0; i < 3; ++i) mesh.normals[mesh.indices[i]] *= -1.0f;  // one triangle does not decide
      const MeshLevels levels = lod::build_levels(mesh);
      const std::vector<std::uint32_t> welded = core::weld(mesh.positions);
      std::vector<std::vector<std::uint32_t>> at(welded.size());
      for (std::uint32_t i = 0; i < welded.size(); ++i) at[welded[i]].push_back(i);
      for (std::size_t i = mesh.indices.size(); i < levels.indices.size(); i += 3) {
        const std::uint32_t* const t = &levels.indices[i];
        const core::vec3& a = mesh.positions[t[0]];
        const core::vec3 normal = outward * glm::cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
        for (int k = 0; k < 3; ++k)
          for (const std::uint32_t other : at[welded[t[k]]])
            ASSERT_LE(glm::dot(mesh.normals[other], normal), glm::dot(mesh.normals[t[k]], normal)) << i;
      }
    }
}

TEST(MeshLevels, ClosedMeshesStayClosedAtEveryCut) {
  for (const NamedMesh& named : ordinary_meshes()) {
    if (named.name.starts_with("open")) continue;
    SCOPED_TRACE(named.name);
    ASSERT_NE(core::enclosure(named.mesh), core::Enclosure::kNothing);
    const MeshLevels levels = lod::build_levels(named.mesh);
    MeshRandom random(7);
    for (int i = 0; i < repeated(20); ++i) {
      const std::vector<bool> cut = random_cut(levels, between(random, 0.3, 1.0), random);
      core::Mesh shown;
      shown.positions = named.mesh.positions;
      shown.indices = corners_of(levels, [&](std::uint32_t group) { return cut[group]; });
      EXPECT_EQ(core::enclosure(shown), core::enclosure(named.mesh));
    }
  }
}

/// Draws random cuts of a closed mesh.
void expect_closed_cuts(const core::Mesh& mesh, MeshRandom& random) {
  ASSERT_NE(core::enclosure(mesh), core::Enclosure::kNothing);
  const MeshLevels levels = lod::build_levels(mesh);
  for (const double share : {0.5, 0.8, 1.0}) {
    const std::vector<bool> cut = random_cut(levels, share, random);
    core::Mesh shown;
    shown.positions = mesh.positions;
    shown.indices = corners_of(levels, [&](std::uint32_t group) { return cut[group]; });
    ASSERT_NE(core::enclosure(shown), core::Enclosure::kNothing) << share;
  }
}

/// Where shells touch, a vertex inside of a group's surface belongs to several groups.
TEST(MeshLevels, TouchingShellsStayClosedAtEveryCut) {
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(60)); ++seed) {
    SCOPED_TRACE(seed);
    MeshRandom random(seed);
    expect_closed_cuts(touching_tori(16 + std::uint32_t(seed % 5), 7, random), random);
  }
}

/// One cluster more than a group takes, of few triangles: it stays as it is beside all further levels of the group.
TEST(MeshLevels, StayClosedBesideWhatIsNotSimplified) {
  int left = 0;
  for (std::uint32_t segments = 258; segments < 266; ++segments) {
    SCOPED_TRACE(segments);
    MeshRandom random(segments);
    const core::Mesh mesh = smooth_cylinder(segments);
    ASSERT_EQ((mesh.indices.size() / 3 + 127) / 128, 9u);
    const MeshLevels levels = lod::build_levels(mesh);
    left += levels.clusters[8].goes_into == core::kNone;
    expect_closed_cuts(mesh, random);
  }
  EXPECT_TRUE(left > 0 || !lod::builds_levels());
}

TEST(MeshLevels, GetCoarse) {
#if !SIGHTLINE_HAS_MESHOPT
  GTEST_SKIP() << "this build has no meshoptimizer, and clusters alone";
#endif
  for (const NamedMesh& named : ordinary_meshes()) {
    const MeshLevels levels = lod::build_levels(named.mesh);
    const auto coarsest =
        corners_of(levels, [&](std::uint32_t group) { return std::isfinite(levels.groups[group].error); });
    const bool cannot = named.name.find("shells") != std::string::npos;
    EXPECT_LE(coarsest.size(), cannot ? named.mesh.indices.size() / 4 : 3 * 64u) << named.name;
  }
}

/// How far normals of corners agree with those of their triangles, on average: a cosine.
double agreement(const core::Mesh& mesh) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const auto corner = [&](std::size_t k) { return mesh.positions[mesh.indices[i / 3 * 3 + k]]; };
    const core::vec3 normal = glm::normalize(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
    sum += double(glm::dot(normal, mesh.normals[mesh.indices[i]]));
  }
  return sum / double(mesh.indices.size());
}

/// A terrain with one normal a position; with patches, between which positions have several; and with flat faces. Also
/// with normals turned inside out, as some programs write them.
TEST(MeshLevels, GetAsCoarseWhateverTheNormals) {
#if !SIGHTLINE_HAS_MESHOPT
  GTEST_SKIP() << "this build has no meshoptimizer, and clusters alone";
#endif
  constexpr std::uint32_t kCells = 100, kPatch = 10;
  const core::Mesh bare = terrain(kCells, 1.0);
  const core::Mesh smooth = with_normals(bare, [](std::size_t) { return 0; });
  const core::Mesh patches = with_normals(bare, [](std::size_t triangle) {
    const std::size_t cell = triangle / 2;
    return cell % kCells / kPatch * kCells + cell / kCells / kPatch;
  });
  const core::Mesh flat = with_normals(bare, [](std::size_t triangle) { return triangle; });
  const MeshLevels of_smooth = lod::build_levels(smooth);
  for (const float outward : {1.0f, -1.0f})
    for (core::Mesh mesh : {patches, flat}) {
      for (core::vec3& normal : mesh.normals) normal *= outward;
      const MeshLevels levels = lod::build_levels(mesh);
      for (const float error : {0.01f, 0.03f, 0.1f, 1e9f}) {
        SCOPED_TRACE(testing::Message() << mesh.positions.size() << ' ' << outward << ' ' << error);
        const core::Mesh wanted = lod::coarse_within(smooth, of_smooth, error).mesh;
        const core::Mesh coarse = lod::coarse_within(mesh, levels, error).mesh;
        EXPECT_LE(double(coarse.indices.size()), 1.15 * double(wanted.indices.size()));
        EXPECT_GE(outward * agreement(coarse), agreement(wanted) - 0.01);
      }
    }
}

/// At every level, each side of a crease has its own normals.
TEST(MeshLevels, KeepCreases) {
  const core::Mesh cylinder = smooth_cylinder(200);
  const MeshLevels levels = lod::build_levels(cylinder);
  std::size_t coarser = 0;
  for (std::size_t i = 0; i < levels.indices.size(); i += 3) {
    const auto* const t = &levels.indices[i];
    const auto& p = cylinder.positions;
    const core::vec3 normal = glm::cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
    const bool cap = p[t[0]].z == p[t[1]].z && p[t[0]].z == p[t[2]].z;
    coarser += i >= cylinder.indices.size();
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(cylinder.normals[t[k]].z == 0.0f, !cap);
      EXPECT_GT(glm::dot(cylinder.normals[t[k]], normal), 0.0f);
    }
  }
#if SIGHTLINE_HAS_MESHOPT
  EXPECT_GT(coarser, 100u);
#endif
}

TEST(MeshLevels, DoNotDependOnThreads) {
  const core::Mesh mesh = terrain(120, 1.3);
  const MeshLevels one = lod::build_levels(mesh, 1), several = lod::build_levels(mesh, 4);
  EXPECT_EQ(one.indices, several.indices);
  ASSERT_EQ(one.groups.size(), several.groups.size());
  for (std::size_t i = 0; i < one.groups.size(); ++i) EXPECT_EQ(one.groups[i].error, several.groups[i].error);
}

TEST(MeshLevels, NeedEnoughTrianglesAndFiniteCoordinates) {
  core::Mesh mesh = terrain(3, 1.0);
  EXPECT_FALSE(lod::needs_levels(mesh));
  EXPECT_TRUE(lod::build_levels(mesh).empty());
  mesh = terrain(8, 1.0);
  EXPECT_FALSE(lod::build_levels(mesh).empty());
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    mesh.positions[5].y = bad;
    EXPECT_TRUE(lod::build_levels(mesh).empty());
  }
  EXPECT_TRUE(lod::build_levels(core::Mesh()).empty());
}

}  // namespace
}  // namespace sightline::tests::mesh_levels_test
