// Boxes in, indices out: against a loop over all boxes.
#include "sightline/culling/box_culler.h"

#include <algorithm>
#include <limits>

#include <glm/gtc/type_ptr.hpp>
#include <gtest/gtest.h>

#include "scenes.h"

namespace sightline::tests::box_culler_test {
namespace {

using core::AabbD;
using core::dvec3;
using culling::BoxCuller;
using Indices = std::vector<std::uint32_t>;

std::vector<AabbD> boxes_around(Random& random, std::size_t count, const dvec3& site, double half) {
  std::vector<AabbD> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const dvec3 low = site + point(random, half);
    boxes.push_back({low, low + magnitude(random, 1e-3, 0.1) * half * dvec3(1.0, uniform(random, 0, 1), 1.0)});
    if (chance(random, 0.02)) boxes.back() = {};
  }
  return boxes;
}

/// How far the box's best corner lies inside the worst plane; below 0: outside. In units of the plane's normal.
double inside_by(const AabbD& box, const core::View& view) {
  double least = std::numeric_limits<double>::infinity();
  for (const core::Plane& plane : core::frustum_planes(view.clip_from_world(), view.clip_depth())) {
    if (plane.normal == dvec3(0.0)) continue;
    long double most = plane.offset;
    for (int axis = 0; axis < 3; ++axis)
      most +=
          std::max((long double)plane.normal[axis] * box.min[axis], (long double)plane.normal[axis] * box.max[axis]);
    least = std::min(least, double(most / (long double)glm::length(plane.normal)));
  }
  return least;
}

Indices visible_of(const BoxCuller& culler, const core::View& view) {
  Indices indices;
  const core::dmat4 clip = view.clip_from_world();
  EXPECT_TRUE(culler.visible(glm::value_ptr(clip), view.clip_depth(), indices));
  std::sort(indices.begin(), indices.end());
  return indices;
}

/// Exact but for a band of a millionth of the scene, in which boxes stay.
void expect_right(const BoxCuller& culler, const std::vector<AabbD>& boxes, const core::View& view, double half) {
  const Indices indices = visible_of(culler, view);
  ASSERT_EQ(std::adjacent_find(indices.begin(), indices.end()), indices.end()) << "named twice";
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    const bool found = std::binary_search(indices.begin(), indices.end(), i);
    if (boxes[i].empty()) {
      ASSERT_FALSE(found) << "box " << i << " is empty";
      continue;
    }
    const double by = inside_by(boxes[i], view);
    ASSERT_TRUE(found || by < 0.0) << "box " << i << " is lost";
    ASSERT_TRUE(!found || by > -1e-6 * half) << "box " << i << " is outside";
  }
}

TEST(BoxCuller, FindsWhatALoopOverAllBoxesFinds) {
  std::size_t found = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = magnitude(random, 1.0, 1e3);
    const dvec3 site = seed % 2 ? dvec3(0.0) : point(random, 1e5);
    std::vector<AabbD> boxes = boxes_around(random, std::size_t(whole(random, 0, 3000)), site, half);
    auto culler = BoxCuller::create(boxes);
    ASSERT_TRUE(culler);
    EXPECT_EQ(culler->size(), boxes.size());
    for (int i = 0; i < 6; ++i) {
      const core::View view = random_view(random, site, half);
      ASSERT_NO_FATAL_FAILURE(expect_right(*culler, boxes, view, half + glm::length(site)));
      found += visible_of(*culler, view).size();
      Indices of_view;
      culler->visible(view, of_view);
      std::sort(of_view.begin(), of_view.end());
      EXPECT_EQ(of_view, visible_of(*culler, view));
    }
    if (boxes.empty()) continue;
    const std::vector<AabbD> others = boxes_around(random, 100, site, 1.5 * half);
    for (const AabbD& other : others) {
      const auto index = std::uint32_t(whole(random, 0, int(boxes.size()) - 1));
      boxes[index] = other;
      ASSERT_TRUE(culler->update(index, other));
    }
    const BoxCuller moved = std::move(*culler);
    ASSERT_NO_FATAL_FAILURE(expect_right(moved, boxes, random_view(random, site, half), half + glm::length(site)));
  }
  EXPECT_GT(found, 10'000u);
}

/// Of the visible boxes, those that the occlusion test leaves open one by one.
TEST(BoxCuller, LeavesOutWhatADepthImageHides) {
  std::size_t hidden = 0, open = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = 20.0;
    const int most = seed % 8 == 0 ? 60'000 : 3000;  // many enough for several threads
    std::vector<AabbD> boxes = boxes_around(random, std::size_t(whole(random, 0, most)), dvec3(0.0), half);
    boxes.push_back({dvec3(-100.0), dvec3(-99.0)});  // the middle of all is the origin, so boxes round as they do here
    boxes.push_back({dvec3(99.0), dvec3(100.0)});
    const auto culler = BoxCuller::create(boxes);
    ASSERT_TRUE(culler);
    const core::View view = random_view(random, dvec3(0.0), half);
    const int width = whole(random, 1, 300), height = whole(random, 1, 200);
    std::vector<float> wall(std::size_t(width) * std::size_t(height), float(half * uniform(random, 0.1, 1.0)));
    for (std::size_t i = 0; i < wall.size() / 8; ++i) wall[i] = std::numeric_limits<float>::infinity();
    culling::DepthPyramid depth;
    depth.build(wall, width, height);
    const culling::OcclusionTest test(view, dvec3(0.0), width, height, depth);
    Indices all, found, expected;
    culler->visible(view, all);
    culler->visible(view, depth, found);
    for (const std::uint32_t i : all)
      if (!test.hidden(core::round_outwards(boxes[i], dvec3(0.0)))) expected.push_back(i);
    std::sort(found.begin(), found.end());
    std::sort(expected.begin(), expected.end());
    ASSERT_EQ(found, expected);
    open += expected.size();
    hidden += all.size() - expected.size();
  }
  EXPECT_GT(open, 500u);
  EXPECT_GT(hidden, 500u);
}

TEST(BoxCuller, ADepthImageThatWasNeverMadeHidesNothing) {
  Random random(3);
  const std::vector<AabbD> boxes = boxes_around(random, 2000, dvec3(0.0), 20.0);
  const auto culler = BoxCuller::create(boxes);
  ASSERT_TRUE(culler);
  const core::View view = core::View::perspective({{0, -60, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1).value();
  Indices all, found;
  culler->visible(view, all);
  culler->visible(view, culling::DepthPyramid(), found);
  EXPECT_FALSE(all.empty());
  EXPECT_EQ(found, all);
}

TEST(BoxCuller, RefusesWhatItCannotCull) {
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  const AabbD good{dvec3(0.0), dvec3(1.0)};
  for (const AabbD& bad : {AabbD{dvec3(nan), dvec3(1.0)}, AabbD{dvec3(0.0), dvec3(1.0, nan, 1.0)},
                           AabbD{dvec3(-inf), dvec3(inf)}, AabbD{dvec3(0.0), dvec3(1.0, 1.0, inf)}}) {
    const std::vector<AabbD> boxes{good, bad};
    const auto refused = BoxCuller::create(boxes);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message, "box 1: expected finite corners");
    auto culler = BoxCuller::create(std::span(&good, 1));
    EXPECT_FALSE(culler->update(0, bad));
    const core::View view = core::View::perspective({{0, -5, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1).value();
    EXPECT_EQ(visible_of(*culler, view), Indices{0}) << "nothing has changed";
  }
  auto culler = BoxCuller::create(std::span(&good, 1));
  const core::dmat4 spoiled(nan);
  Indices indices;
  EXPECT_FALSE(culler->visible(glm::value_ptr(spoiled), core::ClipDepth::kMinusOneToOne, indices));
}

}  // namespace
}  // namespace sightline::tests::box_culler_test
