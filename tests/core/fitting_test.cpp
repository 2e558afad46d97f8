// Views that many boxes fill, by all of their corners.
#include "sightline/core/fitting.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sightline/tests/core/primitive_samples.h"
#include "sightline/tests/core/seen_boxes.h"

namespace sightline::core::fitting_test {
namespace {

using tests::look_at_boxes;
using tests::Random;
using tests::Seen;
using tests::uniform;

constexpr double kFilled = 0.9;

/// Two opposite borders of the filled part are touched, and none is crossed.
void expect_filled(const Seen& seen, double centring) {
  constexpr double kTolerance = 1e-6;
  const dvec2 reach = glm::max(-seen.low, seen.high);
  EXPECT_LE(std::max(reach.x, reach.y), kFilled + kTolerance);
  EXPECT_GE(std::max(reach.x, reach.y), kFilled - centring);
  for (int axis = 0; axis < 2; ++axis) EXPECT_NEAR(seen.low[axis] + seen.high[axis], 0.0, 2.0 * centring);
  const dvec2 size = seen.high - seen.low;
  EXPECT_NEAR(std::max(size.x, size.y), 2.0 * kFilled, kTolerance);
}

std::vector<AabbD> random_boxes(Random& random, const dvec3& middle) {
  std::vector<AabbD> boxes;
  const int count = int(std::pow(10.0, uniform(random, 0.0, 2.5)));
  const dvec3 extent(uniform(random, 1.0, 50.0), uniform(random, 1.0, 50.0), uniform(random, 0.1, 20.0));
  for (int i = 0; i < count; ++i) {
    const dvec3 half = uniform(random, 0.0, 1.0) * dvec3(1.0, uniform(random, 0.0, 2.0), uniform(random, 0.0, 0.5));
    const dvec3 centre =
        middle + extent * dvec3(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0));
    boxes.push_back({centre - half, centre + half});
  }
  return boxes;
}

TEST(Fitting, FillsTheImageWithAllBoxes) {
  Random random(11);
  int smaller = 0;
  for (int i = 0; i < 2000; ++i) {
    SCOPED_TRACE("case " + std::to_string(i) + " of seed 11");
    const dvec3 middle = std::pow(10.0, uniform(random, 0.0, 6.0)) * tests::random_direction(random);
    const std::vector<AabbD> boxes = random_boxes(random, middle);
    const dvec3 direction = tests::random_direction(random);
    const double fovy = uniform(random, 0.2, 1.2), aspect = std::pow(10.0, uniform(random, -0.4, 0.4));
    Fitting fitting(direction, fovy, aspect, kFilled, middle);
    AabbD all;
    for (const AabbD& box : boxes) fitting.add(box), all.grow(box);
    const View view = fitting.perspective().value();
    const Seen seen = look_at_boxes(boxes, view);
    if (seen.nearest > 0.011 * glm::length(all.size())) expect_filled(seen, 0.02);
    EXPECT_GE(seen.nearest, 0.0099 * glm::length(all.size()));
    expect_filled(look_at_boxes(boxes, fitting.parallel().value()), 1e-6);
    // No box about all of them comes nearer.
    const View of_all = View::fit(all, direction, fovy, aspect, kFilled).value();
    const dvec3 forward = glm::normalize(direction);
    EXPECT_GE(glm::dot(view.eye() - of_all.eye(), forward), -1e-6 * glm::length(all.size()));
    smaller += glm::dot(view.eye() - of_all.eye(), forward) > 0.01 * glm::length(all.size());
  }
  EXPECT_GT(smaller, 500) << "boxes about all that leave corners empty";
}

TEST(Fitting, OfOneBoxIsFittingPose) {
  const AabbD box{{1e6, 3, -2}, {1e6 + 4, 5, 7}};
  Fitting fitting(kOverviewDirection, 0.8, 1.6, kFilled, box.centre());
  fitting.add(box);
  const Pose pose = fitting.pose(), expected = fitting_pose(box, kOverviewDirection, 0.8, 1.6, kFilled);
  EXPECT_EQ(pose.eye, expected.eye);
  EXPECT_EQ(pose.target, expected.target);
}

TEST(Fitting, OfNothingFails) {
  Fitting fitting(kOverviewDirection, 0.8, 1.6, kFilled, dvec3(0.0));
  fitting.add({});
  EXPECT_TRUE(fitting.empty());
  EXPECT_FALSE(fitting.perspective());
  EXPECT_FALSE(fitting.parallel());
}

TEST(Fitting, OfAPointShowsIt) {
  Fitting fitting(kOverviewDirection, 0.8, 1.6, kFilled, dvec3(0.0));
  fitting.add({dvec3(3, 4, 5), dvec3(3, 4, 5)});
  for (const auto& view : {fitting.perspective(), fitting.parallel()}) {
    ASSERT_TRUE(view);
    const dvec4 clip = view->clip_from_world() * dvec4(3, 4, 5, 1);
    EXPECT_LT(glm::length(dvec2(clip) / clip.w), 0.3);
  }
}

TEST(AddItems, TakesWhatSectionsKeepOfItemsWithin) {
  ItemBounds items;
  items.origin = {100.0, 0.0, 0.0};
  items.resize(5);
  items.set(0, {{0, 0, 0}, {1, 1, 1}});
  items.set(1, {{2, 0, 0}, {6, 1, 1}});
  items.set(2, {{2000, 0, 0}, {2001, 1, 1}});  // an outlier
  items.set(3, {{0, 0, 5}, {1, 1, 6}});
  items.set_layers(3, kLayerInsulation);
  const AabbD within{{100, 0, 0}, {200, 10, 10}};
  const auto parallel_width = [&](std::span<const Plane> sections) {
    Fitting fitting({0, 1, 0}, 0.8, 1.0, 1.0, dvec3(103, 0, 0));
    add_items(fitting, items, within, sections);
    return 2.0 / fitting.parallel().value().clip_from_eye()[0][0];
  };
  EXPECT_NEAR(parallel_width({}), 6.0, 1e-9);
  const Plane left{{-1, 0, 0}, 104.0}, right{{1, 0, 0}, -103.5}, none{{1, 0, 0}, -500.0};
  EXPECT_NEAR(parallel_width({&left, 1}), 4.0, 1e-9) << "of the second item up to x = 104";
  const Plane both[] = {left, right};
  EXPECT_NEAR(parallel_width(both), 1.0, 1e-9) << "0.5 wide, and 1 high";
  Fitting fitting({0, 1, 0}, 0.8, 1.0, 1.0, dvec3(0.0));
  add_items(fitting, items, within, {&none, 1});
  EXPECT_TRUE(fitting.empty());
}

}  // namespace
}  // namespace sightline::core::fitting_test
