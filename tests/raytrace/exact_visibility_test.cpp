// The exact visible set against areas that are known, and against single rays.
#include "sightline/raytrace/exact_visibility.h"

#include <cmath>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "sightline/core/image_rays.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::raytrace::exact_visibility_test {
namespace {

using core::dvec3;

/// Looks down on the square 0 … 8, one metre a pixel in an image of 8 x 8.
core::View from_above() {
  return *core::View::orthographic({{4, 4, 10}, {4, 4, 0}, {0, 1, 0}}, 8.0, 1.0, 1.0, 100.0);
}

TEST(ExactVisibility, CountsCoveredSamples) {
  core::Scene scene;
  const auto add = [&](float x, float y, const dvec3& centre) {
    return scene.add_primitive(scene.root(), core::Box{x, y, 1}, core::translation(centre));
  };
  const core::ItemId floor = add(8, 8, {4, 4, 0}), table = add(4, 2, {2, 1, 2}), cup = add(1, 1, {0.5, 0.5, 4});
  add(3, 1, {1.5, 0.5, -3});  // hidden
  scene.add_primitive(scene.root(), core::Line{-4, 4}, core::translation({4, 4, 6}));
  ASSERT_TRUE(scene.commit());
  const core::Snapshot snapshot(scene);
  const Tracer tracer = std::move(*Tracer::create(snapshot));
  const ExactVisibility visibility(tracer);
  for (const int samples : {1, 4, 16})
    for (const int threads : {1, 3}) {
      const auto items = visibility.compute(from_above(), 8, 8, samples, threads);
      ASSERT_TRUE(items);
      const auto n = std::uint64_t(samples);
      const std::vector<VisibleItem> expected{{floor, 56 * n}, {table, 7 * n}, {cup, n}};
      EXPECT_EQ(*items, expected) << samples;
    }
  core::View cut = from_above();
  cut.sections.push_back({{0, 0, -1}, 1.0});  // below z = 1
  EXPECT_EQ(*visibility.compute(cut, 8, 8), (std::vector<VisibleItem>{{floor, 64}}));
  cut.layers = core::kLayerInsulation;
  EXPECT_TRUE(visibility.compute(cut, 8, 8)->empty());
}

TEST(ExactVisibility, SamplesSpreadOverThePixel) {
  EXPECT_EQ(sample_positions(1), std::vector<core::dvec2>{core::dvec2(0.5, 0.5)});
  EXPECT_EQ(sample_positions(4)[1], core::dvec2(0.75, 0.25));
  EXPECT_EQ(sample_positions(4)[2], core::dvec2(0.25, 0.75));
  for (const int samples : {2, 3, 8, 9, 13, 16, 25, 32, 64}) {
    SCOPED_TRACE(samples);
    std::set<int> rows, columns;
    core::dvec2 sum(0.0);
    for (const core::dvec2& p : sample_positions(samples)) {
      EXPECT_TRUE(p.x > 0.0 && p.x < 1.0 && p.y > 0.0 && p.y < 1.0);
      columns.insert(int(p.x * samples));
      rows.insert(int(p.y * samples));
      sum += p;
    }
    EXPECT_LT(glm::length(sum / double(samples) - 0.5), 1e-12);
    const int n = int(std::lround(std::sqrt(samples)));
    const auto lines = std::size_t(n * n == samples ? n : samples);
    EXPECT_EQ(columns.size(), lines);
    EXPECT_EQ(rows.size(), lines);
  }
}

TEST(ExactVisibility, AgreesWithSingleRays) {
  tests::Random random(1);
  core::Scene scene;
  for (int i = 0; i < 300; ++i)
    scene.add_primitive(scene.root(), core::Cylinder{0.3f, 2.0f},
                        {tests::random_rotation(random), 5.0 * tests::random_direction(random)});
  ASSERT_TRUE(scene.commit());
  const core::Snapshot snapshot(scene);
  const Tracer tracer = std::move(*Tracer::create(snapshot));
  const auto view = *core::View::perspective({{0, -20, 3}, {0, 0, 0}, {0, 0, 1}}, 0.6, 1.5, 0.1);
  std::map<core::ItemId, std::uint64_t> counts;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 60; ++x)
      if (const auto hit = tracer.nearest(*core::image_ray(view, 60, 40, x + 0.5, y + 0.5)); *hit)
        ++counts[(*hit)->item];
  std::vector<VisibleItem> expected;
  for (const auto& [item, samples] : counts) expected.push_back({item, samples});
  EXPECT_GT(expected.size(), 50u);
  EXPECT_EQ(*ExactVisibility(tracer).compute(view, 60, 40), expected);
}

TEST(ExactVisibility, RefusesImagesOfNothing) {
  core::Scene scene;
  ASSERT_TRUE(scene.commit());
  const core::Snapshot snapshot(scene);
  const Tracer tracer = std::move(*Tracer::create(snapshot));
  EXPECT_FALSE(ExactVisibility(tracer).compute(from_above(), 0, 8));
  EXPECT_FALSE(ExactVisibility(tracer).compute(from_above(), 8, 8, 0));
  EXPECT_TRUE(ExactVisibility(tracer).compute(from_above(), 8, 8)->empty());
}

}  // namespace
}  // namespace sightline::raytrace::exact_visibility_test
