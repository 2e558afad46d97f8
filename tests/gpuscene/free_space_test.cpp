// Places for runs of units, against a twin that marks every unit.
#include "sightline/gpuscene/internal/free_space.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sightline::free_space_test {
namespace {

using gpuscene::FreeSpace;

struct Taken {
  std::uint32_t first, count;
};

/// Takes the first of the smallest gaps that have room, as the class promises, by looking at all units.
class Twin {
 public:
  std::uint32_t take(std::uint32_t count) {
    std::size_t best = taken_.size(), best_count = ~std::size_t(0);
    for (std::size_t i = 0; i < taken_.size();) {
      std::size_t end = i;
      while (end < taken_.size() && !taken_[end]) ++end;
      if (end - i >= count && end - i < best_count) best = i, best_count = end - i;
      i = end + 1;
    }
    taken_.resize(std::max(taken_.size(), best + count));
    std::fill_n(taken_.begin() + std::ptrdiff_t(best), count, true);
    return std::uint32_t(best);
  }
  void give_back(const Taken& run) {
    for (std::uint32_t i = run.first; i < run.first + run.count; ++i) {
      EXPECT_TRUE(taken_[i]);
      taken_[i] = false;
    }
    while (!taken_.empty() && !taken_.back()) taken_.pop_back();
  }
  std::size_t end() const { return taken_.size(); }

 private:
  std::vector<bool> taken_;
};

TEST(FreeSpace, PlacesRunsAsATwinDoes) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    FreeSpace space;
    Twin twin;
    std::vector<Taken> runs;
    for (int i = 0; i < 4000; ++i) {
      const bool grows = random() % (i / 500 % 2 == 0 ? 3 : 4) > (i / 500 % 2 == 0 ? 0u : 2u);
      if (grows || runs.empty()) {
        const auto count = std::uint32_t(1 + random() % (1u << random() % 6));
        runs.push_back({space.take(count), count});
        ASSERT_EQ(runs.back().first, twin.take(count)) << i;
      } else {
        std::swap(runs[random() % runs.size()], runs.back());
        space.give_back(runs.back().first, runs.back().count);
        twin.give_back(runs.back());
        runs.pop_back();
      }
      ASSERT_EQ(space.end(), twin.end()) << i;
    }
  }
}

TEST(FreeSpace, OfNothingTakesNothing) {
  FreeSpace space;
  space.give_back(space.take(0), 0);
  EXPECT_EQ(space.end(), 0u);
  EXPECT_EQ(space.take(3), 0u);
  space.give_back(space.take(0), 0);
  EXPECT_EQ(space.take(2), 3u);
  space.give_back(0, 3);
  space.give_back(3, 2);
  EXPECT_EQ(space.end(), 0u) << "all that was taken is back";
}

}  // namespace
}  // namespace sightline::free_space_test
