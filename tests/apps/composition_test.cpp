// The operator by which images of parts meet, against a plain loop.
#include "sightline/apps/mpi/composition.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sightline::tests::composition_test {
namespace {

using apps::Fragment;
using Fragments = std::vector<Fragment>;

bool same(const Fragment& a, const Fragment& b) {
  return a.depth == b.depth && a.order == b.order && a.id == b.id && a.colour == b.colour;
}

/// Few depths and orders, so that ties are frequent. An order has one id and one colour, as an item in one pixel has.
Fragment random_fragment(std::mt19937& random) {
  if (random() % 4 == 0) return {0.0f, 0xffffffff, 0, 0xdee3eb};
  const std::uint32_t order = std::uint32_t(random() % 5) + (random() % 8 == 0 ? 0xfffffff0u : 0u);
  constexpr float kDepths[] = {1e-38f, 0.25f, 0.25000003f, 0.5f, 1.0f};
  return {kDepths[random() % 5], order, order + 7, order * 1000};
}

/// What shows of all, found with a plain loop: the nearest, of several nearest that of the lowest order.
Fragment nearest(const std::vector<Fragments>& parts, std::size_t pixel) {
  float depth = 0.0f;
  for (const Fragments& part : parts) depth = std::max(depth, part[pixel].depth);
  const Fragment* best = nullptr;
  for (const Fragments& part : parts)
    if (part[pixel].depth == depth && (!best || part[pixel].order < best->order)) best = &part[pixel];
  return *best;
}

TEST(Composition, IsTheNearestHoweverPartsAreGroupedAndOrdered) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const std::size_t pixels = 1 + random() % 50;
    std::vector<Fragments> parts(1 + random() % 7, Fragments(pixels));
    for (Fragments& part : parts)
      for (Fragment& f : part) f = random_fragment(random);
    // Any two neighbours meet next, in either direction, as in any tree that MPI may choose.
    std::vector<Fragments> left = parts;
    std::shuffle(left.begin(), left.end(), random);
    while (left.size() > 1) {
      const std::size_t a = random() % left.size();
      std::size_t b = random() % left.size();
      if (a == b) continue;
      apps::compose(left[a], left[b]);
      left.erase(left.begin() + std::ptrdiff_t(a));
    }
    for (std::size_t i = 0; i < pixels; ++i) EXPECT_TRUE(same(left[0][i], nearest(parts, i))) << i;
  }
}

TEST(Composition, CommutesAndAssociates) {
  std::mt19937 random(7);
  const auto of = [](Fragment a, const Fragment& b) {
    apps::compose({&b, 1}, {&a, 1});
    return a;
  };
  for (int i = 0; i < 100'000; ++i) {
    const Fragment a = random_fragment(random), b = random_fragment(random), c = random_fragment(random);
    ASSERT_TRUE(same(of(a, b), of(b, a)));
    ASSERT_TRUE(same(of(of(a, b), c), of(a, of(b, c))));
    ASSERT_TRUE(same(of(a, a), a));
  }
}

TEST(Composition, TheBackgroundIsBehindAll) {
  const Fragment background{0.0f, 0xffffffff, 0, 1}, far{1e-45f, 4, 5, 2};
  EXPECT_TRUE(apps::hides(far, background));
  EXPECT_FALSE(apps::hides(background, far));
  EXPECT_FALSE(apps::hides(background, background));
}

}  // namespace
}  // namespace sightline::tests::composition_test
