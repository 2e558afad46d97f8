// Scratch memory: each thread has its own, which is counted and can be freed while nobody uses it.
#include "sightline/core/memory.h"

#include <thread>

#include <gtest/gtest.h>

#include "sightline/core/internal/scratch.h"

namespace sightline::core::memory_test {
namespace {

constexpr std::size_t kBytes = 1 << 20;

struct Buffers {
  std::vector<char> bytes;
  std::size_t memory_bytes() const { return bytes_of(bytes); }
};
constexpr std::size_t kAll = kBytes + sizeof(Buffers);

void use() {
  const Scratch<Buffers> scratch;
  scratch->bytes.resize(kBytes);
}

TEST(Memory, AThreadKeepsScratchUntilItIsFreed) {
  free_scratch();
  const std::size_t before = scratch_bytes();
  use();
  EXPECT_EQ(scratch_bytes(), before + kAll);
  EXPECT_EQ(Scratch<Buffers>()->bytes.size(), kBytes) << "kept from the call before";
  free_scratch();
  EXPECT_EQ(scratch_bytes(), before);
  EXPECT_TRUE(Scratch<Buffers>()->bytes.empty());
  free_scratch();
}

TEST(Memory, ScratchInUseIsNotFreed) {
  free_scratch();
  use();
  const std::size_t known = scratch_bytes();
  {
    const Scratch<Buffers> scratch;
    free_scratch();
    scratch->bytes.resize(3 * kBytes);
    EXPECT_EQ(scratch_bytes(), known) << "as it was measured before";
  }
  EXPECT_EQ(scratch_bytes(), known + 2 * kBytes);
  free_scratch();
}

TEST(Memory, ScratchOfOtherThreadsCountsUntilTheyEnd) {
  free_scratch();
  const std::size_t before = scratch_bytes();
  std::thread([&] {
    use();
    std::thread([&] {
      use();
      EXPECT_EQ(scratch_bytes(), before + 2 * kAll);
      free_scratch();
    }).join();
    EXPECT_EQ(scratch_bytes(), before) << "another thread has freed it";
    use();
    EXPECT_EQ(scratch_bytes(), before + kAll);
  }).join();
  EXPECT_EQ(scratch_bytes(), before);
}

}  // namespace
}  // namespace sightline::core::memory_test
