// The structure of hierarchies for rays.
#include "sightline/raytrace/internal/wide_tree.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

#include <gtest/gtest.h>

#include "sightline/raytrace/internal/kernels.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::raytrace::wide_tree_test {
namespace {

using tests::Random;
using tests::uniform;

enum class Shape { kSpread, kOnePlace, kDoubling, kPlane };

std::vector<BoxRef> boxes_of(Shape shape, std::size_t count, Random& random) {
  std::vector<BoxRef> refs(count);
  for (std::size_t i = 0; i < count; ++i) {
    refs[i].id = std::uint32_t(i);
    for (int axis = 0; axis < 3; ++axis) {
      float at = float(uniform(random, -1.0, 1.0));
      if (shape == Shape::kOnePlace) at = 0.25f;
      if (shape == Shape::kDoubling) at = std::ldexp(1.0f, int(i % 200) - 100);
      if (shape == Shape::kPlane && axis == 2) at = 3.0f;
      refs[i].low[axis] = at;
      refs[i].high[axis] = shape == Shape::kOnePlace ? at : at + 0.01f * float(uniform(random, 0.0, 1.0));
    }
  }
  return refs;
}

/// Checks boxes, parents and leaves below a node. Returns its levels.
int check_below(const BuiltTree& tree, std::uint32_t index, std::uint32_t parent, const std::vector<BoxRef>& refs,
                std::vector<int>& seen) {
  const WideNode& node = tree.nodes[index];
  EXPECT_EQ(node.parent, parent);
  int levels = 0;
  bool ended = false;
  for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
    const std::uint32_t child = node.children[lane];
    if (child == core::kNone) {
      ended = true;
      EXPECT_GT(node.bounds[0][lane], node.bounds[3][lane]);
      continue;
    }
    EXPECT_FALSE(ended) << "unused lanes come last";
    float low[3] = {3e38f, 3e38f, 3e38f}, high[3] = {-3e38f, -3e38f, -3e38f};
    if ((child & kLeafBit) != 0) {
      const LeafRange leaf = tree.leaves[child & ~kLeafBit];
      for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
        ++seen[refs[i].id];
        for (int axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], refs[i].low[axis]);
          high[axis] = std::max(high[axis], refs[i].high[axis]);
        }
      }
    } else {
      levels = std::max(levels, check_below(tree, child, index * kLanes + lane, refs, seen));
      for (std::uint32_t i = 0; i < kLanes; ++i)
        for (int axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], tree.nodes[child].bounds[axis][i]);
          high[axis] = std::max(high[axis], tree.nodes[child].bounds[axis + 3][i]);
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(node.bounds[axis][lane], low[axis]);
      EXPECT_EQ(node.bounds[axis + 3][lane], high[axis]);
    }
  }
  return levels + 1;
}

TEST(WideTree, HoldsEveryBoxOnceWithinItsDepth) {
  for (const Shape shape : {Shape::kSpread, Shape::kOnePlace, Shape::kDoubling, Shape::kPlane})
    for (const std::size_t count : {2u, 7u, 100u, 20'000u})
      for (const std::uint32_t largest_leaf : {1u, 8u}) {
        SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", " << count << " boxes, leaves of "
                                        << largest_leaf);
        Random random(1);
        std::vector<BoxRef> refs = boxes_of(shape, count, random);
        const BuiltTree tree = build_wide_tree(refs, largest_leaf, 2);
        for (const LeafRange& leaf : tree.leaves) EXPECT_LE(leaf.count, largest_leaf);
        if (count <= largest_leaf) {
          EXPECT_EQ(tree.leaves.size(), 1u);
          continue;
        }
        std::vector<int> seen(count);
        EXPECT_LE(check_below(tree, 0, core::kNone, refs, seen), kMostLevels);
        EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), std::ptrdiff_t(count));
      }
}

TEST(WideTree, DoesNotDependOnThreads) {
  Random random(2);
  const std::vector<BoxRef> boxes = boxes_of(Shape::kSpread, 50'000, random);
  std::vector<BoxRef> a = boxes, b = boxes;
  const BuiltTree one = build_wide_tree(a, 8, 1), four = build_wide_tree(b, 8, 4);
  ASSERT_EQ(one.nodes.size(), four.nodes.size());
  for (std::size_t i = 0; i < one.nodes.size(); ++i)
    for (int lane = 0; lane < kLanes; ++lane) ASSERT_EQ(one.nodes[i].children[lane], four.nodes[i].children[lane]);
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(a[i].id, b[i].id);
}

/// A stop may come anywhere: then the result says nothing, and else it is right.
TEST(WideTree, MayBeStopped) {
  Random random(4);
  const std::vector<BoxRef> boxes = boxes_of(Shape::kSpread, 200'000, random);
  int stopped = 0, complete = 0;
  for (int round = 0; round < 40; ++round) {
    std::vector<BoxRef> refs = boxes;
    std::stop_source stop;
    if (round == 0) stop.request_stop();
    std::jthread stopper([&, us = round * round * 100] {
      std::this_thread::sleep_for(std::chrono::microseconds(us));
      stop.request_stop();
    });
    const BuiltTree tree = build_wide_tree(refs, 1, 2, 0, stop.get_token());
    if (stop.stop_requested()) {
      ++stopped;
      continue;
    }
    ++complete;
    std::vector<int> seen(refs.size());
    check_below(tree, 0, core::kNone, refs, seen);
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), std::ptrdiff_t(refs.size()));
  }
  EXPECT_GT(stopped, 0);
  std::printf("%d stopped, %d complete\n", stopped, complete);
}

TEST(WideTree, NothingIsAnEmptyTree) {
  const BuiltTree tree = build_wide_tree({}, 8, 1);
  EXPECT_TRUE(tree.nodes.empty());
  EXPECT_TRUE(tree.leaves.empty());
}

}  // namespace
}  // namespace sightline::raytrace::wide_tree_test
