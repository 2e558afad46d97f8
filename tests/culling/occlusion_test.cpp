// The pyramid against its pixels, and the occlusion test against exact arithmetic.
#include "sightline/culling/occlusion/occlusion_test.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "exact_samples.h"
#include "sightline/culling/occlusion/internal/tile_shape.h"

namespace sightline::tests::occlusion_test {
namespace {

using culling::DepthPyramid;
using culling::OcclusionTest;

constexpr float kNothing = std::numeric_limits<float>::infinity();

/// Large areas of few distances, some of them empty.
std::vector<float> random_distances(Random& random, int width, int height, double half) {
  std::vector<float> distances(std::size_t(width) * std::size_t(height), kNothing);
  for (int i = whole(random, 0, 6); i > 0; --i) {
    const float distance = float(half * magnitude(random, 1e-2, 10.0));
    const int x0 = whole(random, 0, width - 1), x1 = whole(random, x0, width - 1);
    const int y0 = whole(random, 0, height - 1), y1 = whole(random, y0, height - 1);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) distances[std::size_t(y * width + x)] = distance;
  }
  return distances;
}

TEST(DepthPyramid, BlocksHoldTheFarthestOfTheirPixels) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const int width = whole(random, 1, 150), height = whole(random, 1, 40);
    std::vector<float> distances(std::size_t(width * height));
    for (float& d : distances) d = chance(random, 0.05) ? kNothing : float(uniform(random, -10.0, 10.0));
    for_each_instruction_set([&] {
      DepthPyramid pyramid;
      pyramid.build(distances, width, height);
      ASSERT_EQ(pyramid.band_count(), (height + 31) / 32);
      ASSERT_GE(pyramid.memory_bytes(), distances.size() * sizeof(float));
      ASSERT_LE(pyramid.memory_bytes(), 3 * distances.size() * sizeof(float) + 512);
      for (int level = 0; level < pyramid.level_count(); ++level)
        for (int y = 0; y <= (height - 1) >> level; ++y)
          for (int x = 0; x <= (width - 1) >> level; ++x) {
            float farthest = -kNothing;
            for (int py = y << level; py < std::min(height, (y + 1) << level); ++py)
              for (int px = x << level; px < std::min(width, (x + 1) << level); ++px)
                farthest = std::max(farthest, distances[std::size_t(py * width + px)]);
            ASSERT_EQ(pyramid.row(level, y)[x], farthest) << "level " << level << ", block " << x << " " << y;
          }
    });
  }
}

TEST(DepthPyramid, HoldsNothingWhenCleared) {
  for (const auto& [width, height] :
       {std::pair(0, 0), std::pair(70, 33), std::pair(8, 8), std::pair(70, 9), std::pair(9, 33)}) {
    DepthPyramid pyramid;
    EXPECT_EQ(pyramid.width(), 0);
    EXPECT_EQ(pyramid.height(), 0);
    if (width > 0) pyramid.build(std::vector<float>(std::size_t(width * height), 1.0f), width, height);
    pyramid.clear(70, 33);
    ASSERT_EQ(pyramid.width(), 70);
    ASSERT_EQ(pyramid.height(), 33);
    for (int level = 0; level < pyramid.level_count(); ++level)
      for (int y = 0; y <= 32 >> level; ++y)
        for (int x = 0; x <= 69 >> level; ++x) ASSERT_EQ(pyramid.row(level, y)[x], kNothing);
  }
}

/// Never nearer than the pixels themselves; the same wherever the rectangle is that of whole blocks.
TEST(DepthPyramid, AnswersForItsPixels) {
  std::size_t nearer = 0, lost = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const int width = whole(random, 1, 70), height = whole(random, 1, 70);
    auto distances = random_distances(random, width, height, 1.0);
    if (chance(random, 0.2)) distances[0] = std::numeric_limits<float>::quiet_NaN();
    DepthPyramid pyramid;
    pyramid.build(distances, width, height);
    ASSERT_EQ(pyramid.width(), width);
    ASSERT_EQ(pyramid.height(), height);
    for (int i = 0; i < 200; ++i) {
      const int x0 = whole(random, 0, width - 1),
                x1 = whole(random, x0, std::min(width - 1, x0 + whole(random, 0, 69)));
      const int y0 = whole(random, 0, height - 1),
                y1 = whole(random, y0, std::min(height - 1, y0 + whole(random, 0, 69)));
      float farthest = 0.0f;
      for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
          const float d = distances[std::size_t(y * width + x)];
          farthest = std::isnan(d) ? kNothing : std::max(farthest, d);
        }
      const float distance =
          chance(random, 0.5) ? std::nextafter(farthest, kNothing) : float(magnitude(random, 1e-2, 20.0));
      const bool expected = farthest < distance, found = pyramid.all_nearer(x0, y0, x1, y1, distance);
      ASSERT_TRUE(expected || !found);
      if (x1 - x0 < 8 && y1 - y0 < 8) {
        ASSERT_EQ(found, expected) << "single pixels";
      }
      nearer += expected;
      lost += expected && !found;
    }
  }
  EXPECT_GT(nearer, 3000u);
  EXPECT_LT(lost, nearer / 4);
}

/// If a box is occluded, no line of sight through a pixel centre meets a point in front of what the pixel holds.
TEST(OcclusionTest, HidesOnlyWhatEveryPixelHides) {
  std::size_t hidden = 0, open = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const auto [half, origin, view] = RandomSite(random);
    // Boxes of up to 64 pixels are tested with others, larger ones by themselves.
    const int most = chance(random, 0.05) ? 3 : 1;
    const ImageSamples samples{whole(random, 1, 9 * most), whole(random, 1, 7 * most), {{0, 0}}};
    const ExactSamples exact(view, origin, samples);
    for (int i = 0; i < 12; ++i) {
      const Aabb box = chance(random, 0.3) ? random_box(random, half) : box_at_a_sample(random, view, origin, samples);
      auto distances = random_distances(random, samples.width, samples.height, half);
      // Just in front of the box, or just behind its front.
      std::vector<std::optional<mpq_class>> nearest;
      for (int y = 0; y < samples.height; ++y)
        for (int x = 0; x < samples.width; ++x) nearest.push_back(exact.nearest(box, x, y));
      if (chance(random, 0.7))
        for (std::size_t k = 0; k < nearest.size(); ++k)
          if (nearest[k]) distances[k] = float(nearest[k]->get_d() * (1.0 + uniform(random, -4e-5, 1e-6)));
      DepthPyramid pyramid;
      pyramid.build(distances, samples.width, samples.height);
      const bool hides = OcclusionTest(view, origin, samples.width, samples.height, pyramid).occluded(box);
      ++(hides ? hidden : open);
      if (!hides) continue;
      for (std::size_t k = 0; k < nearest.size(); ++k) {
        if (!nearest[k]) continue;
        ASSERT_LT(distances[k], kNothing);
        ASSERT_TRUE(*nearest[k] > mpq_class(double(distances[k]))) << "box " << i << ", pixel " << k;
      }
    }
  }
  EXPECT_GT(hidden, 500u);
  EXPECT_GT(open, 500u);
}

TEST(OcclusionTest, AWallHidesWhatIsBehindItAlone) {
  const View view = *View::perspective({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1.0, 4.0 / 3.0, 0.1);
  std::vector<float> wall(640 * 480, 10.0f);
  DepthPyramid pyramid;
  pyramid.build(wall, 640, 480);
  const OcclusionTest test(view, core::dvec3(0.0), 640, 480, pyramid);
  EXPECT_TRUE(test.occluded({{-1, 10.01f, -1}, {1, 11, 1}}));
  EXPECT_FALSE(test.occluded({{-1, 9.99f, -1}, {1, 11, 1}}));
  const auto behind_by = [](float share) { return Aabb{{-1, 10.0f * (1.0f + share), -1}, {1, 11, 1}}; };
  EXPECT_TRUE(test.occluded(behind_by(1.3f * 0x1p-16f)));
  EXPECT_FALSE(test.occluded(behind_by(0.8f * 0x1p-16f)));
  EXPECT_FALSE(test.occluded({{-1, -1, -1}, {1, 30, 1}})) << "around the eye";
  EXPECT_TRUE(test.occluded({{900, 10.01f, 900}, {901, 11, 901}})) << "beside the image";
  EXPECT_TRUE(test.occluded({}));
  wall[240 * 640 + 320] = kNothing;  // a hole of one pixel
  pyramid.build(wall, 640, 480);
  EXPECT_FALSE(test.occluded({{-1, 20, -1}, {1, 21, 1}}));
  EXPECT_TRUE(test.occluded({{1, 20, -1}, {2, 21, 1}}));
}

TEST(OcclusionTest, HidesNothingBeforeItsPyramidIsBuilt) {
  const View view = *View::perspective({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1.0, 4.0 / 3.0, 0.1);
  core::ItemBounds bounds;
  bounds.resize(100);
  for (std::size_t i = 0; i < 100; ++i) bounds.set(i, {{-1, 20, -1}, {1, 21, 1}});
  const culling::Hierarchy hierarchy(bounds);
  core::VisibleSet all;
  all.ranges = {{0, 100}};
  DepthPyramid pyramid;
  const OcclusionTest test(view, core::dvec3(0.0), 64, 48, pyramid);
  const auto left = [&] {
    EXPECT_EQ(test.occluded(bounds.box(0)), pyramid.width() == 64 && pyramid.height() == 48);
    core::VisibleSet open, leaves, front, behind;
    test.filter(bounds, all, open);
    test.filter_leaves(hierarchy, all, leaves);
    test.split_front(bounds, &hierarchy, all, front, behind);
    EXPECT_EQ(leaves.count(), open.count());
    EXPECT_EQ(front.count() + behind.count(), open.count());
    return open.count();
  };
  EXPECT_EQ(left(), 100u) << "never built";
  for (const auto& [width, height] : {std::pair(32, 24), std::pair(64, 24), std::pair(32, 48)}) {
    pyramid.build(std::vector<float>(std::size_t(width * height), 10.0f), width, height);
    EXPECT_EQ(left(), 100u) << "of another size";
  }
  pyramid.build(std::vector<float>(64 * 48, 10.0f), 64, 48);
  EXPECT_EQ(left(), 0u);
}

std::vector<core::Slot> merged(const std::vector<core::Slot>& a, const std::vector<core::Slot>& b) {
  std::vector<core::Slot> both(a.size() + b.size());
  std::merge(a.begin(), a.end(), b.begin(), b.end(), both.begin());
  return both;
}

/// Each lane has a place of its own, and those within a rectangle have their bits.
TEST(OcclusionTest, TilesFitTheirRectangles) {
  for (int width = 1; width <= 20; ++width)
    for (int height = 1; height <= 20; ++height) {
      SCOPED_TRACE(testing::Message() << width << " x " << height);
      const culling::TileShape shape(width);
      ASSERT_EQ(shape.columns() * shape.rows(), culling::kLanes);
      ASSERT_GE(shape.columns(), std::min(width, culling::kLanes));
      ASSERT_LT(shape.columns(), 2 * width);
      for (int lane = 0; lane < culling::kLanes; ++lane) {
        ASSERT_EQ(shape.y(lane) * shape.columns() + shape.x(lane), lane);
        ASSERT_LT(shape.x(lane), shape.columns());
        const bool within = shape.x(lane) < width && shape.y(lane) < height;
        ASSERT_EQ(shape.lanes(width, height) >> lane & 1u, unsigned(within)) << "lane " << lane;
      }
    }
}

/// Where a ray meets a box that is left behind, it meets one of the front before that.
TEST(OcclusionTest, TheFrontIsWhatRaysMeetFirst) {
  std::size_t in_front = 0, left_behind = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const auto [half, origin, view] = RandomSite(random);
    const ImageSamples samples{whole(random, 1, 24), whole(random, 1, 5), {{0, 0}}};
    const ExactSamples exact(view, origin, samples);
    core::ItemBounds bounds;
    bounds.resize(24);
    for (std::size_t i = 0; i < bounds.size(); ++i)
      bounds.set(i, chance(random, 0.3) ? random_box(random, half) : box_at_a_sample(random, view, origin, samples));
    DepthPyramid pyramid;
    const auto distances = random_distances(random, samples.width, samples.height, half);
    pyramid.build(distances, samples.width, samples.height);
    const OcclusionTest test(view, origin, samples.width, samples.height, pyramid, 0.0, 0.0f);
    core::VisibleSet all, opens, front, behind;
    all.ranges = {{0, 24}};
    test.filter(bounds, all, opens);
    test.split_front(bounds, nullptr, all, front, behind);
    const auto both = merged(front.single_slots, behind.single_slots), open = opens.sorted_slots();
    ASSERT_TRUE(std::includes(open.begin(), open.end(), both.begin(), both.end()));
    const auto left_out = [&](core::Slot s) { return !std::binary_search(both.begin(), both.end(), s); };
    in_front += front.single_slots.size();
    left_behind += behind.single_slots.size();
    for (int y = 0; y < samples.height; ++y)
      for (int x = 0; x < samples.width; ++x) {
        double first = std::numeric_limits<double>::infinity();
        const double kept = distances[std::size_t(y * samples.width + x)], off = 1e-4 * half + 4e-6;
        const auto entry = [&](core::Slot s, float grown = 0.0f) {
          Aabb box = bounds.box(s);
          box.min -= grown, box.max += grown;
          const auto nearest = exact.nearest(box, x, y);
          return nearest ? nearest->get_d() : std::numeric_limits<double>::infinity();
        };
        for (const core::Slot s : front.single_slots) first = std::min(first, entry(s, float(off)));
        for (core::Slot s = 0; s < bounds.size(); ++s) {
          if (std::binary_search(front.single_slots.begin(), front.single_slots.end(), s)) continue;
          const double own = entry(s);
          if (own < kept - off && own < 1e30) {
            ASSERT_FALSE(left_out(s)) << "slot " << s << ", pixel " << x << ' ' << y;
            ASSERT_LE(first, own + off + 1e-4 * std::abs(own)) << "slot " << s << ", pixel " << x << ' ' << y;
          }
        }
      }
  }
  EXPECT_GT(in_front, 100u);
  EXPECT_GT(left_behind, 100u);
}

/// As single boxes are; what is exempt stays open. Leaves that are left out hold hidden slots alone.
TEST(OcclusionTest, FiltersSets) {
  std::uint64_t leaves_out = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const double half = 10.0;
    const std::size_t count = std::size_t(whole(random, 1, seed % 8 == 0 ? 20'000 : 900));  // several levels of nodes
    core::ItemBounds bounds;
    bounds.resize(count);
    auto boxes = random_boxes(random, count, seed % 2 == 0 ? half : 0.2 * half);
    if (seed % 2 == 0) spoil(random, boxes);
    const auto order = core::block_order(boxes);
    for (std::size_t i = 0; i < count; ++i) bounds.set(i, boxes[order[i]]);
    const View view = random_view(random, core::dvec3(0.0), half);
    const int width = whole(random, 1, 90), height = whole(random, 1, 90);
    DepthPyramid pyramid;
    pyramid.build(random_distances(random, width, height, half), width, height);
    const OcclusionTest test(view, core::dvec3(0.0), width, height, pyramid);
    const culling::Hierarchy hierarchy(bounds);
    core::VisibleSet in;
    const std::uint32_t begin = std::uint32_t(whole(random, 0, 40)) % std::uint32_t(count);
    const std::uint32_t middle = begin + std::uint32_t(4 * (count - begin) / 5);
    if (middle > begin) in.ranges = {{begin, middle - begin}};
    for (std::uint32_t s = middle; s < count; ++s)
      if (!bounds.vacant(s) && chance(random, 0.7)) in.single_slots.push_back(s);
    std::vector<std::uint64_t> exempt(count / 64 + 1);
    std::vector<core::Slot> open;
    for (const core::Slot s : in.sorted_slots()) {
      if (bounds.vacant(s)) continue;
      const bool spared = chance(random, 0.02);
      if (spared) exempt[s / 64] |= std::uint64_t(1) << s % 64;
      if (spared || !test.occluded(bounds.box(s))) open.push_back(s);
    }
    std::vector<core::Slot> first_front, first_behind;
    core::ThreadPool threads(3);
    core::VisibleSet leaves;
    for_each_instruction_set([&] {
      core::VisibleSet opens, both;
      test.filter(bounds, in, opens, exempt);
      ASSERT_EQ(opens.sorted_slots(), open);
      test.filter_leaves(hierarchy, in, leaves, exempt);
      test.filter(bounds, leaves, both, exempt);
      ASSERT_EQ(both.sorted_slots(), open);
      test.filter(bounds, in, both, exempt, &threads);
      ASSERT_EQ(both.sorted_slots(), open);
      test.filter(bounds, in, both, exempt, &threads, &hierarchy);
      ASSERT_EQ(both.sorted_slots(), open);
      core::VisibleSet front, behind;
      test.split_front(bounds, nullptr, in, front, behind);  // vacant slots included
      const auto split = merged(front.single_slots, behind.single_slots);
      ASSERT_TRUE(std::includes(open.begin(), open.end(), split.begin(), split.end()));
      for (const core::Slot s : split) ASSERT_FALSE(bounds.vacant(s));
      if (first_front.empty()) first_front = front.single_slots, first_behind = behind.single_slots;
      ASSERT_EQ(front.single_slots, first_front);
      ASSERT_EQ(behind.single_slots, first_behind);
      test.split_front(bounds, &hierarchy, in, front, behind, &threads);
      ASSERT_EQ(front.single_slots, first_front);
      ASSERT_EQ(behind.single_slots, first_behind);
    });
    leaves_out += in.count() - leaves.count();
  }
  EXPECT_GT(leaves_out, 1000u);
}

}  // namespace
}  // namespace sightline::tests::occlusion_test
