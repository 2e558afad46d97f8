// Settings of the viewer: what is kept comes back, what others have written stays, and damage is said and survived.
#include "sightline/apps/view/settings.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "sightline/importers/json/internal/json.h"
#include "sightline/tests/support/environment.h"

namespace sightline::apps::settings_test {
namespace {

namespace fs = std::filesystem;
using Json = json::Value;

/// An absolute name, as the system has them.
std::string rooted(const std::string& name) {
  return (fs::temp_directory_path().root_path() / name).make_preferred().string();
}

class SettingsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("sightline-settings-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    file_ = folder_ / "sightline" / "view.json";
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& text) const {
    fs::create_directories(file_.parent_path());
    std::ofstream(file_, std::ios::binary) << text;
  }
  std::string read() const {
    std::ostringstream text;
    text << std::ifstream(file_, std::ios::binary).rdbuf();
    return text.str();
  }

  fs::path folder_, file_;
};

TEST_F(SettingsTest, ComeBack) {
  SettingsFile file(file_);
  EXPECT_EQ(file.settings(), Settings());
  EXPECT_EQ(file.damage(), "");
  ASSERT_TRUE(file.keep(Settings()));
  EXPECT_FALSE(fs::exists(file_)) << "nothing has changed";
  const Settings wanted{true,
                        false,
                        false,
                        false,
                        false,
                        false,
                        false,
                        false,
                        12.5f,
                        30.0f,
                        {rooted("a/b.rvm"), rooted("ü \"c\".obj")},
                        {800, 601},
                        rooted("caches"),
                        Units::kFeet,
                        true,
                        true,
                        SelectionLevel::kAssembly,
                        2700.0,
                        {"System=CW & DN>=100", "PIPE"}};
  ASSERT_TRUE(file.keep(wanted));
  const SettingsFile again(file_);
  EXPECT_EQ(again.settings(), wanted);
  EXPECT_EQ(again.damage(), "");
  int files = 0;
  for (const auto& entry : fs::directory_iterator(file_.parent_path())) files += entry.is_regular_file();
  EXPECT_EQ(files, 1) << "no temporary file stays";
}

TEST_F(SettingsTest, WriteOnlyWhatHasChanged) {
  write(R"({"later": {"x": [1, 2]}, "theme": "light", "window": [640, 480]})");
  SettingsFile file(file_);
  Settings now = file.settings();
  now.light = false;  // by a command line
  file.begin(now);
  ASSERT_TRUE(file.keep(now));
  now.panels = false;
  write(
      R"({"later": {"x": [1, 2]}, "theme": "light", "window": [641, 480], "recent": ["/theirs"]})");  // another viewer
  now.add_recent(rooted("ours"));
  ASSERT_TRUE(file.keep(now));
  Json expected =
      json::parse(R"({"later": {"x": [1, 2]}, "theme": "light", "window": [641, 480], "panels": false})").value();
  expected["recent"] = Json::array({rooted("ours"), "/theirs"});
  EXPECT_EQ(json::parse(read()).value(), expected);
}

TEST_F(SettingsTest, DamageIsSaidAndStaysUntilSomethingChanges) {
  const std::string deep(100000, '[');
  for (const std::string& text : {std::string(), std::string("{\"theme\": \"li"), std::string("[1]"), deep,
                                  "{\"deep\": " + deep + std::string(100000, ']') + "}", std::string(2 << 20, ' ')}) {
    SCOPED_TRACE(text.substr(0, 20));
    write(text);
    SettingsFile file(file_);
    EXPECT_EQ(file.settings(), Settings());
    EXPECT_NE(file.damage().find(file_.string()), std::string::npos) << file.damage();
    ASSERT_TRUE(file.keep(file.settings()));
    EXPECT_EQ(read(), text);
    Settings now = file.settings();
    now.light = true;
    ASSERT_TRUE(file.keep(now));
    EXPECT_EQ(json::parse(read()).value(), json::parse(R"({"theme": "light"})").value());
  }
}

TEST_F(SettingsTest, ABadValueCountsAsMissing) {
  write(
      R"({"theme": "blue", "smooth": 1, "panels": false, "recent": ["/a", 2], "window": [1e9, 200], "cache": "caches",
         "recognise": "yes"})");
  const SettingsFile file(file_);
  Settings wanted;
  wanted.panels = false;
  EXPECT_EQ(file.settings(), wanted);
  for (const char* key : {"theme", "smooth", "recent", "window", "cache", "recognise"})
    EXPECT_NE(file.damage().find(key), std::string::npos) << file.damage();
  for (const char* window :
       {"[100]", "[99, 200]", "[-300, 200]", "[300.5, 200]", "[18446744073709551615, 200]", "{}"}) {
    write(std::string(R"({"window": )") + window + "}");
    EXPECT_EQ(SettingsFile(file_).settings(), Settings()) << window;
    EXPECT_NE(SettingsFile(file_).damage(), "") << window;
  }
}

TEST_F(SettingsTest, TheLastFilesAreKnownOnceEach) {
  Settings settings;
  for (int i = 0; i < 30; ++i) settings.add_recent(rooted("m/" + std::to_string(i % 12) + ".rvm"));
  ASSERT_EQ(settings.recent.size(), Settings::kMostRecent);
  for (std::size_t i = 0; i < settings.recent.size(); ++i)
    EXPECT_EQ(settings.recent[i], rooted("m/" + std::to_string((29 - i) % 12) + ".rvm"));
  settings.add_recent("x/../b.obj");
  EXPECT_EQ(settings.recent[0], (fs::current_path() / "b.obj").string());
}

TEST_F(SettingsTest, WhatCannotBeWrittenIsAnErrorOnce) {
  SettingsFile file(file_);
  write("");
  fs::remove(file_);
  fs::create_directory(file_);
  Settings now;
  now.light = true;
  EXPECT_FALSE(file.keep(now));
  EXPECT_TRUE(file.keep(now));
  SettingsFile none;
  now.light = false;
  EXPECT_TRUE(none.keep(now));
}

TEST_F(SettingsTest, LieWhereTheUserKeepsThem) {
  const fs::path c = fs::temp_directory_path() / "c", h = fs::temp_directory_path() / "h";
  const auto with = [](const std::optional<std::string>& config, const fs::path& home) {
    const auto within = [&](const char* folder) {
      return home.empty() ? std::nullopt : std::optional((home / folder).string());
    };
    const tests::Variable xdg("XDG_CONFIG_HOME", config), user("HOME", within("")),
        windows("APPDATA", within(".config"));
    return SettingsFile::default_place();
  };
  EXPECT_EQ(with(c.string(), h), c / "sightline/view.json");
  EXPECT_EQ(with("relative", h), h / ".config/sightline/view.json");
  EXPECT_EQ(with(std::nullopt, h), h / ".config/sightline/view.json");
  EXPECT_EQ(with("", {}), "");
}

}  // namespace
}  // namespace sightline::apps::settings_test
