// Summaries of samples: small cases by hand, and large ones against sorted samples.
#include "sightline/apps/common/statistics.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

namespace sightline::apps::statistics_test {
namespace {

TEST(Statistics, OfFewSamples) {
  EXPECT_EQ(median({}), 0.0);
  EXPECT_EQ(median({3.0}), 3.0);
  EXPECT_EQ(median({9.0, 1.0}), 5.0);
  EXPECT_EQ(median({9.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(percentile({}, 0.5), 0.0);
  EXPECT_EQ(percentile({4.0, 1.0, 3.0, 2.0}, 0.0), 1.0);
  EXPECT_EQ(percentile({4.0, 1.0, 3.0, 2.0}, 0.5), 2.0);
  EXPECT_EQ(percentile({4.0, 1.0, 3.0, 2.0}, 0.51), 3.0);
  EXPECT_EQ(percentile({4.0, 1.0, 3.0, 2.0}, 1.0), 4.0);
  EXPECT_EQ(summarise({}).max, 0.0);
}

TEST(Statistics, OfManySamples) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  for (const std::size_t count : {99u, 100u, 101u, 1000u}) {
    std::vector<double> samples, sorted;
    for (std::size_t i = 0; i < count; ++i) samples.push_back(double(random() % 500) - 250.0);
    sorted = samples;
    std::sort(sorted.begin(), sorted.end());
    const Summary s = summarise(samples);
    double sum = 0.0;
    for (const double v : samples) sum += v;
    EXPECT_DOUBLE_EQ(s.mean, sum / double(count));
    EXPECT_EQ(s.median, 0.5 * (sorted[(count - 1) / 2] + sorted[count / 2]));
    EXPECT_EQ(s.p99, sorted[(99 * count + 99) / 100 - 1]);
    EXPECT_EQ(s.max, sorted.back());
  }
}

}  // namespace
}  // namespace sightline::apps::statistics_test
