// Coarse meshes are what a cut draws where every error is allowed.
#include "sightline/lod/coarse_mesh.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "sightline/lod/internal/cut.h"
#include "sightline/lod/stored_levels.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests::coarse_mesh_test {
namespace {

/// Corners as points, in their order.
std::vector<core::vec3> corners(const core::Mesh& mesh, std::span<const std::uint32_t> indices) {
  std::vector<core::vec3> all;
  for (const std::uint32_t index : indices) {
    all.push_back(mesh.positions[index]);
    if (!mesh.normals.empty()) all.push_back(mesh.normals[index]);
  }
  return all;
}

std::vector<NamedMesh> meshes() {
  std::vector<NamedMesh> all = ordinary_meshes();
  core::Mesh islands;  // many roots
  for (int i = 0; i < 400; ++i) islands = joined(std::move(islands), bumpy_torus(4, 0.0), {9.0f * float(i), 0, 0});
  all.push_back({"many islands", std::move(islands)});
  for (NamedMesh& mesh : hostile_meshes(21)) all.push_back(std::move(mesh));
  return all;
}

TEST(CoarseMesh, IsTheCoarsestCut) {
  for (const NamedMesh& named : meshes()) {
    SCOPED_TRACE(named.name);
    const lod::MeshLevels levels = lod::build_levels(named.mesh);
    if (levels.empty()) continue;
    const lod::CoarseMesh coarse = lod::coarsest(named.mesh, levels);
    ASSERT_TRUE(core::validate(coarse.mesh));
    // From so far that each error is allowed: an orthographic view that is wide enough.
    core::Aabb box;
    for (const core::vec3& p : named.mesh.positions) box.grow({p, p});
    const core::dvec3 centre = 0.5 * (core::dvec3(box.min) + core::dvec3(box.max));
    const double size = glm::length(core::dvec3(box.max) - core::dvec3(box.min)) + 1e-30;
    const auto view =
        core::View::orthographic({centre + core::dvec3(0, 0, 1e3 * size), centre}, 1e4 * size, 1.0, 0.0, 2e3 * size);
    if (!view) continue;  // too large for a view
    const lod::MeshError error({*view, 100, 100, 1e6}, core::Affine());
    std::vector<lod::IndexRange> ranges;
    lod::CutChooser().choose(levels, error, ranges);
    std::vector<std::uint32_t> drawn;
    for (const lod::IndexRange& range : ranges)
      drawn.insert(drawn.end(), levels.indices.begin() + range.first,
                   levels.indices.begin() + range.first + range.count);
    EXPECT_EQ(corners(coarse.mesh, coarse.mesh.indices), corners(named.mesh, drawn));
    for (const core::MeshDeviation& deviation : coarse.deviations) {
      EXPECT_TRUE(std::isfinite(deviation.error));
      EXPECT_LE(deviation.error, error.allowed(deviation.box));
    }
  }
}

/// What a cut of all groups within an error draws, and how far that may lie from the mesh.
void expect_within(const core::Mesh& mesh, const lod::MeshLevels& levels, float error) {
  const auto simplifies = [&](std::uint32_t group) {
    return group != core::kNone && levels.groups[group].error <= error && std::isfinite(levels.groups[group].error);
  };
  std::vector<std::uint32_t> drawn;
  std::set<std::uint32_t> drawn_of;  // groups, which make clusters in their order
  for (const lod::Cluster& cluster : levels.clusters) {
    if (simplifies(cluster.goes_into)) continue;
    if (cluster.made_by != core::kNone && !simplifies(cluster.made_by)) continue;
    if (cluster.made_by != core::kNone) drawn_of.insert(cluster.made_by);
    drawn.insert(drawn.end(), levels.indices.begin() + cluster.first_index,
                 levels.indices.begin() + cluster.first_index + cluster.index_count);
  }
  const lod::CoarseMesh coarse = lod::coarse_within(mesh, levels, error);
  ASSERT_EQ(corners(coarse.mesh, coarse.mesh.indices), corners(mesh, drawn));
  ASSERT_EQ(coarse.deviations.size(), drawn_of.size());
  std::size_t i = 0;
  for (const std::uint32_t group : drawn_of) {
    EXPECT_EQ(coarse.deviations[i].box.min, levels.groups[group].box.min);
    EXPECT_EQ(coarse.deviations[i].box.max, levels.groups[group].box.max);
    EXPECT_EQ(coarse.deviations[i++].error, levels.groups[group].error);
  }
}

TEST(CoarseMesh, KeepsToEachError) {
  core::Mesh islands;  // a group of infinite error
  for (int i = 0; i < 100; ++i) islands = joined(std::move(islands), bumpy_torus(4, 0.0), {9.0f * float(i), 0, 0});
  for (const core::Mesh& mesh : {terrain(40, 1.5), smooth_cylinder(60), islands}) {
    const lod::MeshLevels levels = lod::build_levels(mesh);
    for (std::size_t i = 0; i < levels.groups.size(); i += 1 + i / 4) {
      SCOPED_TRACE(i);
      const float error = levels.groups[i].error;
      expect_within(mesh, levels, error);
      expect_within(mesh, levels, std::nextafter(error, 0.0f));
    }
    EXPECT_EQ(corners(lod::coarse_within(mesh, levels, 0.0f).mesh, lod::coarse_within(mesh, levels, 0.0f).mesh.indices),
              corners(mesh, std::span(levels.indices).first(mesh.indices.size())));
  }
}

TEST(CoarseMesh, OfAClosedSurfaceIsSmallAndSaysHowFarItLies) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no coarser levels in this build";
  const core::Mesh torus = bumpy_torus(60, 0.1);
  const lod::MeshLevels levels = lod::build_levels(torus);
  if (levels.groups.empty()) GTEST_SKIP() << "no coarser levels in this build";
  const lod::CoarseMesh coarse = lod::coarsest(torus, levels);
  EXPECT_LT(coarse.mesh.indices.size(), torus.indices.size() / 20);
  EXPECT_LT(coarse.mesh.positions.size(), torus.positions.size() / 10);
  ASSERT_FALSE(coarse.deviations.empty());
  EXPECT_GT(coarse.deviations[0].error, 0.0f);
}

}  // namespace
}  // namespace sightline::tests::coarse_mesh_test
