// Scene caches that are damaged, or made to do damage.
#include <random>

#include <gtest/gtest.h>

#include "sightline/core/snapshot.h"
#include "sightline/importers/slc/internal/slc_scene.h"
#include "sightline/tests/importers/hostile.h"
#include "sightline/tests/importers/slc_bytes.h"

namespace sightline::importers::slc_hostile_test {
namespace {

using tests::reseal;

// The file is copied, each mapping is a copy, and what is read from it is little more.
constexpr std::size_t kFactor = 16, kConstant = 1 << 20;

/// Reads with and without comparing checksums. True when the checksums hold.
bool survives(std::span<const std::byte> bytes) {
  const bool good = tests::survives(
      bytes,
      [](std::span<const std::byte> content, core::Scene& scene, core::NodeId parent) {
        auto report = read_slc(content, "hostile.slc", scene, parent, {});
        if (report && scene.commit()) {  // what is read may be used
          const core::Snapshot snapshot(scene);
          EXPECT_EQ(snapshot.size(), scene.item_count());
          scene.for_each_node(scene.root(), [&](core::NodeId node, auto&&...) {
            (void)scene.path(node);
            (void)scene.attributes(node);
          });
        }
        return report;
      },
      kFactor, kConstant);
  const auto file = SlcFile::of_bytes(bytes);
  if (!file) {
    EXPECT_FALSE(good);
    return false;
  }
  if (const auto paged = open_paged_scene(*file, "hostile.slc", false))
    for (std::uint32_t page = 0; page < paged->pages.size(); ++page)
      if (const auto read = paged->load(page))
        for (core::Slot slot = 0; slot < (*read)->snapshot.size(); ++slot)
          (void)(*read)->snapshot.world_from_item(slot);
  auto loaded = load(*file);
  if (!loaded) return false;
  // As the only scene, with the stored snapshot.
  core::Scene scene;
  scene.append(scene.root(), std::move(loaded->scene));
  EXPECT_TRUE(scene.commit());
  EXPECT_EQ(core::Snapshot(scene).size(), scene.item_count());
  return true;
}

TEST(SlcHostile, EveryByteChangedInTurnIsFound) {
  const auto whole = tests::slc_of(tests::scene_with_everything());
  ASSERT_TRUE(survives(whole));
  std::vector<std::byte> bytes = whole;
  std::mt19937 random(5);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] ^= std::byte(1u << random() % 8);
    const auto file = SlcFile::of_bytes(bytes);
    EXPECT_FALSE(file && load(*file)) << "byte " << i;
    bytes[i] = whole[i];
  }
}

TEST(SlcHostile, EveryTruncationIsFound) {
  const auto whole = tests::slc_of(tests::scene_with_everything());
  for (std::size_t size = 0; size < whole.size(); ++size)
    ASSERT_FALSE(SlcFile::of_bytes(std::span(whole).first(size))) << size;
  auto longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_FALSE(SlcFile::of_bytes(longer));
}

TEST(SlcHostile, TruncationsWithRightChecksums) {
  const auto whole = tests::slc_of(tests::scene_with_everything());
  for (std::size_t size = 0; size < whole.size(); size += 97) {
    std::vector<std::byte> bytes(whole.begin(), whole.begin() + std::ptrdiff_t(size));
    reseal(bytes);
    EXPECT_FALSE(survives(bytes));
  }
}

TEST(SlcHostile, ChangesThatGetPastTheChecksums) {
  const auto whole = tests::slc_of(tests::scene_with_everything());
  std::mt19937 random(17);
  const std::uint32_t extremes[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x7fc00000, 0x7f800000, 255, 9, 12, 40};
  int accepted = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<std::byte> bytes = whole;
    for (int changes = 1 + int(random() % 3); changes > 0; --changes) {
      const std::size_t at = random() % (bytes.size() / 4) * 4;
      const std::uint32_t value = round % 2 == 0 ? extremes[random() % std::size(extremes)] : std::uint32_t(random());
      std::memcpy(bytes.data() + at, &value, round % 3 == 0 ? 1 : 4);
    }
    reseal(bytes);
    const auto file = SlcFile::of_bytes(bytes);
    accepted += file.has_value();
    (void)survives(bytes);
  }
  EXPECT_GT(accepted, 1000);
}

TEST(SlcHostile, AbsurdCountsInTheTable) {
  const auto whole = tests::slc_of(tests::scene_with_everything());
  std::uint64_t table = 0, words = 0;
  std::memcpy(&table, whole.data() + whole.size() - 64, 8);
  std::memcpy(&words, whole.data() + whole.size() - 56, 8);
  words /= 8;
  for (std::uint64_t word = 0; word < words; ++word)
    for (const std::uint64_t value :
         {std::uint64_t(0), std::uint64_t(1), std::uint64_t(1) << 32, std::uint64_t(1) << 61, ~std::uint64_t(0)}) {
      std::vector<std::byte> bytes = whole;
      std::memcpy(bytes.data() + table + 8 * word, &value, 8);
      reseal(bytes);
      (void)survives(bytes);
    }
}

TEST(SlcHostile, OtherVersionsAreNamed) {
  const auto whole = tests::slc_of(tests::scene_with_everything());
  const auto problem_after = [&](std::size_t at, std::uint32_t value) {
    std::vector<std::byte> bytes = whole;
    std::memcpy(bytes.data() + at, &value, 4);
    reseal(bytes);
    const auto file = SlcFile::of_bytes(bytes);
    return file ? SlcProblem{} : file.error();
  };
  const SlcProblem version = problem_after(8, kSlcVersion + 1), order = problem_after(12, 0x04030201),
                   layout = problem_after(16, 12345);
  for (const SlcProblem& problem : {version, order, layout})
    EXPECT_EQ(problem.kind, SlcProblem::Kind::kOtherVersion) << problem.message;
  EXPECT_EQ(version.message, "format version 3, expected 2");
  EXPECT_NE(order.message.find("byte order"), std::string::npos);
  EXPECT_NE(layout.message.find("layout"), std::string::npos);
}

}  // namespace
}  // namespace sightline::importers::slc_hostile_test
