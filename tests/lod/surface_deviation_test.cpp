// Proven bounds of the distance between surfaces against sampled distances, which must never exceed them.
#include "sightline/lod/internal/surface_deviation.h"

#include <array>
#include <limits>

#include <gtest/gtest.h>

#include "sightline/tests/lod/surface_twin.h"
#include "sightline/tests/support/effort.h"
#include "sightline/tests/support/instruction_sets.h"

namespace sightline::tests::surface_deviation_test {
namespace {

using core::dvec3;

/// Every compiler gives the same points, since elements of a list are evaluated in their order.
core::vec3 any_point(MeshRandom& random, double size) {
  return {between(random, -size, size), between(random, -size, size), between(random, -size, size)};
}

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
    pair.positions.push_back(pair.positions[i] + size * any_point(random, 1.0));
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

/// Small surfaces of many kinds: smooth and rough ones, any triangles, and large ones across small ones.
std::vector<Pair> small_pairs(std::uint64_t seed) {
  MeshRandom random(seed);
  core::Mesh any;
  for (int i = 0; i < 12; ++i) any.positions.push_back(any_point(random, 1.0));
  for (int i = 0; i < 60; ++i) any.indices.push_back(std::uint32_t(random() % 12));
  std::vector<Pair> pairs;
  for (const NamedMesh& named : {NamedMesh{"terrain", terrain(6, between(random, 0.5, 2.0))},
                                 NamedMesh{"torus", bumpy_torus(5, between(random, 0.0, 0.5))}, NamedMesh{"any", any}})
    for (const auto& change : {thinned, collapsed, shaken}) pairs.push_back(change(named, random));
  for (const core::Mesh& mesh : {terrain(6, between(random, 0.5, 2.0)), terrain(24, 3.0), terrain(24, 3.0)}) {
    Pair sheet{"a large sheet across terrain", mesh.positions, {}, mesh.indices};
    const auto first = std::uint32_t(sheet.positions.size());
    for (int i = 0; i < 4; ++i)
      sheet.positions.push_back(core::vec3(5, 5, 0) + core::vec3(8, 8, 3) * any_point(random, 1.0));
    sheet.a = {first, first + 1, first + 2, first + 1, first + 3, first + 2};
    pairs.push_back(sheet);
  }
  return pairs;
}

TEST(SurfaceDeviation, SeldomExceedsTheDistanceByAnEighth) {
  int loose = 0, tight = 0;
  double sum = 0.0, count = 0.0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(200)); ++seed)
    for (const Pair& pair : small_pairs(seed)) {
      SCOPED_TRACE(testing::Message() << pair.name << ", seed " << seed);
      const SurfaceTwin a(pair.positions, pair.a), b(pair.positions, pair.b);
      const double exact = a.distance_from(b, 1e-3), most = bound(pair, false).distance;
      ASSERT_GE(most, exact / (1.0 + 1e-3));
      if (exact <= 1e-9) continue;
      // Triangles that cross each other in any number leave more to the last resort, whole polygons.
      if (pair.name.starts_with("any"))
        ++(most < 1.125 * exact ? tight : loose);
      else
        ASSERT_LT(most, 1.125 * exact);
      sum += most / exact, count += 1.0;
    }
  EXPECT_LT(loose, tight / 4);
  EXPECT_LT(sum / count, 1.3) << "in the mean";
}

/// Two surfaces with errors of their triangles.
struct WithErrors {
  Pair pair;
  std::vector<dvec3> points;
  std::vector<float> of_a, of_b;

  WithErrors(Pair surfaces, double most, MeshRandom& random)
      : pair(std::move(surfaces)), points(pair.positions.begin(), pair.positions.end()) {
    for (std::size_t i = 0; i < pair.a.size(); i += 3)
      of_a.push_back(float(most * std::pow(10.0, between(random, -4, 0))));
    for (std::size_t i = 0; i < pair.b.size(); i += 3)
      of_b.push_back(float(most * std::pow(10.0, between(random, -4, 0))));
  }
  double bound(lod::SurfaceDeviation& deviation) const {
    return deviation.bound({points, pair.a, of_a}, {points, pair.b, of_b}).distance;
  }
};

/// Every point of each triangle has one with whose triangle the sums of both are kept.
void check_each_triangle(const WithErrors& with, const lod::SurfaceDeviation& deviation, int samples,
                         MeshRandom& random) {
  const Pair& pair = with.pair;
  const SurfaceTwin to(pair.positions, pair.b);
  for (const double distance : deviation.of_to()) ASSERT_GE(distance, 0.0);
  for (int i = 0; i < samples; ++i) {
    const std::size_t triangle = random() % with.of_a.size();
    const dvec3 p = SurfaceTwin(pair.positions, std::span(pair.a).subspan(3 * triangle, 3)).sample(random);
    bool found = false;
    for (std::size_t face = 0; face < with.of_b.size() && !found; ++face) {
      const double sum = to.distance_to(face, p) + double(with.of_a[triangle]) + double(with.of_b[face]);
      found = sum <= deviation.of_from()[triangle] && sum <= deviation.of_to()[face];
    }
    ASSERT_TRUE(found) << "triangle " << triangle;
  }
}

TEST(SurfaceDeviation, KnowsWhatEachTriangleStandsFor) {
  int largest_by_one = 0, pairs = 0;
  for (const NamedMesh& named : ordinary_meshes()) {
    SCOPED_TRACE(named.name);
    MeshRandom random(5);
    const WithErrors with(shaken(named, random), 0.1, random);
    lod::SurfaceDeviation deviation;
    const double bound = with.bound(deviation);
    EXPECT_EQ(bound, *std::ranges::max_element(deviation.of_from()));
    EXPECT_EQ(bound, *std::ranges::max_element(deviation.of_to()));
    check_each_triangle(with, deviation, repeated(2000), random);
    const auto median = [](std::span<const double> all) {
      std::vector<double> sorted(all.begin(), all.end());
      std::ranges::nth_element(sorted, sorted.begin() + std::ptrdiff_t(sorted.size() / 2));
      return sorted[sorted.size() / 2];
    };
    ++pairs, largest_by_one += median(deviation.of_from()) < 0.7 * bound;
  }
  EXPECT_GT(largest_by_one, pairs / 2) << "most triangles are known to lie nearer than the farthest";
}

TEST(SurfaceDeviation, KnowsWhatEachTriangleOfSmallSurfacesStandsFor) {
  lod::SurfaceDeviation deviation;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(400)); ++seed)
    for (const Pair& pair : small_pairs(seed)) {
      SCOPED_TRACE(testing::Message() << pair.name << ", seed " << seed);
      MeshRandom random(seed);
      const WithErrors with(pair, seed % 2 == 0 ? 0.0 : between(random, 0.0, 0.5), random);
      with.bound(deviation);
      check_each_triangle(with, deviation, 100, random);
    }
}

/// How tight bounds are, and in how many steps. Logarithms, so that near and far surfaces count alike.
struct Cost {
  double bounds = 0.0, of_from = 0.0, of_to = 0.0;
  std::int64_t steps = 0;

  void add(const WithErrors& with) {
    lod::SurfaceDeviation deviation;
    const bool none = with.of_a[0] == 0.0f;
    const lod::Triangles a{with.points, with.pair.a, none ? std::span<const float>() : with.of_a},
        b{with.points, with.pair.b, none ? std::span<const float>() : with.of_b};
    const auto log_of = [](double distance) { return std::log(std::max(distance, 1e-6)); };
    for (const bool back : {false, true}) {
      bounds += log_of((back ? deviation.bound(b, a) : deviation.bound(a, b)).distance);
      steps += deviation.steps();
      for (const double distance : deviation.of_from()) of_from += log_of(distance);
      for (const double distance : deviation.of_to()) of_to += log_of(distance);
    }
  }
};

/// A neighbour that is not found, a plane on the wrong side or a face that is not the nearest costs tightness or steps,
/// and nothing else shows that, since any division proves a bound. And a piece that is lost makes bounds tighter. So
/// both are held to what they were, in sums in which another rounding of sines changes little. What makes proofs better
/// has new sums.
TEST(SurfaceDeviation, IsAsTightInAsFewStepsAsItWas) {
  Cost cost;
  MeshRandom random(1);
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    for (const Pair& pair : small_pairs(seed)) cost.add({pair, seed % 2 == 0 ? 0.0 : 0.1, random});
  for (const core::Mesh& mesh : {terrain(24, 1.0), bumpy_torus(16, 0.1), terrain(16, 1.9)})
    for (const auto& change : {thinned, collapsed, shaken})
      for (const double error : {0.0, 0.02}) cost.add({change({"", mesh}, random), error, random});
  EXPECT_NEAR(cost.bounds, -532.978, 0.01);
  EXPECT_NEAR(cost.of_from, -88218.6, 2.0);
  EXPECT_NEAR(cost.of_to, -850331.2, 2.0);
  EXPECT_NEAR(double(cost.steps), 272210.0, 30.0);
}

TEST(SurfaceDeviation, IsTheSameInEveryFormOfTheKernels) {
  std::vector<double> known;
  for_each_instruction_set([&] {
    MeshRandom random(7);
    std::vector<double> found;
    lod::SurfaceDeviation deviation;
    for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(20)); ++seed)
      for (const Pair& pair : small_pairs(seed)) {
        found.push_back(WithErrors(pair, seed % 2 == 0 ? 0.0 : 0.1, random).bound(deviation));
        for (const auto part : {deviation.of_from(), deviation.of_to()})
          found.insert(found.end(), part.begin(), part.end());
        found.push_back(double(deviation.steps()));
      }
    if (known.empty()) known = found;
    ASSERT_EQ(found, known);
  });
}

/// Where to begin, even if far off, decides only how many steps it takes.
TEST(SurfaceDeviation, IsABoundFromAnyStart) {
  MeshRandom random(3);
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(20)); ++seed)
    for (const Pair& pair : small_pairs(seed)) {
      SCOPED_TRACE(testing::Message() << pair.name << ", seed " << seed);
      const WithErrors with(pair, seed % 2 == 0 ? 0.0 : 0.1, random);
      lod::SurfaceDeviation deviation;
      deviation.bound({with.points, pair.b}, {with.points, pair.a});
      ASSERT_EQ(deviation.near_to().size(), with.of_a.size());
      std::vector<std::uint32_t> starts(deviation.near_to().begin(), deviation.near_to().end());
      if (seed % 3 == 0)
        for (std::uint32_t& start : starts) start = std::uint32_t(random() % with.of_b.size());
      for (const std::uint32_t start : starts) ASSERT_TRUE(start == core::kNone || start < with.of_b.size());
      deviation.bound({with.points, pair.a, with.of_a}, {with.points, pair.b, with.of_b}, {.starts = starts});
      check_each_triangle(with, deviation, 100, random);
    }
}

/// A surface that must lie within the bound anyway needs fewer steps, and is as little beyond it as ever.
TEST(SurfaceDeviation, NeedsNoTighterBoundThanIsEnough) {
  std::int64_t steps = 0, fewer = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(20)); ++seed)
    for (const Pair& pair : small_pairs(seed)) {
      SCOPED_TRACE(testing::Message() << pair.name << ", seed " << seed);
      const std::vector<dvec3> points(pair.positions.begin(), pair.positions.end());
      lod::SurfaceDeviation deviation;
      const double most = deviation.bound({points, pair.a}, {points, pair.b}).distance;
      steps += deviation.steps();
      const double exact = SurfaceTwin(pair.positions, pair.a).distance_from({pair.positions, pair.b}, 1e-3);
      const double loose = deviation.bound({points, pair.a}, {points, pair.b}, {.enough = 2.0 * most}).distance;
      fewer += deviation.steps();
      ASSERT_GE(loose, exact / (1.0 + 1e-3));
      ASSERT_LE(loose, 2.0 * most * (1.0 + 1e-9));
    }
  EXPECT_LT(double(fewer), 0.8 * double(steps));
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
  EXPECT_LT(deviation.bound({points, low}, {points, high}).angle, 2e-7);
  EXPECT_NEAR(deviation.bound({points, half}, {points, low}).distance, 2.12, 0.13);
  EXPECT_NEAR(deviation.bound({points, low}, {points, half}).distance, 1.06 * std::sqrt(4.5), 0.13);
  EXPECT_EQ(deviation.bound({points, {}}, {points, low}).distance, 0.0);
}

TEST(SurfaceDeviation, KnowsAFold) {
  const std::vector<dvec3> points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<std::uint32_t> wall = {0, 1, 4}, floor = {0, 1, 2, 0, 2, 3};
  lod::SurfaceDeviation proof;
  const lod::Deviation deviation = proof.bound({points, wall}, {points, floor});
  EXPECT_NEAR(deviation.distance, 1.06, 0.07);
  EXPECT_NEAR(deviation.angle, 0.5 * std::numbers::pi, 1e-9);
  EXPECT_LT(proof.bound({points, floor}, {points, floor}).angle, 2e-7) << "nothing is left of the proof before";
}

using Long = long double;
using LongVector = std::array<Long, 3>;

/// Edges of floats are exact in long double, and so are most of their products.
LongVector long_edge(const core::vec3& from, const core::vec3& to) {
  return {Long(to.x) - Long(from.x), Long(to.y) - Long(from.y), Long(to.z) - Long(from.z)};
}
LongVector long_cross(const LongVector& a, const LongVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Long long_dot(const LongVector& a, const LongVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
LongVector long_normal(std::span<const core::vec3> p, std::size_t first) {
  return long_cross(long_edge(p[first], p[first + 1]), long_edge(p[first], p[first + 2]));
}
lod::Deviation of_two_triangles(const std::vector<core::vec3>& p, float error_a = 0.0f, float error_b = 0.0f) {
  const std::vector<dvec3> points(p.begin(), p.end());
  const std::array<std::uint32_t, 3> a{3, 4, 5}, b{0, 1, 2};
  return lod::SurfaceDeviation().bound({points, a, std::span(&error_a, 1)}, {points, b, std::span(&error_b, 1)});
}

/// A small triangle above a large one, far from the origin: the farthest of three heights, which doubles round.
TEST(SurfaceDeviation, IsNoLessThanTheExactDistance) {
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(2000)); ++seed) {
    SCOPED_TRACE(seed);
    MeshRandom random(seed);
    const double far = std::pow(10.0, between(random, 0.0, 5.0));
    const core::vec3 site = any_point(random, far);
    std::vector<core::vec3> p;
    for (int i = 0; i < 3; ++i) p.push_back(site + any_point(random, 1.0));
    const core::vec3 centre = (p[0] + p[1] + p[2]) / 3.0f, up = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
    for (std::size_t i = 0; i < 3; ++i) p.push_back(centre + 0.1f * (p[i] - centre) + float(i + 1) * 0.3f * up);
    const LongVector normal = long_normal(p, 0);
    Long farthest = 0.0L;
    for (std::size_t i = 3; i < 6; ++i)
      farthest = std::max(farthest, std::abs(long_dot(normal, long_edge(p[0], p[i]))));
    farthest /= std::sqrt(long_dot(normal, normal));
    ASSERT_GE(Long(of_two_triangles(p).distance), farthest);
    ASSERT_LE(Long(of_two_triangles(p).distance), farthest * (1.0L + 1e-11L) + 1e-11L * Long(far));
    // Errors may be larger than any coordinate. Their sum with the distance is no double.
    const auto error_a = float(std::pow(10.0, between(random, 5, 20))),
               error_b = float(between(random, 0, 1)) * error_a;
    ASSERT_GE(Long(of_two_triangles(p, error_a, error_b).distance), farthest + Long(error_a) + Long(error_b));
  }
}

/// A small triangle above or beside a needle, down to such whose normal has few exact digits, of any size.
TEST(SurfaceDeviation, IsNoLessThanTheExactDistanceFromNeedles) {
  using Point = glm::vec<3, Long>;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(20000)); ++seed) {
    SCOPED_TRACE(seed);
    MeshRandom random(seed);
    const double size = std::pow(10.0, between(random, -6, 9)), width = size * std::pow(10.0, between(random, -6, -1));
    std::vector<core::vec3> p{any_point(random, size), any_point(random, size)};
    p.push_back(p[0] + float(between(random, 0, 1)) * (p[1] - p[0]) + any_point(random, width));
    const dvec3 a(p[0]), normal = glm::normalize(glm::cross(dvec3(p[1]) - a, dvec3(p[2]) - a));
    const dvec3 middle = (a + dvec3(p[1]) + dvec3(p[2])) / 3.0;
    const core::vec3 beside = any_point(random, seed % 2 ? 0.0 : size);
    const core::vec3 near = core::vec3(middle + size * between(random, 0.01, 1) * normal) + beside;
    for (int i = 0; i < 3; ++i) p.push_back(near + any_point(random, 0.05 * width));
    Long farthest = 0.0L;
    for (std::size_t i = 3; i < 6; ++i)
      farthest = std::max(farthest, distance_to_triangle(Point(p[i]), Point(p[0]), Point(p[1]), Point(p[2])));
    ASSERT_GE(Long(of_two_triangles(p).distance), farthest);
    ASSERT_LE(Long(of_two_triangles(p).distance), farthest * 1.01L) << "and little more";
  }
}

/// Angles from those whose cosine is 1 in double to right ones, and triangles down to such whose normals have few exact
/// digits.
TEST(SurfaceDeviation, IsNoLessThanTheExactAngle) {
  int small = 0, thin = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(repeated(20000)); ++seed) {
    SCOPED_TRACE(seed);
    MeshRandom random(seed);
    std::vector<core::vec3> p;
    for (int i = 0; i < 3; ++i) p.push_back(any_point(random, 1.0));
    const double tilt = std::pow(10.0, between(random, -8, 0)), width = std::pow(10.0, between(random, -6, 0));
    for (std::size_t i = 0; i < 3; ++i) p.push_back(p[i] + any_point(random, tilt));
    for (std::size_t i : {2u, 5u}) p[i] = p[i - 1] + float(width) * (p[i] - p[i - 1]);
    const LongVector a = long_normal(p, 0), b = long_normal(p, 3), cross = long_cross(a, b);
    const Long exact = std::atan2(std::sqrt(long_dot(cross, cross)), long_dot(a, b));
    const double angle = of_two_triangles(p).angle;
    ASSERT_GE(Long(angle), exact);
    ASSERT_LE(Long(angle), exact + 1e-2L);
    small += exact < 1e-7L, thin += width < 1e-4;
  }
  EXPECT_GT(small, repeated(20000) / 100);
  EXPECT_GT(thin, repeated(20000) / 10);
}

}  // namespace
}  // namespace sightline::tests::surface_deviation_test
