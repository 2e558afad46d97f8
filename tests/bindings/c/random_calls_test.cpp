// Random sequences of calls: every call gives what its handles' liveness demands, and nothing else happens. Under a
// sanitizer they show that nothing is undefined. A failure names the seed; each sequence is a seed's own.
#include "random_calls.h"

#include <cstdio>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace sightline::tests::random_calls_test {
namespace {

constexpr unsigned kFirstSeed = 1, kSequences = 100;
constexpr std::size_t kBytes = 20'000;

TEST(CapiRandomCalls, KeepTheirPromises) {
  for (unsigned seed = kFirstSeed; seed < kFirstSeed + kSequences; ++seed) {
    if (seed % 16 == kFirstSeed) {
      std::printf("from seed %u on\n", seed);  // for what ends the process
      std::fflush(stdout);
    }
    std::mt19937 random(seed);
    std::vector<std::uint8_t> bytes(kBytes);
    for (std::uint8_t& byte : bytes) byte = std::uint8_t(random());
    ASSERT_EQ(make_random_calls(bytes.data(), bytes.size()), "") << "seed " << seed;
  }
}

}  // namespace
}  // namespace sightline::tests::random_calls_test
