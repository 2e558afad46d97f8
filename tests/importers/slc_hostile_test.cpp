// Scene caches that are damaged, or made to do damage.
#include <random>

#include <gtest/gtest.h>

#include "sightline/core/mesh_extras.h"
#include "sightline/importers/slc/internal/slc_scene.h"
#include "sightline/lod/stored_levels.h"
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

/// Levels are read later than the rest.
bool has_whole_levels(const core::Scene& scene) {
  for (std::uint32_t i = 0; i < scene.mesh_slots(); ++i)
    if (const core::MeshId id = scene.mesh_at(i); id.valid() && core::bytes_stored_with(scene.mesh(id)))
      if (!core::bytes_stored_with(scene.mesh(id))->bytes()) return false;
  return true;
}

TEST(SlcHostile, EveryByteOfLevelsChangedInTurnIsFound) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no levels in this build";
  const auto whole = tests::slc_of(tests::scene_with_levels(), true);
  const auto undamaged = *SlcFile::of_bytes(whole);
  std::vector<std::byte> bytes = whole;
  std::mt19937 random(5);
  for (const SlcFile::Section& section : undamaged->sections()) {
    if (section.number < kSlcLevelsVersion || section.number > kSlcLevelValues) continue;
    const std::uint64_t size = section.count * section.element_size;
    for (std::uint64_t i = 0; i < size; i += size < 1000 || tests::long_run() ? 1 : 97) {
      std::byte& byte = bytes[std::size_t(section.offset + i)];
      byte ^= std::byte(1u << random() % 8);
      const auto file = SlcFile::of_bytes(bytes);
      const auto loaded = load(*file);
      EXPECT_FALSE(loaded && has_whole_levels(loaded->scene)) << "byte " << i << " of " << section.number;
      byte = whole[std::size_t(section.offset + i)];
    }
  }
}

/// Rows of levels that lead elsewhere.
TEST(SlcHostile, RowsOfLevelsAreChecked) {
  if (!lod::builds_levels()) GTEST_SKIP() << "no levels in this build";
  const auto whole = tests::slc_of(tests::scene_with_levels(), true);
  const std::uint64_t rows = (*SlcFile::of_bytes(whole))->find(kSlcLevels)->offset;
  const auto is_refused = [&](std::size_t word, std::uint64_t value) {
    std::vector<std::byte> bytes = whole;
    std::memcpy(bytes.data() + rows + 8 * word, &value, sizeof value);
    return !load(*SlcFile::of_bytes(bytes), false);
  };
  std::uint64_t bytes[64] = {};
  std::memcpy(bytes, whole.data() + rows, sizeof bytes);
  std::size_t with = 0;
  while (with < 60 && bytes[with + 1] == 0) with += 3;
  ASSERT_LT(with, 60u);
  EXPECT_FALSE(is_refused(with, bytes[with]));
  EXPECT_TRUE(is_refused(with, ~std::uint64_t(0)));
  EXPECT_TRUE(is_refused(with + 1, ~std::uint64_t(0)));
  EXPECT_TRUE(is_refused(with + 1, bytes[with + 1] + 1)) << "bytes of the next one, too";
  EXPECT_TRUE(is_refused(1, 1)) << "of a mesh that has none";
}

TEST(SlcHostile, SurfacesAreChecked) {
  const auto whole = tests::slc_of(tests::scene_with_surfaces());
  const auto file = *SlcFile::of_bytes(whole);
  const SlcFile::Section *ends = file->find(kSlcSurfaceEnds), *rows = file->find(kSlcSurfaces);
  const auto is_refused = [&](std::uint64_t at, const auto& value) {
    std::vector<std::byte> bytes = whole;
    std::memcpy(bytes.data() + at, &value, sizeof value);
    return !load(*SlcFile::of_bytes(bytes), false);
  };
  EXPECT_FALSE(is_refused(rows->offset, std::uint32_t(1)));
  EXPECT_TRUE(is_refused(rows->offset, std::uint32_t(6))) << "a kind that there is not";
  EXPECT_TRUE(is_refused(rows->offset + 4, std::uint32_t(3))) << "triangles that do not rise";
  EXPECT_TRUE(is_refused(rows->offset + 8, std::numeric_limits<double>::quiet_NaN()));
  EXPECT_TRUE(is_refused(ends->offset, std::uint64_t(3)));
  EXPECT_TRUE(is_refused(ends->offset + 8 * (ends->count - 1), ~std::uint64_t(0)));
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
  const auto whole = tests::slc_of(tests::scene_with_levels(), lod::builds_levels());
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
