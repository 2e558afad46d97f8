// Boxes in, indices out: against a loop over all boxes, also after changes.
#include "sightline/culling/box_culler.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>
#include <thread>

#include <glm/gtc/type_ptr.hpp>
#include <gtest/gtest.h>

#include "scenes.h"
#include "sightline/culling/frustum/linear_culler.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/tests/support/effort.h"

namespace sightline::tests::box_culler_test {
namespace {

using core::AabbD;
using core::dvec3;
using culling::BoxCuller;
using culling::DepthPyramid;
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

/// The slow twin of a culler that is changed: boxes in an array in the order of their indices, and a loop over it.
class Twin {
 public:
  explicit Twin(const std::vector<AabbD>& boxes) { reset(boxes); }

  void set(std::uint32_t index, const AabbD& box) {
    boxes_[index] = box;
    bounds_.set(index, core::round_outwards(box, bounds_.origin));
  }
  void reset(const std::vector<AabbD>& boxes) {
    AabbD all;
    for (const AabbD& box : boxes)
      if (!box.empty()) all.grow(box);
    boxes_ = boxes;
    bounds_ = {};
    if (!all.empty()) bounds_.origin = glm::round(all.centre());
    bounds_.resize(boxes.size());
    for (std::uint32_t i = 0; i < boxes.size(); ++i) set(i, boxes[i]);
  }
  Indices visible(const core::View& view) const {
    core::VisibleSet set;
    culling::LinearCuller(bounds_).cull(view, set);
    Indices indices = set.sorted_slots();
    std::erase_if(indices, [&](std::uint32_t i) { return bounds_.vacant(i); });
    return indices;
  }
  const std::vector<AabbD>& boxes() const { return boxes_; }

 private:
  std::vector<AabbD> boxes_;
  core::ItemBounds bounds_;
};

/// What becomes of a box that changes: it moves nearby or far away, shrinks to a point or to nothing, or grows to all
/// of the scene. `wild`: or its corners come near the limits of float and double, or lie between the two.
AabbD changed_box(Random& random, const AabbD& box, double half, bool wild) {
  const double most = std::numeric_limits<double>::max();
  if (wild) {
    const double extremes[] = {3e38, 3.4028234663852886e38, 3.5e38, 1e300, most, 1e-45, 1e-320, 0.0};
    const auto number = [&] { return (chance(random, 0.5) ? 1.0 : -1.0) * extremes[whole(random, 0, 7)]; };
    const dvec3 a(number(), number(), number()), b(number(), number(), number());
    return {glm::min(a, b), glm::max(a, b)};
  }
  const dvec3 middle = box.empty() ? dvec3(0.0) : box.centre();
  const dvec3 size = box.empty() ? dvec3(0.1 * half) : box.size();
  switch (whole(random, 0, 6)) {
    case 0:
      return {middle, middle};
    case 1:
      return {};
    case 2:
      return {dvec3(1.0), dvec3(2.0, -1.0, 2.0)};  // inverted in one axis: empty, too
    case 3:
      return {middle - dvec3(half), middle + dvec3(half)};
    case 4: {
      const dvec3 far = middle + point(random, 1e4 * half);
      return {far, far + size};
    }
    default: {
      const dvec3 near = middle + point(random, 0.1 * half);
      return {near - 0.5 * size, near + 0.5 * size};
    }
  }
}

/// A batch for both: all boxes, none, or some, of which every few are the same.
void change_some(Random& random, BoxCuller& culler, Twin& twin, double half, bool wild) {
  const int size = int(culler.size());
  Indices indices;
  if (chance(random, 0.2)) {
    for (int i = 0; i < size; ++i) indices.push_back(std::uint32_t(i));
    std::shuffle(indices.begin(), indices.end(), random);
  } else {
    for (int i = int(magnitude(random, 0.5, 2.0 * size)); i > 0; --i)
      indices.push_back(chance(random, 0.1) && !indices.empty() ? indices.back()
                                                                : std::uint32_t(whole(random, 0, size - 1)));
  }
  std::vector<AabbD> boxes;
  for (const std::uint32_t index : indices) boxes.push_back(changed_box(random, twin.boxes()[index], half, wild));
  ASSERT_TRUE(culler.update(indices, boxes));
  for (std::size_t i = 0; i < indices.size(); ++i) twin.set(indices[i], boxes[i]);
}

/// All boxes anew for both, perhaps with the whole site elsewhere, larger or smaller. Afterwards the culler is like a
/// new one, not only like its twin.
void change_all(Random& random, BoxCuller& culler, Twin& twin, dvec3& site, double half, bool wild) {
  std::vector<AabbD> boxes = twin.boxes();
  const dvec3 by = chance(random, 0.5) ? point(random, 1e3 * half) : dvec3(0.0);
  const double scale = chance(random, 0.5) ? magnitude(random, 1e-2, 1e2) : 1.0;
  const dvec3 middle = site;
  site += by;
  for (AabbD& box : boxes) {
    if (chance(random, 0.5)) box = changed_box(random, box, half, wild);
    if (!box.empty() && !wild) box = {site + scale * (box.min - middle), site + scale * (box.max - middle)};
  }
  if (chance(random, 0.1)) std::fill(boxes.begin(), boxes.end(), AabbD());
  ASSERT_TRUE(culler.refit(boxes));
  twin.reset(boxes);
  const auto fresh = BoxCuller::create(boxes);
  ASSERT_TRUE(fresh);
  for (int i = 0; i < 3; ++i) {
    const core::View view = random_view(random, site, half);
    ASSERT_EQ(visible_of(culler, view), visible_of(*fresh, view));
  }
}

void expect_changes_like_the_twin(int seeds, double least, double most, bool wild) {
  std::size_t found = 0;
  for (std::uint64_t seed = 1; seed <= std::uint64_t(seeds); ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = magnitude(random, 1.0, 1e3);
    dvec3 site = seed % 2 ? dvec3(0.0) : point(random, 1e5);
    Twin twin(boxes_around(random, std::size_t(magnitude(random, least, most)), site, half));
    auto culler = BoxCuller::create(twin.boxes());
    ASSERT_TRUE(culler);
    for (int round = 0; round < 8; ++round) {
      SCOPED_TRACE(testing::Message() << "round " << round);
      if (round % 4 == 2) {
        ASSERT_NO_FATAL_FAILURE(change_all(random, *culler, twin, site, half, wild));
      } else {
        ASSERT_NO_FATAL_FAILURE(change_some(random, *culler, twin, half, wild));
      }
      const core::View view = random_view(random, site, half);
      const Indices indices = visible_of(*culler, view);
      ASSERT_EQ(indices, twin.visible(view));
      found += indices.size();
      if (wild) continue;
      ASSERT_NO_FATAL_FAILURE(expect_right(*culler, twin.boxes(), view, 1e5 * half + glm::length(site)));
    }
  }
  EXPECT_GT(found, 1000u);
}

TEST(BoxCuller, ChangesManyBoxesLikeALoop) {
  expect_changes_like_the_twin(40, 1.0, 5e3, false);
}

TEST(BoxCuller, ChangesManyBoxesLikeALoopOnThreads) {
  expect_changes_like_the_twin(repeated(20), 3e4, 3e5, false);
}

TEST(BoxCuller, ChangesBoxesAtTheLimitsOfNumbers) {
  expect_changes_like_the_twin(60, 1.0, 3e3, true);
}

TEST(BoxCuller, OfARepeatedIndexTheLastBoxCounts) {
  const AabbD here{dvec3(-1.0), dvec3(1.0)}, behind{dvec3(-1.0, -20.0, -1.0), dvec3(1.0, -19.0, 1.0)};
  const std::vector<AabbD> boxes(100, behind);
  auto culler = BoxCuller::create(boxes);
  ASSERT_TRUE(culler);
  const core::View view = core::View::perspective({{0, -5, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1).value();
  ASSERT_TRUE(culler->update(Indices{7, 8, 7, 8, 7}, std::vector<AabbD>{here, here, behind, behind, here}));
  EXPECT_EQ(visible_of(*culler, view), Indices{7});
  ASSERT_TRUE(culler->update(Indices{}, {}));
  EXPECT_EQ(visible_of(*culler, view), Indices{7});
}

/// Finds the visible boxes that the occlusion test keeps when asked one by one.
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
    auto culler = BoxCuller::create(boxes);
    ASSERT_TRUE(culler);
    if (seed % 3 == 0) {
      Indices moved;
      for (std::uint32_t i = 0; i < boxes.size(); i += 3)
        std::swap(boxes[i], boxes[boxes.size() / 2]), moved.push_back(i);
      moved.push_back(std::uint32_t(boxes.size() / 2));
      std::vector<AabbD> to;
      for (const std::uint32_t i : moved) to.push_back(boxes[i]);
      ASSERT_TRUE(culler->update(moved, to));
    }
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
      if (!test.occluded(core::round_outwards(boxes[i], dvec3(0.0)))) expected.push_back(i);
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

/// Against a loop over all boxes with integer corners, so that their rounding outwards changes no answer.
TEST(BoxCuller, AnswersQueriesLikeALoop) {
  Random random(3);
  std::vector<AabbD> boxes;
  for (int i = 0; i < 20000; ++i) {
    const dvec3 low(whole(random, -40, 40), whole(random, -40, 40), whole(random, -40, 40));
    boxes.push_back({low, low + dvec3(whole(random, 0, 3), whole(random, 0, 3), whole(random, 0, 3))});
  }
  const auto culler = BoxCuller::create(boxes);
  ASSERT_TRUE(culler);
  const AabbD range{dvec3(-10.5, -5.5, -0.5), dvec3(12.5, 9.5, 20.5)};
  const dvec3 place(3, -4, 5);
  const auto distance = [&](std::uint32_t i) {
    return glm::length(glm::clamp(place, boxes[i].min, boxes[i].max) - place);
  };
  Indices touching, within, near;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    const auto& [low, high] = boxes[i];
    if (glm::all(glm::lessThanEqual(low, range.max)) && glm::all(glm::lessThanEqual(range.min, high)))
      touching.push_back(i);
    if (glm::all(glm::lessThanEqual(range.min, low)) && glm::all(glm::lessThanEqual(high, range.max)))
      within.push_back(i);
    if (distance(i) <= 10.0) near.push_back(i);
  }
  Indices found;
  culler->in_box(range, false, found);
  EXPECT_EQ(found, touching);
  culler->in_box(range, true, found);
  EXPECT_EQ(found, within);
  culler->around(place, 10.0, found);
  EXPECT_EQ(found, near);

  std::vector<culling::BoxHit> hits;
  culler->nearest(place, 20, hits);
  ASSERT_EQ(hits.size(), 20u);
  std::vector<double> distances;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) distances.push_back(distance(i));
  std::sort(distances.begin(), distances.end());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    EXPECT_NEAR(hits[i].distance, distances[i], 1e-4);
    EXPECT_NEAR(hits[i].distance, distance(hits[i].index), 1e-4);
  }
  const core::Ray ray{.origin = {-100, 1.5, 2.5}, .direction = {1, 0, 0}};
  Indices along;
  for (std::uint32_t i = 0; i < boxes.size(); ++i)
    if (boxes[i].min.y <= 1.5 && boxes[i].max.y >= 1.5 && boxes[i].min.z <= 2.5 && boxes[i].max.z >= 2.5)
      along.push_back(i);
  culler->along(ray, boxes.size(), hits);
  found.clear();
  for (std::size_t i = 0; i < hits.size(); ++i) {
    found.push_back(hits[i].index);
    EXPECT_NEAR(hits[i].distance, boxes[hits[i].index].min.x + 100, 1e-4);
    EXPECT_GE(hits[i].distance, hits[i > 0 ? i - 1 : 0].distance);
  }
  std::sort(found.begin(), found.end());
  EXPECT_GT(found.size(), 2u);
  EXPECT_EQ(found, along);
  culler->along(ray, 2, hits);
  EXPECT_EQ(hits.size(), 2u);
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

    const AabbD away{dvec3(0.0, -20.0, 0.0), dvec3(1.0, -19.0, 1.0)};
    auto several = BoxCuller::create(std::vector<AabbD>(20'000, good));
    std::vector<AabbD> changed(20'000, away);
    changed[9000] = changed[19'000] = bad;
    Indices indices(20'000);
    std::iota(indices.rbegin(), indices.rend(), 0u);
    const auto not_updated = several->update(indices, changed), not_refitted = several->refit(changed);
    ASSERT_FALSE(not_updated || not_refitted);
    EXPECT_EQ(not_updated.error().message, "box 10999: expected finite corners") << "the first one's index";
    EXPECT_EQ(not_refitted.error().message, "box 9000: expected finite corners") << "the first one";
    EXPECT_EQ(visible_of(*several, view).size(), 20'000u) << "nothing has changed";
  }
  auto culler = BoxCuller::create(std::span(&good, 1));
  const core::dmat4 spoiled(nan);
  Indices indices;
  EXPECT_FALSE(culler->visible(glm::value_ptr(spoiled), core::ClipDepth::kMinusOneToOne, indices));
}

TEST(BoxCuller, MisuseIsAnErrorAndChangesNothing) {
  const AabbD box{dvec3(-1.0), dvec3(1.0)}, other{dvec3(2.0), dvec3(3.0)};
  const std::vector<AabbD> boxes(3, box), others(2, other);
  auto culler = *BoxCuller::create(boxes);
  const auto message = [](const core::Expected<void>& done) { return done ? "" : done.error().message; };
  const Indices wrong{0, 3}, right{0, 1};
  EXPECT_EQ(message(culler.update(3, other)), "box culler: expected indices below 3, found 3");
  EXPECT_EQ(message(culler.update(0xffffffffu, other)), "box culler: expected indices below 3, found 4294967295");
  EXPECT_EQ(message(culler.update(wrong, others)), "box culler: expected indices below 3, found 3");
  EXPECT_EQ(message(culler.update(right, boxes)), "box culler: expected 2 boxes, found 3");
  EXPECT_EQ(message(culler.refit(others)), "box culler: expected 3 boxes, found 2");
  const core::View view = *core::View::perspective({{0, -5, 0}, {0, 0, 0}, {0, 0, 1}}, 0.2, 1.0, 0.1);
  EXPECT_EQ(visible_of(culler, view).size(), 3u);

  BoxCuller moved = std::move(culler);
  for (BoxCuller* from : {&culler, &moved}) {  // NOLINT(bugprone-use-after-move)
    Indices indices{7};
    if (from == &moved) BoxCuller(std::move(moved)).visible(view, indices), indices = {7};
    EXPECT_EQ(from->size(), 0u);
    EXPECT_EQ(from->bounds().size(), 0u);
    EXPECT_TRUE(from->indices().empty());
    from->visible(view, indices);
    EXPECT_TRUE(indices.empty());
    const std::string expected = "box culler: its boxes were moved to another one";
    EXPECT_EQ(message(from->visible(view.clip_from_world(), view.clip_depth(), indices)), expected);
    EXPECT_EQ(message(from->update(0, box)), expected);
    EXPECT_EQ(message(from->refit(boxes)), expected);
  }
}

/// Answers belong to the boxes before or after a change: of two states, each with all boxes on one side of the view.
TEST(BoxCuller, ChangesWaitForQueries) {
  constexpr std::size_t kCount = 3000;
  std::vector<AabbD> states[2];
  for (std::size_t i = 0; i < kCount; ++i) {
    const dvec3 low(double(i % 50), 10.0 + double(i / 50), 0.0);
    states[0].push_back({low, low + 60.0});  // more than a pixel of the depth image
    states[1].push_back(i % 2 ? AabbD{} : AabbD{-low - 60.0, -low});
  }
  auto culler = *BoxCuller::create(states[0]);
  const core::View view = *core::View::orthographic({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 400.0, 1.0, -400.0, 400.0);
  const core::View half = *core::View::orthographic({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 400.0, 1.0, 0.0, 400.0);
  Indices all(kCount);
  std::iota(all.begin(), all.end(), 0u);
  DepthPyramid nothing;
  nothing.build(std::vector<float>(64, std::numeric_limits<float>::infinity()), 8, 8);
  std::atomic<int> answers = 0, neither = 0;
  std::atomic<bool> done = false;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        for (Indices found; !done; ++answers) {
          if (t == 0) culler.visible(view, nothing, found);
          if (t != 0)
            (void)culler.visible(t == 1 ? half.clip_from_world() : view.clip_from_world(), view.clip_depth(), found);
          const std::size_t other = t == 1 ? 0 : kCount / 2;
          neither += found.size() != kCount && found.size() != other;
        }
      });
    for (int i = 0; i < 60 || answers < 200; ++i) {
      const std::vector<AabbD>& boxes = states[(i + 1) % 2];
      ASSERT_TRUE(i % 3 ? culler.update(all, boxes) : culler.refit(boxes));
    }
    done = true;
  }
  EXPECT_EQ(neither, 0) << "of " << answers;
}

}  // namespace
}  // namespace sightline::tests::box_culler_test
