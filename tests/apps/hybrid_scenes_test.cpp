// The scenes of sightline-bench hybrid: kinds to the item, and boxes where they belong.
#include <array>

#include <gtest/gtest.h>

#include "sightline/apps/bench/hybrid/scenes.h"
#include "sightline/apps/bench/models/aircraft.h"
#include "sightline/importers/plant/plant_generator.h"

namespace sightline::hybrid_scenes_test {
namespace {

using core::AabbD;
using core::Kind;

std::array<std::uint64_t, core::kKindCount> kinds_of(const core::Scene& scene) {
  std::array<std::uint64_t, core::kKindCount> counts{};
  for (core::ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (scene.contains_item(item)) ++counts[std::size_t(scene.kind(item))];
  return counts;
}

AabbD bounds_of(const core::Scene& scene, core::ItemId item) {
  return scene.bounds_under(item, scene.state(item).world_from_item);
}

TEST(HybridScenes, PlatformsHaveTheKindsOfTable31) {
  for (const bench::Platform& platform : bench::kPlatforms) {
    SCOPED_TRACE(platform.name);
    core::Scene scene;
    ASSERT_TRUE(bench::make_platform_scene(platform, 1.0, scene));
    const auto counts = kinds_of(scene);
    EXPECT_EQ(counts[std::size_t(Kind::kCylinder)], platform.counts[0]);
    EXPECT_EQ(counts[std::size_t(Kind::kSnout)], platform.counts[1]);
    EXPECT_EQ(counts[std::size_t(Kind::kCircularTorus)], platform.counts[2]);
    EXPECT_EQ(scene.item_count(), platform.primitives());
  }
}

/// What is given as another kind stays in its place: new items lie where the removed ones lay.
TEST(HybridScenes, AnotherKindKeepsItsPlace) {
  const bench::Platform& platform = bench::kPlatforms[3];  // half of it torus slices
  const std::uint64_t items = platform.primitives();
  core::Scene plant, scene;
  ASSERT_TRUE(bench::make_platform_scene(platform, 0.02, scene));
  importers::PlantOptions config;
  config.items = std::uint64_t(double(items) * 0.02);
  config.seed = items;
  ASSERT_TRUE(importers::generate_plant(config, plant));
  const auto before = core::ItemId(plant.item_slots());
  core::ItemId replacement = before;  // in the order of what they replace
  std::size_t torus_slices = 0;
  for (core::ItemId item{0}; item < before; ++item) {
    if (scene.contains_item(item)) continue;
    ASSERT_TRUE(scene.contains_item(replacement));
    torus_slices += scene.kind(replacement) == Kind::kCircularTorus;
    const AabbD old_box = bounds_of(plant, item), new_box = bounds_of(scene, replacement);
    ++replacement;
    const double size = glm::length(old_box.size());
    EXPECT_LE(glm::length(new_box.centre() - old_box.centre()), 0.1 * size) << "item " << to_index(item);
    EXPECT_LE(glm::length(new_box.size()), 1.5 * size) << "item " << to_index(item);
    EXPECT_GE(glm::length(new_box.size()), 0.5 * size) << "item " << to_index(item);
  }
  EXPECT_EQ(to_index(replacement), scene.item_slots());
  EXPECT_GT(torus_slices, 1000u);
}

TEST(HybridScenes, PrismsFillTheAircraftsBoxes) {
  core::Scene scene;
  bench::make_aircraft_scene(0.005, scene);
  ASSERT_TRUE(scene.commit());
  const std::vector<core::Aabb> boxes = bench::make_aircraft(scene.item_slots());
  ASSERT_EQ(scene.item_count(), std::size_t(0.005 * double(bench::kAircraftMeshes)));
  for (core::ItemId item{0}; to_index(item) < boxes.size(); ++item) {
    const AabbD box = bounds_of(scene, item);
    const double near = 1e-5 * glm::length(box.size()) + 1e-9;
    EXPECT_LE(glm::length(box.min - core::dvec3(boxes[to_index(item)].min)), near) << "item " << to_index(item);
    EXPECT_LE(glm::length(box.max - core::dvec3(boxes[to_index(item)].max)), near) << "item " << to_index(item);
  }
}

}  // namespace
}  // namespace sightline::hybrid_scenes_test
