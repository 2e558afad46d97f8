// Fewer pixels while a view moves and frames come late.
#include "sightline/apps/view/motion_resolution.h"

#include <gtest/gtest.h>

namespace sightline::apps::motion_resolution_test {
namespace {

constexpr double kSlow = 2.0 * MotionResolution::kLate, kQuick = 0.5 * MotionResolution::kLate;

TEST(MotionResolution, OnlyLateMotionsGetFewerPixels) {
  MotionResolution resolution;
  EXPECT_FALSE(resolution.next(false, 0.0, kSlow));
  EXPECT_FALSE(resolution.next(true, 1.0, kSlow)) << "that frame was not one of a motion";
  for (int i = 1; i < 10; ++i) EXPECT_FALSE(resolution.next(true, 1.0 + 0.01 * i, kQuick));
  EXPECT_TRUE(resolution.next(true, 1.2, kSlow));
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(resolution.next(true, 1.3 + 0.01 * i, kQuick)) << "until the view rests";
}

TEST(MotionResolution, AllPixelsComeBackAtRest) {
  MotionResolution resolution;
  for (int i = 0; i < 3; ++i) (void)resolution.next(true, i, kSlow);
  EXPECT_TRUE(resolution.next(false, 2.0 + 0.9 * MotionResolution::kRest, kSlow)) << "a pause between two events";
  EXPECT_TRUE(resolution.next(true, 2.0 + 0.95 * MotionResolution::kRest, kQuick));
  EXPECT_TRUE(resolution.next(false, 2.0 + 1.5 * MotionResolution::kRest, kQuick));
  EXPECT_FALSE(resolution.next(false, 2.0 + 2.0 * MotionResolution::kRest, kSlow));
  EXPECT_FALSE(resolution.next(true, 4.0, kSlow)) << "a new motion";
  EXPECT_TRUE(resolution.next(true, 4.1, kSlow));
}

}  // namespace
}  // namespace sightline::apps::motion_resolution_test
