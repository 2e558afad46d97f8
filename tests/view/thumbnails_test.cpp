#include "sightline/apps/view/thumbnails.h"

#include <chrono>
#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>

namespace sightline::apps::thumbnails_test {
namespace {

namespace fs = std::filesystem;

class ThumbnailsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream(model_) << "a model";
  }
  void TearDown() override { fs::remove_all(folder_); }

  static image::Image plain(std::uint8_t grey) { return {400, 200, std::vector<std::uint8_t>(3 * 400 * 200, grey)}; }
  std::size_t count() const {
    return std::size_t(std::distance(fs::directory_iterator(folder_ / "kept"), fs::directory_iterator()));
  }
  int grey_of(const std::string& model) const {
    const auto image = thumbnails_.read(model);
    return image ? image->pixels.at(0) : -1;
  }

  fs::path folder_ =
      fs::path(testing::TempDir()) /
      ("sightline-thumbnails-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
  std::string model_ = (folder_ / "a.rvm").string();
  Thumbnails thumbnails_{folder_ / "kept"};
};

TEST_F(ThumbnailsTest, AreOfAVersion) {
  const FileState now = state_of(model_);
  EXPECT_TRUE(thumbnails_.lacks(model_, now));
  EXPECT_EQ(grey_of(model_), -1);
  ASSERT_TRUE(thumbnails_.keep(model_, now, plain(40)));
  EXPECT_FALSE(thumbnails_.lacks(model_, now));
  EXPECT_FALSE(thumbnails_.lacks((folder_ / "x" / ".." / "a.rvm").string(), now)) << "the same file";
  EXPECT_EQ(grey_of(model_), 40);
  EXPECT_EQ(thumbnails_.read(model_)->width, Thumbnails::kWidth);
  EXPECT_EQ(thumbnails_.read(model_)->height, 128);

  FileState later = now;
  later.changed += std::chrono::seconds(1);
  FileState longer = now;
  ++longer.bytes;
  EXPECT_TRUE(thumbnails_.lacks(model_, later));
  EXPECT_TRUE(thumbnails_.lacks(model_, longer));
  EXPECT_EQ(grey_of(model_), 40) << "an old one is better than none";
  ASSERT_TRUE(thumbnails_.keep(model_, later, plain(50)));
  EXPECT_EQ(grey_of(model_), 50);
  EXPECT_EQ(count(), 1u);
  EXPECT_EQ(grey_of((folder_ / "b.rvm").string()), -1);
  EXPECT_FALSE(thumbnails_.lacks((folder_ / "b.rvm").string(), {})) << "a model that is not there";
}

TEST_F(ThumbnailsTest, TheOldestAreRemovedAndNothingElse) {
  const FileState now = state_of(model_);
  fs::create_directories(folder_ / "kept");
  std::ofstream(folder_ / "kept" / "a friend's.png") << "no thumbnail";
  const auto name = [&](std::size_t i) { return (folder_ / ("m" + std::to_string(i))).string(); };
  ASSERT_TRUE(thumbnails_.keep(name(0), now, plain(1)));
  for (const auto& entry : fs::directory_iterator(folder_ / "kept"))
    fs::last_write_time(entry, entry.last_write_time() - std::chrono::hours(1));
  for (std::size_t i = 1; i < Thumbnails::kMost; ++i) ASSERT_TRUE(thumbnails_.keep(name(i), now, plain(2)));
  EXPECT_EQ(count(), Thumbnails::kMost + 1);
  EXPECT_EQ(grey_of(name(0)), 1);
  ASSERT_TRUE(thumbnails_.keep(name(Thumbnails::kMost), now, plain(2)));
  EXPECT_EQ(count(), Thumbnails::kMost + 1);
  EXPECT_EQ(grey_of(name(0)), -1);
  EXPECT_EQ(grey_of(name(Thumbnails::kMost)), 2);
}

TEST_F(ThumbnailsTest, DamageIsNone) {
  ASSERT_TRUE(thumbnails_.keep(model_, state_of(model_), plain(1)));
  const fs::path file = fs::directory_iterator(folder_ / "kept")->path();
  fs::resize_file(file, fs::file_size(file) / 2);
  EXPECT_EQ(grey_of(model_), -1);
  fs::remove(file);
  fs::remove(folder_ / "kept");
  std::ofstream(folder_ / "kept") << "a file";
  EXPECT_FALSE(thumbnails_.keep(model_, state_of(model_), plain(1)));
  EXPECT_EQ(grey_of(model_), -1);
}

TEST_F(ThumbnailsTest, WithoutAFolderThereAreNone) {
  EXPECT_FALSE(Thumbnails().lacks(model_, state_of(model_)));
  EXPECT_FALSE(Thumbnails().read(model_));
}

}  // namespace
}  // namespace sightline::apps::thumbnails_test
