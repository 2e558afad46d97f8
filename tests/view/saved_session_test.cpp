#include "sightline/apps/view/saved_session.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace sightline::apps::saved_session_test {
namespace {

namespace fs = std::filesystem;

class SavedSessionTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "models");
    for (const char* name : {"a ü.rvm", "older.rvm"}) std::ofstream(folder_ / "models" / name) << "a";
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string error(const std::string& text) const {
    std::ofstream(folder_ / "bad.sightline") << text;
    const auto read = read_session(folder_ / "bad.sightline");
    return read ? "none" : read.error().message.substr((folder_ / "bad.sightline").string().size());
  }

  fs::path folder_ = fs::path(testing::TempDir()) / "saved_session";
};

SavedSession session_of(const fs::path& model) {
  SavedSession session;
  session.files = {model.string()};
  session.y_up = true;
  session.reading.lenient = true;
  session.older = (model.parent_path() / "older.rvm").string();
  session.now.pose = {{1, 2, 3}, {4, 5, 6}};
  session.now.sections = {{{0, 0, 1}, -2.0}};
  session.now.colour_by = "System";
  session.now.shown.emplace().hidden.parts = {{"a/b", 1, 2, ""}};
  session.now.measurements = {{{0, 0, 0}, {1, 0, 0}, "a corner to a corner"}};
  session.views = {session.now, session.now};
  session.views[1].name = "second";
  session.current = 1;
  return session;
}

TEST_F(SavedSessionTest, ComesBackAndMovesWithItsFolder) {
  const SavedSession written = session_of(folder_ / "models" / "a ü.rvm");
  ASSERT_TRUE(write_session(written, folder_ / "s.sightline"));
  auto read = read_session(folder_ / "s.sightline");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->files, written.files);
  EXPECT_TRUE(read->y_up);
  EXPECT_FALSE(read->reading.recognise);
  EXPECT_TRUE(read->reading.lenient);
  EXPECT_EQ(read->older, written.older);
  EXPECT_EQ(read->now.pose.eye, written.now.pose.eye);
  EXPECT_EQ(read->now.colour_by, "System");
  EXPECT_EQ(read->now.measurements, written.now.measurements);
  ASSERT_TRUE(read->now.shown);
  EXPECT_EQ(read->now.shown->hidden, written.now.shown->hidden);
  ASSERT_EQ(read->views.size(), 2u);
  EXPECT_EQ(read->views[1].name, "second");
  EXPECT_EQ(read->current, 1);
  // The folder goes elsewhere.
  const fs::path moved = folder_ / "moved";
  fs::create_directories(moved);
  fs::rename(folder_ / "models", moved / "models");
  fs::rename(folder_ / "s.sightline", moved / "s.sightline");
  read = read_session(moved / "s.sightline");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(fs::equivalent(read->files[0], moved / "models" / "a ü.rvm"));
  EXPECT_TRUE(fs::equivalent(read->older, moved / "models" / "older.rvm"));
  fs::remove(moved / "models" / "older.rvm");
  read = read_session(moved / "s.sightline");
  ASSERT_TRUE(read) << "without the older revision";
  EXPECT_EQ(read->older, "");
  fs::remove_all(moved / "models");
  EXPECT_FALSE(read_session(moved / "s.sightline"));
}

TEST_F(SavedSessionTest, SaysWhatIsWrong) {
  EXPECT_EQ(error("{").find(": byte "), 0u);
  EXPECT_EQ(error("[]"), ": expected a session with files and a view");
  EXPECT_EQ(error(R"({"sightline_session":1,"files":[],"view":{}})"), ": expected a session with files and a view");
  EXPECT_EQ(error(R"({"sightline_session":1,"files":["a"],"view":{}})"), ": /files: expected objects with a \"path\"");
  EXPECT_EQ(error(R"({"sightline_session":1,"files":[{"path":"/none/x.rvm"}],"view":{}})"),
            ": /none/x.rvm: is no longer there");
  const std::string model = "\"" + (folder_ / "models" / "a ü.rvm").generic_string() + "\"";
  EXPECT_NE(error(R"({"sightline_session":1,"files":[{"path":)" + model + R"(}],"view":{"eye":1}})").find("/view"),
            std::string::npos);
  EXPECT_FALSE(read_session(folder_ / "none.sightline"));
  EXPECT_FALSE(read_session(folder_));
}

}  // namespace
}  // namespace sightline::apps::saved_session_test
