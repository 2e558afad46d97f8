// Measured runs, errors, operation counts, and the generated models that they are of.
#include "sightline/apps/study/measure.h"

#include <gtest/gtest.h>

#include "sightline/apps/bench/brute_force.h"
#include "sightline/apps/bench/models/aircraft.h"
#include "sightline/apps/bench/models/platforms.h"
#include "sightline/apps/study/operations.h"
#include "sightline/apps/study/session.h"
#include "sightline/tests/culling/scenes.h"

namespace sightline::study::measure_test {
namespace {

constexpr unsigned kSeed = 23;

Model small_model() {
  tests::Random random(kSeed);
  Model model;
  model.boxes = tests::random_boxes(random, 300, 50.0);
  for (int i = 0; i < 8; ++i) {
    const core::Pose pose{{5.0 * i, -40.0, 3.0}, {0, 0, 0}, {0, 0, 1}};
    model.path.views.push_back(*core::View::perspective(pose, 0.7, 1.3, 0.1, 200.0));
  }
  model.prepare(3);
  return model;
}

TEST(StudyMeasure, RunsEverythingAndCountsErrors) {
  const Model model = small_model();
  EXPECT_EQ(model.path.sampled, (std::vector<std::size_t>{1, 4, 6}));
  int told = 0;
  const Results r = run_everything(model, {2, {}, [&told](const std::string&) { ++told; }});
  EXPECT_EQ(r.runs.size(), std::size_t(told));
  EXPECT_EQ(r.runs.back().variant, bench::BruteForce::name());
  ASSERT_NE(r.find(kProduction), nullptr);
  ASSERT_NE(r.find(r.best_flags), nullptr);
  for (const study::Run& run : r.runs) {
    SCOPED_TRACE(run.variant);
    EXPECT_EQ(run.ms.size(), model.path.views.size());
    EXPECT_EQ(run.visible.size(), model.path.views.size());
    EXPECT_EQ(run.samples, 3u);
    EXPECT_LE(run.min_ms, run.median_ms);
    EXPECT_LE(run.median_ms, run.max_ms);
    if (run.promise && run.promise != Promise::kErrs) {
      EXPECT_EQ(run.errors.false_negatives, 0u);
    }
    EXPECT_GE(run.errors.false_positives, run.errors.extra);
  }
}

TEST(StudyMeasure, SeparatingAxesFindWhatPlanesDoNot) {
  // Beside the frustum's edge: no single plane has the box behind it, yet it does not meet the frustum.
  const auto view = core::View::perspective({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1.5707963267948966, 1.0, 1.0, 10.0);
  const std::vector<core::Aabb> boxes{{{-1.0f, 5.0f, -1.0f}, {1.0f, 6.0f, 1.0f}},    // inside
                                      {{9.0f, -40.0f, -1.0f}, {60.0f, 9.5f, 1.0f}},  // through the right side
                                      {{10.5f, 5.0f, -1.0f}, {60.0f, 60.0f, 1.0f}},  // beyond the far right corner
                                      {{-1.0f, -3.0f, -1.0f}, {1.0f, 0.5f, 1.0f}}};  // before the near plane
  const ExactSets exact(boxes, *view);
  EXPECT_EQ(exact.p_vertex(), (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(exact.meeting(), (std::vector<std::uint32_t>{0, 1}));
  const Errors e = compare({0, 2, 3}, exact);
  EXPECT_EQ(e.visible, 3u);
  EXPECT_EQ(e.extra, 1u);
  EXPECT_EQ(e.missing, 1u);
  EXPECT_EQ(e.false_positives, 2u);
  EXPECT_EQ(e.false_negatives, 1u);
}

TEST(StudyMeasure, OperationsAreCounted) {
  const Model model = small_model();
  const OperationTable table = count_operations(model.boxes, model.path.views);
  ASSERT_EQ(table.size(), 4u);
  for (const Operations& o : table) {
    EXPECT_GT(o.best, 0u);
    EXPECT_LT(o.best, o.worst);
    EXPECT_LE(double(o.best), o.mean);
    EXPECT_LE(o.mean, double(o.worst));
  }
  // One plane, one vertex: five operations for its height, offset and comparison, three signs, and no n-vertex.
  EXPECT_EQ(table[3].best, 10u);
}

TEST(StudyModels, TheAircraftHasTheCountAsked) {
  const auto boxes = bench::make_aircraft(10'000), again = bench::make_aircraft(10'000);
  EXPECT_EQ(boxes.size(), 10'000u);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    ASSERT_FALSE(boxes[i].empty());
    ASSERT_LT(glm::length(boxes[i].max), 80.0f);
    ASSERT_EQ(boxes[i].min, again[i].min);
  }
}

TEST(StudyModels, KindsOfPlatformsAreMixedToTheItem) {
  for (const bench::Platform& platform : bench::kPlatforms) {
    for (const std::size_t count : {1000u, 12345u}) {
      SCOPED_TRACE(platform.name);
      std::vector<std::uint8_t> kinds;
      for (std::size_t i = 0; i < count; ++i) kinds.push_back(std::uint8_t(i * 7919 % 20 < 13 ? 0 : i % 4));
      bench::mix_kinds(platform, kinds);
      std::array<std::uint64_t, 4> have{};
      for (const std::uint8_t k : kinds) ++have.at(k);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(have[k], platform.counts[k] * count / platform.objects());
    }
  }
}

}  // namespace
}  // namespace sightline::study::measure_test
