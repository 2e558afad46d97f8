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

/// With errors of the triangles, every point of each has one with whose triangle the sums of both are kept.
TEST(SurfaceDeviation, KnowsWhatEachTriangleStandsFor) {
  int largest_by_one = 0, pairs = 0;
  for (const NamedMesh& named : ordinary_meshes()) {
    SCOPED_TRACE(named.name);
    MeshRandom random(5);
    const Pair pair = shaken(named, random);
    const std::vector<dvec3> points(pair.positions.begin(), pair.positions.end());
    std::vector<float> errors[2] = {std::vector<float>(pair.a.size() / 3), std::vector<float>(pair.b.size() / 3)};
    for (std::vector<float>& some : errors)
      for (float& error : some) error = float(0.1 * std::pow(10.0, between(random, -4, 0)));
    lod::SurfaceDeviation deviation;
    const double bound = deviation.bound({points, pair.a, errors[0]}, {points, pair.b, errors[1]}).distance;
    EXPECT_EQ(bound, *std::ranges::max_element(deviation.of_from()));
    EXPECT_EQ(bound, *std::ranges::max_element(deviation.of_to()));
    std::vector<SurfaceTwin> faces;
    for (std::size_t i = 0; i < pair.b.size(); i += 3)
      faces.emplace_back(pair.positions, std::span(pair.b).subspan(i, 3));
    for (int i = 0; i < repeated(2000); ++i) {
      const std::size_t triangle = random() % errors[0].size();
      const dvec3 p = SurfaceTwin(pair.positions, std::span(pair.a).subspan(3 * triangle, 3)).sample(random);
      bool found = false;
      for (std::size_t face = 0; face < faces.size() && !found; ++face) {
        const double sum = faces[face].distance(p) + double(errors[0][triangle]) + double(errors[1][face]);
        found = sum <= deviation.of_from()[triangle] && sum <= deviation.of_to()[face];
      }
      ASSERT_TRUE(found);
    }
    const auto median = [](std::span<const double> all) {
      std::vector<double> sorted(all.begin(), all.end());
      std::ranges::nth_element(sorted, sorted.begin() + std::ptrdiff_t(sorted.size() / 2));
      return sorted[sorted.size() / 2];
    };
    ++pairs, largest_by_one += median(deviation.of_from()) < 0.7 * bound;
  }
  EXPECT_GT(largest_by_one, pairs / 2) << "most triangles are known to lie nearer than the farthest";
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
