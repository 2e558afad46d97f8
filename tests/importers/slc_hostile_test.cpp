// Scene caches that are damaged, or made to do damage.
#include <random>

#include <gtest/gtest.h>

#include "sightline/importers/slc/internal/slc_scene.h"
#include "sightline/tests/importers/hostile.h"
#include "sightline/tests/importers/slc_bytes.h"
#include "sightline/tests/support/effort.h"

namespace sightline::importers::slc_hostile_test {
namespace {

using tests::reseal;

hostile::Case cache(std::span<const std::byte> bytes) {
  return hostile::one_file("model.slc", hostile::text_of(bytes));
}

TEST(SlcHostile, EveryByteChangedInTurnIsFound) {
  const auto whole = tests::slc_of(tests::scene_with_everything());
  ASSERT_TRUE(tests::survives(hostile::target_of("slc"), cache(whole), false, "model.slc"));
  std::vector<std::byte> bytes = whole;
  std::mt19937 random(5);
  for (std::size_t i = 0; i < bytes.size(); i += tests::long_run() ? 1 : 10) {
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

/// Seeds of the table (hostile_test.cpp) hold less than this scene, and hardly any change of them is found at once.
TEST(SlcHostile, ChangesThatGetPastTheChecksums) {
  const auto whole = tests::slc_of(tests::scene_with_everything());
  const hostile::Target target = hostile::target_of("slc");
  const hostile::Attack attack = hostile::mutation(target, {hostile::text_of(whole)});
  const int rounds = tests::repeated(3000);
  int accepted = 0;
  for (int round = 0; round < rounds; ++round) {
    const hostile::Case made = attack.make(std::size_t(round));
    accepted += SlcFile::of_bytes(std::as_bytes(std::span(made.files[0].content))).has_value();
    tests::survives_both(target, made, "model.slc");
  }
  EXPECT_GT(accepted, rounds / 5);
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
