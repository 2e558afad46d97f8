// Cones of normals: every triangle's normal lies within, and cones are not much wider than they must be.
#include "sightline/lod/internal/normal_cone.h"

#include <gtest/gtest.h>

#include "sightline/tests/lod/mesh_samples.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::normal_cone_test {
namespace {

using core::dvec3;
using core::vec3;
using Long = long double;
using LongVec = glm::tvec3<Long>;

/// Sine of the largest angle between the axis and the normals, in more digits than the code has; 2 for more than a
/// right angle.
Long widest(const core::Mesh& mesh, std::span<const std::uint32_t> corners, const vec3& axis) {
  Long sine = 0.0L;
  const LongVec along = glm::normalize(LongVec(axis));
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    const LongVec a(mesh.positions[corners[i]]), u = LongVec(mesh.positions[corners[i + 1]]) - a,
                                                 v = LongVec(mesh.positions[corners[i + 2]]) - a;
    const LongVec n = glm::cross(u, v);
    if (glm::length(n) <= 1.001L * Long(lod::NormalCone::kThin) * glm::length(u) * glm::length(v)) continue;
    sine = glm::dot(n, along) > 0.0L ? std::max(sine, glm::length(glm::cross(n, along)) / glm::length(n)) : 2.0L;
    if (sine > 1.0L) break;
  }
  return sine;
}

TEST(NormalCone, HoldsEveryNormal) {
  int cones = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(3)); ++seed) {
    std::vector<NamedMesh> meshes = hostile_meshes(seed);
    for (NamedMesh& mesh : ordinary_meshes()) meshes.push_back(std::move(mesh));
    for (const NamedMesh& named : meshes) {
      SCOPED_TRACE(named.name);
      const lod::MeshLevels levels = lod::build_levels(named.mesh);
      for (const lod::Cluster& cluster : levels.clusters) {
        if (cluster.cone.spread == lod::NormalCone::kNone) continue;
        ++cones;
        ASSERT_LT(cluster.cone.spread, 1.0f);
        ASSERT_NEAR(glm::length(dvec3(cluster.cone.axis)), 1.0, 1e-6);
        const auto corners = std::span(levels.indices).subspan(cluster.first_index, cluster.index_count);
        ASSERT_LE(widest(named.mesh, corners, cluster.cone.axis), Long(cluster.cone.spread));
      }
    }
  }
  EXPECT_GT(cones, 100);
}

/// Triangles of any size and form, thin ones among them, whose normals lie about a direction.
core::Mesh shingles(MeshRandom& random, double spread, double far) {
  const auto any = [&] { return dvec3(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1)); };
  core::Mesh mesh;
  const dvec3 axis = glm::normalize(any()), origin = far * any();
  for (std::uint32_t i = 0; i < 3 * (1 + random() % lod::kClusterTriangles); i += 3) {
    const dvec3 normal = glm::normalize(axis + spread * any()), u = glm::cross(normal, any()),
                v = glm::cross(normal, u);
    const double thin = std::pow(10.0, between(random, far > 0.0 ? -2 : -9, 0));
    const dvec3 a = origin + any();
    for (const dvec3& p : {a, a + u, a + between(random, 0.1, 1.0) * u + thin * v}) mesh.positions.emplace_back(p);
    for (std::uint32_t k = 0; k < 3; ++k) mesh.indices.push_back(i + k);
  }
  return mesh;
}

TEST(NormalCone, IsNoWiderThanItsAxisNeeds) {
  int all = 0, cones = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(3000)); ++seed) {
    SCOPED_TRACE(seed);
    MeshRandom random(seed);
    const double spread = std::pow(10.0, between(random, -3, -0.5)), far = random() % 2 ? 1e7 : 0.0;
    const core::Mesh mesh = shingles(random, spread, far);
    const lod::NormalCone cone = lod::cone_of(mesh.positions, mesh.indices);
    const Long needed = widest(mesh, mesh.indices, cone.axis);
    ++all;
    if (cone.spread == lod::NormalCone::kNone) continue;  // rounded coordinates turn thin triangles anywhere
    ++cones;
    ASSERT_LE(needed, Long(cone.spread));
    ASSERT_LE(Long(cone.spread), needed + 1e-3L);
  }
  EXPECT_GT(cones, all / 4);
}

TEST(NormalCone, OfFacesOfACubeCorner) {
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.indices = {0, 1, 2, 0, 2, 3, 0, 3, 1};
  const lod::NormalCone cone = lod::cone_of(mesh.positions, mesh.indices);
  EXPECT_NEAR(cone.spread, std::sqrt(2.0 / 3.0), 0.08);
  mesh.indices = {0, 1, 2, 1, 1, 2, 3, 3, 3};
  EXPECT_LT(lod::cone_of(mesh.positions, mesh.indices).spread, 1e-6f) << "flat, beside triangles without area";
  mesh.indices = {0, 1, 2, 0, 2, 1};
  EXPECT_EQ(lod::cone_of(mesh.positions, mesh.indices).spread, lod::NormalCone::kNone) << "both sides";
  mesh.indices = {1, 1, 2};
  EXPECT_EQ(lod::cone_of(mesh.positions, mesh.indices).spread, lod::NormalCone::kNone) << "no normal";
  EXPECT_EQ(lod::cone_of(mesh.positions, {}).spread, lod::NormalCone::kNone);
}

}  // namespace
}  // namespace sightline::tests::normal_cone_test
