// The steps of opening a model, and how long each takes.
#include "sightline/apps/view/opening_steps.h"

#include <chrono>

#include <gtest/gtest.h>

namespace sightline::apps::opening_steps_test {
namespace {

using namespace std::chrono_literals;

OpeningSteps::Clock::time_point after(std::chrono::seconds time) {
  return OpeningSteps::Clock::time_point() + time;
}

TEST(OpeningSteps, AddsUpWhatEachStepTakes) {
  OpeningSteps steps;
  EXPECT_EQ(steps.name(), "");
  steps.enter(OpeningStep::kReading, after(10s));
  EXPECT_EQ(steps.name(), "reading");
  steps.enter(OpeningStep::kDrawing, after(12s));
  steps.enter(OpeningStep::kUploading, after(15s));  // the context was lost
  steps.enter(OpeningStep::kDrawing, after(16s));
  steps.enter(OpeningStep::kNone, after(18s));
  steps.enter(OpeningStep::kNone, after(30s));
  EXPECT_EQ(steps.name(), "");
  EXPECT_EQ(steps.seconds(OpeningStep::kReading), 2.0);
  EXPECT_EQ(steps.seconds(OpeningStep::kBuilding), 0.0);
  EXPECT_EQ(steps.seconds(OpeningStep::kUploading), 1.0);
  EXPECT_EQ(steps.seconds(OpeningStep::kDrawing), 5.0);
}

}  // namespace
}  // namespace sightline::apps::opening_steps_test
