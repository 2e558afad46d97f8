// The sample test against exact arithmetic: the line of sight of every sample, in rationals, meets a box or not.
#include "sightline/culling/occlusion/sample_test.h"

#include <gtest/gtest.h>

#include "exact_samples.h"
#include "scenes.h"
#include "sightline/core/visible_set.h"
#include "sightline/culling/frustum/linear_culler.h"

namespace sightline::tests::sample_test_test {
namespace {

using core::Aabb;
using core::View;
using culling::ImageSamples;
using culling::SampleTest;

ImageSamples random_samples(Random& random, int width, int height) {
  ImageSamples samples{width, height, {}};
  const int count = chance(random, 0.7) ? 1 : whole(random, 2, 8);
  for (int i = 0; i < count; ++i)
    samples.offsets.push_back(
        count == 1 ? std::array<float, 2>{0.0f, 0.0f}
                   : std::array<float, 2>{float(whole(random, -8, 7)) / 16.0f, float(whole(random, -8, 7)) / 16.0f});
  return samples;
}

TEST(SampleTest, NeverRejectsABoxThatASampleSees) {
  std::size_t seen = 0, unseen = 0, kept = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const auto [half, origin, view] = RandomSite(random);
    const ImageSamples samples = random_samples(random, whole(random, 1, 9), whole(random, 1, 7));
    const SampleTest test(view, origin, samples);
    const ExactSamples exact(view, origin, samples);
    for (int i = 0; i < 12; ++i) {
      const Aabb box = chance(random, 0.3) ? random_box(random, half) : box_at_a_sample(random, view, origin, samples);
      const bool sampled = exact.covered_by(box), covers = test.covers(box);
      ASSERT_TRUE(covers || !sampled) << i;
      ++(sampled ? seen : unseen);
      kept += covers && !sampled;
    }
  }
  EXPECT_GT(seen, 300u);
  EXPECT_GT(unseen, 500u);
  EXPECT_LT(kept, 3 * unseen / 4) << "boxes at samples included";
}

/// Boxes of a tenth of a pixel: those between samples are left out, however the samples lie.
TEST(SampleTest, LeavesOutSmallBoxesBetweenSamples) {
  const View view = *View::perspective({{0, -10, 0}, {0, 0, 0}, {0, 0, 1}}, 1.0, 2.0, 0.1);
  const double pixel = 20.0 * std::tan(0.5) / 100.0;  // at a distance of 10
  const auto box_at = [&](double x, double y) {
    return box_around({x * pixel, 0.0, y * pixel}, core::dvec3(0.05 * pixel, 0.0, 0.05 * pixel));
  };
  const SampleTest one(view, core::dvec3(0.0), {200, 100, {{0, 0}}});
  EXPECT_TRUE(one.covers(box_at(0.5, 0.5)));
  EXPECT_TRUE(one.covers(box_at(-99.5, 49.5)));
  for (const core::dvec2 p : {core::dvec2(0.0, 0.5), {0.5, 0.0}, {0.7, 0.5}, {0.5, 0.3}, {-99.8, 49.5}, {100.5, 0.5}})
    EXPECT_FALSE(one.covers(box_at(p.x, p.y))) << p.x << ' ' << p.y;
  const SampleTest two(view, core::dvec3(0.0), {200, 100, {{-0.25f, -0.25f}, {0.25f, 0.25f}}});
  EXPECT_TRUE(two.covers(box_at(0.25, 0.25)));
  EXPECT_TRUE(two.covers(box_at(7.75, 3.75)));
  EXPECT_FALSE(two.covers(box_at(0.25, 0.75)));
  EXPECT_FALSE(two.covers(box_at(0.5, 0.5)));
}

/// Thin rods askew in the image: their rectangles have many samples, of which rays meet few rods.
TEST(SampleTest, LeavesOutRodsBetweenTheRaysOfSamples) {
  const View view = *View::perspective({{0, -10, 0}, {0, 0, 0}, {1, 0, 1.37}}, 1.0, 1.0, 0.1);
  const double pixel = 20.0 * std::tan(0.5) / 64.0;  // at a distance of 10
  using Offsets = decltype(culling::ImageSamples::offsets);
  for (const Offsets& offsets : {Offsets{{0, 0}}, Offsets{{-0.25f, 0.125f}, {0.125f, -0.25f}}})
    for (const double length : {8.0, 18.0}) {
      Random random(7);
      const SampleTest test(view, core::dvec3(0.0), {64, 64, offsets, 0x1p-8f});
      int kept = 0;
      for (int i = 0; i < 1000; ++i) {
        const core::dvec3 middle{uniform(random, -20, 20) * pixel, 0.0, uniform(random, -20, 20) * pixel};
        kept += test.covers(box_around(middle, pixel * core::dvec3(0.5 * length, 0.002, 0.002)));
      }
      // As many samples as lie in the rod, grown by what a rasteriser may move it.
      const double expected = 1000.0 * double(offsets.size()) * length * (0.004 + 2.0 * 0x1p-8 * std::sqrt(2.0));
      EXPECT_GT(kept, 0.6 * expected) << offsets.size() << ' ' << length;
      EXPECT_LT(kept, 1.4 * expected) << offsets.size() << ' ' << length;
    }
}

TEST(SampleTest, KeepsWhatItCannotJudge) {
  const View view = *View::perspective({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1.0, 1.0, 0.1);
  const SampleTest test(view, core::dvec3(0.0), {8, 8, {{0, 0}}});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(test.covers({{-1, -1, -1}, {1, 1, 1}})) << "around the eye";
  EXPECT_TRUE(test.covers({{5, -1, 0}, {6, 1, 1}})) << "beside the eye";
  EXPECT_TRUE(test.covers({{nan, 5, 0}, {1, 6, 1}}));
  EXPECT_TRUE(test.covers({{0, 5, 0}, {1, 6, nan}}));
  EXPECT_TRUE(test.covers({core::vec3(-core::Aabb::kFar), core::vec3(core::Aabb::kFar)}));
  EXPECT_FALSE(test.covers({}));
  EXPECT_FALSE(test.covers({{0, 5, 0}, {1, 4, 1}})) << "inverted";
}

/// Vacant slots go, exempt ones stay, and the answer is that of single boxes whatever the instruction set and the
/// number of threads.
TEST(SampleTest, FiltersSets) {
  core::ThreadPool few(2), many(5);
  std::size_t ranges = 0, items = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = 10.0;
    core::ItemBounds bounds;
    const std::size_t count = std::size_t(whole(random, 0, seed % 10 == 0 ? 20'000 : 700));
    bounds.resize(count);
    auto boxes = random_boxes(random, count, half);
    spoil(random, boxes);
    for (std::size_t i = 0; i < count; ++i)
      if (!chance(random, 0.05)) bounds.set(i, boxes[i]);
    const View view = random_view(random, core::dvec3(0.0), half);
    const SampleTest test(view, core::dvec3(0.0), random_samples(random, whole(random, 1, 400), whole(random, 1, 400)));
    core::VisibleSet in;
    in.generation = seed;
    for (std::uint32_t s = 0; s < count; ++s) {
      const std::uint32_t run = std::uint32_t(whole(random, 1, 90));
      if (chance(random, 0.4) && s + run <= count) {
        in.ranges.push_back({s, run});
        s += run;
      } else if (!bounds.vacant(s) && chance(random, 0.7)) {
        in.single_slots.push_back(s);
      }
    }
    std::vector<std::uint64_t> exempt(chance(random, 0.5) ? (count + 63) / 64 : 0);
    std::vector<core::Slot> expected;
    for (const core::Slot slot : in.sorted_slots()) {
      const bool spared = !exempt.empty() && !bounds.vacant(slot) && chance(random, 0.1);
      if (spared) exempt[slot / 64] |= std::uint64_t(1) << slot % 64;
      if (spared || test.covers(bounds.box(slot))) expected.push_back(slot);
    }
    core::VisibleSet out;
    for_each_instruction_set([&] {
      test.filter(bounds, in, out, exempt);
      ASSERT_EQ(out.sorted_slots(), expected);
      ASSERT_EQ(out.generation, seed);
      ASSERT_TRUE(std::is_sorted(out.single_slots.begin(), out.single_slots.end()));
      for (std::size_t i = 1; i < out.ranges.size(); ++i)
        ASSERT_LT(out.ranges[i - 1].first + out.ranges[i - 1].count, out.ranges[i].first);
    });
    for (core::ThreadPool* const threads : {&few, &many}) {
      core::VisibleSet shared;
      test.filter(bounds, in, shared, exempt, threads);
      ASSERT_EQ(shared.ranges, out.ranges);
      ASSERT_EQ(shared.single_slots, out.single_slots);
      ASSERT_EQ(shared.generation, seed);
    }
    ranges += out.ranges.size();
    items += out.single_slots.size();
  }
  EXPECT_GT(ranges, 50u);
  EXPECT_GT(items, 500u);
}

}  // namespace
}  // namespace sightline::tests::sample_test_test
