#include "sightline/apps/view/file_states.h"

#include <fstream>

#include <gtest/gtest.h>

namespace sightline::apps::file_states_test {
namespace {

TEST(FileStates, AreAskedForSeldom) {
  double now = 0.0;
  int asked = 0;
  FileStates states([&] { return now; }, [&](const std::filesystem::path&) { return ++asked, FileState{true, 5, {}}; });
  for (int i = 0; i < 3; ++i) EXPECT_EQ(states.of("a").bytes, 5u);
  EXPECT_EQ(asked, 1);
  states.of("b");
  EXPECT_EQ(asked, 2);
  now = 0.9 * FileStates::kSeconds;
  states.of("a");
  EXPECT_EQ(asked, 2);
  now = 1.1 * FileStates::kSeconds;
  states.of("a");
  states.of("a");
  EXPECT_EQ(asked, 3);
}

TEST(FileStates, TellSizesAndWhatIsGone) {
  const auto file = std::filesystem::path(testing::TempDir()) / "sightline-file-state";
  std::ofstream(file, std::ios::binary) << "12345";
  EXPECT_TRUE(state_of(file).there);
  EXPECT_EQ(state_of(file).bytes, 5u);
  EXPECT_EQ(state_of(file).changed, std::filesystem::last_write_time(file));
  EXPECT_TRUE(state_of(file.parent_path()).there);
  EXPECT_EQ(state_of(file.parent_path()).bytes, 0u);
  std::filesystem::remove(file);
  EXPECT_FALSE(state_of(file).there);
}

}  // namespace
}  // namespace sightline::apps::file_states_test
