// Proven bounds of the distance between surfaces against sampled distances, which must never exceed them.
#include "sightline/lod/internal/surface_deviation.h"

#include <limits>

#include <gtest/gtest.h>

#include "sightline/tests/lod/surface_twin.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::surface_deviation_test {
namespace {

using core::dvec3;

/// Two surfaces over the same points.
struct Pair {
  std::string name;
  std::vector<core::vec3> positions;
  std::vector<std::uint32_t> a, b;
};

std::vector<std::uint32_t> welded_corners(const core::Mesh& mesh) {
  const std::vector<std::uint32_t> welded = core::weld(mesh.positions);
  std::vector<std::uint32_t> corners = mesh.indices;
  for (std::uint32_t& corner : corners) corner = welded[corner];
  return corners;
}

/// The mesh beside a part of its triangles.
Pair thinned(NamedMesh named, MeshRandom& random) {
  Pair pair{named.name + ", thinned", named.mesh.positions, welded_corners(named.mesh), {}};
  for (std::size_t i = 0; i < pair.a.size(); i += 3)
    if (pair.b.empty() || random() % 3 != 0)
      pair.b.insert(pair.b.end(), pair.a.begin() + std::ptrdiff_t(i), pair.a.begin() + std::ptrdiff_t(i) + 3);
  return pair;
}

/// The mesh beside itself with some vertices moved onto others, as collapses do.
Pair collapsed(NamedMesh named, MeshRandom& random) {
  Pair pair{named.name + ", collapsed", named.mesh.positions, welded_corners(named.mesh), welded_corners(named.mesh)};
  std::vector<std::uint32_t> target(pair.positions.size());
  for (std::uint32_t i = 0; i < target.size(); ++i) target[i] = i;
  for (std::size_t i = 0; i < pair.a.size(); i += 3)
    if (random() % 5 == 0) target[pair.a[i]] = target[pair.a[i + 1]];
  for (std::uint32_t& corner : pair.b) corner = target[corner];
  return pair;
}

/// The mesh beside itself with every vertex moved a little.
Pair shaken(NamedMesh named, MeshRandom& random) {
  Pair pair{named.name + ", shaken", named.mesh.positions, welded_corners(named.mesh), welded_corners(named.mesh)};
  const auto count = std::uint32_t(pair.positions.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    const float size = 0.02f * float(glm::length(dvec3(pair.positions[i])));
    pair.positions.push_back(pair.positions[i] +
                             size * core::vec3(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1)));
  }
  for (std::uint32_t& corner : pair.b) corner += count;
  return pair;
}

lod::Deviation bound(const Pair& pair, bool back) {
  const std::vector<dvec3> points(pair.positions.begin(), pair.positions.end());
  const lod::Triangles a{points, pair.a}, b{points, pair.b};
  return back ? lod::SurfaceDeviation().bound(b, a) : lod::SurfaceDeviation().bound(a, b);
}

/// Returns how much the bound exceeds the largest sampled distance, as a factor.
double check(const Pair& pair, MeshRandom& random) {
  const SurfaceTwin a(pair.positions, pair.a), b(pair.positions, pair.b);
  double loosest = 0.0;
  for (const bool back : {false, true}) {
    const double most = bound(pair, back).distance;
    EXPECT_TRUE(most >= 0.0 && std::isfinite(most)) << pair.name;
    const int samples = repeated(2000);
    const double measured = back ? b.farthest_from(a, samples, random) : a.farthest_from(b, samples, random);
    EXPECT_LE(measured, most) << pair.name << (back ? ", back" : "");
    if (measured > 1e-9 * a.size()) loosest = std::max(loosest, most / measured);
  }
  return loosest;
}

TEST(SurfaceDeviation, IsABoundForSurfacesOfAnyKind) {
  std::vector<double> loose;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(2)); ++seed) {
    SCOPED_TRACE(seed);
    MeshRandom random(seed);
    std::vector<NamedMesh> meshes = hostile_meshes(seed);
    for (NamedMesh& mesh : ordinary_meshes()) meshes.push_back(std::move(mesh));
    for (const NamedMesh& mesh : meshes)
      for (const auto& change : {thinned, collapsed, shaken}) loose.push_back(check(change(mesh, random), random));
  }
  std::ranges::sort(loose);
  EXPECT_LT(loose[loose.size() / 2], 2.5) << "in the median, beside the largest of a few thousand samples";
}

TEST(SurfaceDeviation, OfASurfaceFromItselfIsRounding) {
  for (const NamedMesh& named : ordinary_meshes()) {
    const lod::Deviation deviation =
        bound({named.name, named.mesh.positions, welded_corners(named.mesh), welded_corners(named.mesh)}, false);
    EXPECT_LT(deviation.distance, 1e-9) << named.name;
    EXPECT_LT(deviation.angle, 1e-6) << named.name;
  }
}

TEST(SurfaceDeviation, KnowsASquareAboveASquare) {
  const std::vector<dvec3> points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                     {0, 0, 2}, {1, 0, 2}, {1, 1, 2}, {0, 1, 2}};
  const std::vector<std::uint32_t> low = {0, 1, 2, 0, 2, 3}, high = {4, 5, 7, 5, 6, 7}, half = {4, 5, 7};
  lod::SurfaceDeviation deviation;
  EXPECT_NEAR(deviation.bound({points, low}, {points, high}).distance, 2.12, 0.13);
  EXPECT_EQ(deviation.bound({points, low}, {points, high}).angle, 0.0);
  EXPECT_NEAR(deviation.bound({points, half}, {points, low}).distance, 2.12, 0.13);
  EXPECT_NEAR(deviation.bound({points, low}, {points, half}).distance, 1.06 * std::sqrt(4.5), 0.13);
  EXPECT_EQ(deviation.bound({points, {}}, {points, low}).distance, 0.0);
}

TEST(SurfaceDeviation, KnowsAFold) {
  const std::vector<dvec3> points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<std::uint32_t> wall = {0, 1, 4}, floor = {0, 1, 2, 0, 2, 3};
  const lod::Deviation deviation = lod::SurfaceDeviation().bound({points, wall}, {points, floor});
  EXPECT_NEAR(deviation.distance, 1.06, 0.07);
  EXPECT_NEAR(deviation.angle, 0.5 * std::numbers::pi, 1e-9);
}

}  // namespace
}  // namespace sightline::tests::surface_deviation_test
