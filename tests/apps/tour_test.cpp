// Tours of reports show something of the model in every frame, where tours by bounds alone do not.
#include "sightline/apps/report/tour.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/core/snapshot.h"
#include "sightline/engine/tour.h"

namespace sightline::apps::tour_test {
namespace {

constexpr double kAspect = 16.0 / 9.0;
constexpr int kFrames = 97;

core::Affine at(const core::dvec3& place) {
  core::Affine affine;
  affine.origin = place;
  return affine;
}

/// Spheres in clusters at the ends of a line, with nothing between and around them.
core::Scene sparse_scene(float radius) {
  core::Scene scene;
  for (const double end : {-60.0, 60.0})
    for (int i = 0; i < 27; ++i)
      scene.add_primitive(scene.root(), core::Sphere{radius},
                          at(core::dvec3(end, 0, 0) + 4.0 * core::dvec3(i % 3, i / 3 % 3, i / 9)));
  return scene;
}

/// A scene, and what tours of it need.
struct Stage {
  explicit Stage(core::Scene made) : scene(std::move(made)) {
    EXPECT_TRUE(scene.commit());
    snapshot.emplace(scene);
    fitted = snapshot->bounds().fitted_bounds();
    auto created = raytrace::Tracer::create(*snapshot);
    EXPECT_TRUE(created);
    if (created) tracer.emplace(std::move(*created));
  }
  core::CameraPath plain_tour() const { return engine::make_tour(snapshot->bounds(), fitted); }

  core::Scene scene;
  std::optional<core::Snapshot> snapshot;
  core::FittedBounds fitted;
  std::optional<raytrace::Tracer> tracer;
};

std::vector<double> shares(const raytrace::Tracer& tracer, const core::CameraPath& path) {
  std::vector<double> shares;
  for (int i = 0; i < kFrames; ++i)
    shares.push_back(*covered_share(tracer, *path.view(path.time_of(i, kFrames), kAspect), kAspect));
  return shares;
}

double least(const std::vector<double>& values) {
  return *std::min_element(values.begin(), values.end());
}

TEST(Tour, KeepsTheModelInSight) {
  const Stage stage(sparse_scene(1.5f));
  ASSERT_TRUE(stage.tracer);
  const core::CameraPath before = stage.plain_tour();
  ASSERT_EQ(least(shares(*stage.tracer, before)), 0.0) << "this scene tests nothing";
  const auto tour = tour_in_sight(*stage.tracer, stage.fitted, kAspect);
  ASSERT_TRUE(tour);
  EXPECT_GT(least(shares(*stage.tracer, *tour)), 0.0);
  EXPECT_DOUBLE_EQ(tour->end(), before.end());
  EXPECT_EQ(tour->near, before.near);
}

/// Where the tour was right, nothing changes but the spacing of keys.
TEST(Tour, StaysWhereTheModelIsInSight) {
  const Stage stage(sparse_scene(12.0f));
  ASSERT_TRUE(stage.tracer);
  const core::CameraPath before = stage.plain_tour();
  const auto tour = tour_in_sight(*stage.tracer, stage.fitted, kAspect);
  ASSERT_TRUE(tour);
  for (const double time : {0.0, 1.0, 2.0})
    EXPECT_LT(glm::length(tour->sample(time).pose.target - before.sample(time).pose.target), 0.1) << time;
}

TEST(Tour, OfNothingIsThePlainTour) {
  const Stage stage{core::Scene()};
  ASSERT_TRUE(stage.tracer);
  const auto tour = tour_in_sight(*stage.tracer, stage.fitted, kAspect);
  ASSERT_TRUE(tour);
  EXPECT_EQ(tour->keys().size(), stage.plain_tour().keys().size());
}

/// From inside of an item, its walls are all that is in sight: that is not the model.
TEST(Tour, AnItemThatFillsTheImageCountsAsNothing) {
  core::Scene scene;
  scene.add_primitive(scene.root(), core::Sphere{10.0f}, core::Affine{});
  scene.add_primitive(scene.root(), core::Sphere{1.0f}, at({30, 0, 0}));
  const Stage stage(std::move(scene));
  ASSERT_TRUE(stage.tracer);
  const auto share = [&](const core::dvec3& eye) {
    return *covered_share(*stage.tracer, *core::View::perspective({eye, {30, 0, 0}, {0, 0, 1}}, 1.0, kAspect, 0.1, 1e3),
                          kAspect);
  };
  EXPECT_EQ(share({0, 0, 0}), 0.0) << "inside";
  EXPECT_GT(share({50, 0, 0}), 0.01);
  EXPECT_LT(share({50, 0, 0}), 0.5);
}

}  // namespace
}  // namespace sightline::apps::tour_test
