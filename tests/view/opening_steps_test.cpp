// The steps of opening a model, and how long each takes.
#include "sightline/apps/view/opening_steps.h"

#include <gtest/gtest.h>

namespace sightline::apps::opening_steps_test {
namespace {

TEST(OpeningSteps, AddsUpWhatEachStepTakes) {
  OpeningSteps steps;
  EXPECT_EQ(steps.name(), "");
  steps.enter(OpeningStep::kReading, 10.0);
  EXPECT_EQ(steps.name(), "reading");
  steps.enter(OpeningStep::kDrawing, 12.0);
  steps.enter(OpeningStep::kUploading, 15.0);  // the context was lost
  steps.enter(OpeningStep::kDrawing, 16.0);
  steps.enter(OpeningStep::kNone, 18.0);
  steps.enter(OpeningStep::kNone, 30.0);
  EXPECT_EQ(steps.name(), "");
  EXPECT_EQ(steps.seconds(OpeningStep::kReading), 2.0);
  EXPECT_EQ(steps.seconds(OpeningStep::kBuilding), 0.0);
  EXPECT_EQ(steps.seconds(OpeningStep::kUploading), 1.0);
  EXPECT_EQ(steps.seconds(OpeningStep::kDrawing), 5.0);
}

}  // namespace
}  // namespace sightline::apps::opening_steps_test
