// What sightline-bench lod measures with: distances of surfaces in images beside a search through all of them, and the
// chain of whole-mesh levels.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sightline/apps/bench/losses/level_chain.h"
#include "sightline/apps/bench/losses/surface_error.h"
#include "sightline/apps/bench/losses/triangle_distance.h"
#include "sightline/tests/lod/mesh_samples.h"

namespace sightline::tests::losses_test {
namespace {

using core::dvec3;
using image::ItemDepths;

constexpr int kFiner = 4, kWidth = 16, kHeight = 12;

ItemDepths blank(int width, int height) {
  const std::size_t pixels = std::size_t(width) * std::size_t(height);
  return {{width, height, std::vector<std::uint32_t>(pixels, 0)},
          {width, height, std::vector<float>(pixels, std::numeric_limits<float>::infinity())}};
}

core::View view() {
  return *core::View::perspective({{0, 0, 10}, {0, 0, 0}, {0, 1, 0}}, 0.8, double(kWidth) / kHeight, 0.1);
}

/// Two items, of which the nearer covers a part of the image, with depths that vary.
ItemDepths scene(int finer, double farther, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const double slope = std::uniform_real_distribution(-0.3, 0.3)(random),
               edge = std::uniform_real_distribution(4.0, 12.0)(random);
  ItemDepths surface = blank(finer * kWidth, finer * kHeight);
  for (int y = 0; y < finer * kHeight; ++y)
    for (int x = 0; x < finer * kWidth; ++x) {
      const std::size_t i = std::size_t(y) * std::size_t(finer * kWidth) + std::size_t(x);
      const double u = (x + 0.5) / finer, v = (y + 0.5) / finer;
      const bool near = u < edge;
      surface.ids.ids[i] = near ? 1 : v < 9.0 ? 2 : 0;
      if (surface.ids.ids[i] > 0)
        surface.depth.metres[i] = float((near ? 5.0 : 9.0) + slope * u + 0.1 * v + 0.2 * std::sin(3.0 * v) + farther);
    }
  return surface;
}

/// The distance of a pixel's point through all cells of the reference.
double searched(const ItemDepths& reference, const ItemDepths& image, int x, int y) {
  const double focal = 0.5 * kWidth * view().clip_from_eye()[0][0];
  const std::size_t pixel = std::size_t(y) * kWidth + std::size_t(x);
  const double depth = image.depth.metres[pixel];
  const auto at = [&](double u, double v, double z) {
    return z / depth * dvec3(u - 0.5 * kWidth, v - 0.5 * kHeight, focal);
  };
  const dvec3 point = at(x + 0.5, y + 0.5, depth);
  double best = std::numeric_limits<double>::infinity();
  const int width = reference.ids.width;
  for (int j = 0; j + 1 < reference.ids.height; ++j)
    for (int i = 0; i + 1 < width; ++i) {
      const auto corner = [&](int k) {
        const int u = i + (k & 1), v = j + (k >> 1);
        return at((u + 0.5) / kFiner, (v + 0.5) / kFiner,
                  double(reference.depth.metres[std::size_t(v) * std::size_t(width) + std::size_t(u)])) -
               point;
      };
      const auto shows = [&](int k) {
        return reference.ids.ids[std::size_t(j + (k >> 1)) * std::size_t(width) + std::size_t(i + (k & 1))] ==
               image.ids.ids[pixel];
      };
      for (int k = 0; k < 4; ++k)
        if (shows(k)) best = std::min(best, glm::length(corner(k)));
      if (shows(1) && shows(2)) {
        if (shows(0)) best = std::min(best, bench::distance_to_triangle(corner(0), corner(1), corner(2)));
        if (shows(3)) best = std::min(best, bench::distance_to_triangle(corner(1), corner(3), corner(2)));
      }
    }
  return best;
}

TEST(SurfaceErrors, AreThoseOfASearchThroughAll) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const ItemDepths reference = scene(kFiner, 0.0, seed), image = scene(1, 0.1 * double(seed), seed + seed % 2);
    const std::vector<double> errors = bench::surface_errors(view(), reference, kFiner, image, 4.0);
    std::vector<double> expected;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (image.ids.ids[std::size_t(y) * kWidth + std::size_t(x)] > 0)
          if (const double error = searched(reference, image, x, y); error <= 4.0) expected.push_back(error);
    ASSERT_EQ(errors.size(), expected.size());
    EXPECT_GT(errors.size(), 60u);
    for (std::size_t i = 0; i < errors.size(); ++i) ASSERT_NEAR(errors[i], expected[i], 1e-9);
  }
}

TEST(DistanceToTriangle, IsTheLeastOfManyPoints) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int round = 0; round < 200; ++round) {
    const auto corner = [&] { return dvec3(any(random), any(random), any(random)) + dvec3(0.3); };
    const dvec3 a = corner(), b = corner(), c = corner();
    double least = std::numeric_limits<double>::infinity();
    constexpr int kSteps = 100;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j)
        least = std::min(least, glm::length(a + double(i) / kSteps * (b - a) + double(j) / kSteps * (c - a)));
    const double distance = bench::distance_to_triangle(a, b, c);
    ASSERT_LE(distance, least + 1e-12);
    ASSERT_GE(distance, least - 0.03);
  }
}

/// Levels have fewer and fewer triangles, and an item is drawn by one of them, coarser where more error is allowed.
TEST(LevelChain, ChoosesOneOfHalvings) {
  core::Scene scene;
  const auto torus = scene.add_mesh(bumpy_torus(40, 0.05)).value();
  for (int i = 0; i < 3; ++i) scene.add_mesh_instance(scene.root(), torus, core::translation({4.0 * i, 0, 0}));
  scene.add_primitive(scene.root(), core::Sphere{1.0f}, core::translation({0, 4, 0}));
  ASSERT_TRUE(scene.commit());
  bench::LevelChain chain(scene);
  const core::Snapshot drawn(chain.scene());
  core::VisibleSet all, chosen;
  all.ranges.push_back({0, core::Slot(chain.model().size())});
  const core::View from = *core::View::perspective({{4, -2, 12}, {4, 0, 0}}, 0.8, 1.5, 0.1);
  std::size_t before = std::numeric_limits<std::size_t>::max(), full = 0;
  for (const double pixels : {0.0, 0.5, 2.0, 8.0}) {
    chain.choose({from, 300, 200, pixels}, all, drawn, chosen);
    ASSERT_EQ(chosen.single_slots.size(), 4u);
    std::vector<bool> met(scene.item_slots());
    std::size_t indices = 0;
    for (const core::Slot slot : chosen.single_slots) {
      const core::ItemId original = chain.originals()[to_index(drawn.item(slot))];
      EXPECT_FALSE(met[to_index(original)]);
      met[to_index(original)] = true;
      if (drawn.kind(slot) == core::Kind::kMesh) indices += drawn.mesh(slot).indices.size();
    }
    if (pixels == 0.0) full = indices;
    EXPECT_LE(indices, before);
    before = indices;
  }
  EXPECT_EQ(full, 3 * scene.mesh(torus).indices.size());
  const bool simplified = chain.originals().size() > scene.item_slots();  // there is meshoptimizer
  EXPECT_TRUE(!simplified || before < full / 8) << before << " of " << full;
}

}  // namespace
}  // namespace sightline::tests::losses_test
