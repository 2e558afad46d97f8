#include "sightline/apps/view/file_browser.h"

#include <algorithm>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/import.h"

namespace sightline::apps::file_browser_test {
namespace {

namespace fs = std::filesystem;

using Choose = FileBrowser::Choose;
using Names = std::vector<std::string>;
using Purpose = FileRequest::Purpose;

const std::vector<FileFormat> kModels{{"RVM", {".rvm", ".rev"}}, {"glTF", {".gltf", ".glb"}}};
const std::vector<FileFormat> kViews{{"BCF", {".bcfzip", ".bcf"}}, {"JSON", {".json"}}};

class FileBrowserTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) /
              ("sightline-browser-" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    for (const char* name : {"sub10", "sub2/deep", ".hidden"}) fs::create_directories(folder_ / name);
    for (const char* name : {"a10.rvm", "a2.RVM", "B1.glb", "c.gltf", "notes.md", ".secret.rvm"}) write(name, 10);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, std::size_t bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << std::string(bytes, 'x');
  }
  FileBrowser asked(Purpose purpose, const std::vector<FileFormat>& formats, const std::string& name = "") const {
    FileBrowser browser;
    browser.begin({purpose, "All", formats, name}, folder_);
    return browser;
  }
  FileBrowser opening() const { return asked(Purpose::kOpenSeveral, kModels); }
  static Names listed(const FileBrowser& browser) {
    Names names;
    for (std::size_t i = 0; i < browser.row_count(); ++i) names.push_back(browser.row(i).name);
    return names;
  }
  static void choose(FileBrowser& browser, const std::string& name, Choose how = Choose::kAlone) {
    const Names names = listed(browser);
    const auto found = std::find(names.begin(), names.end(), name);
    ASSERT_NE(found, names.end()) << name;
    browser.choose(std::size_t(found - names.begin()), how);
  }
  /// The names of the answer, in the folder; none where there is none.
  Names answer(FileBrowser& browser) const {
    Names names;
    for (const fs::path& file : browser.accept().value_or(std::vector<fs::path>()))
      names.push_back(file.lexically_relative(folder_).string());
    return names;
  }

  fs::path folder_;
};

TEST(NaturalOrder, CountsAsPeopleDo) {
  const Names sorted{"",   "0",   "00",   "1",     "1a", "2",  "10", "a",         "A1",         "a2",
                     "a9", "a10", "a10b", "a010c", "B",  "b1", "c",  "r3 v2.rvm", "r3 v11.rvm", "Z"};
  for (std::size_t i = 0; i < sorted.size(); ++i)
    for (std::size_t j = 0; j < sorted.size(); ++j)
      EXPECT_EQ(natural_less(sorted[i], sorted[j]), i < j) << sorted[i] << ", " << sorted[j];
}

/// A strict weak order, or sorting would be undefined; also of numbers that no integer holds.
TEST(NaturalOrder, IsAnOrder) {
  std::mt19937 random(1);
  Names names;
  for (int i = 0; i < 60; ++i) {
    std::string name;
    for (const std::size_t length = random() % 6; name.size() < length;) name += "01aAbB9."[random() % 8];
    names.push_back(name + (i % 20 == 0 ? std::string(40, '9') : ""));
  }
  for (const std::string& a : names)
    for (const std::string& b : names) {
      EXPECT_EQ(int(natural_less(a, b)) + int(natural_less(b, a)), a == b ? 0 : 1) << a << ", " << b;
      for (const std::string& c : names)
        EXPECT_TRUE(!natural_less(a, b) || !natural_less(b, c) || natural_less(a, c)) << a << b << c;
    }
}

TEST(FileFormats, AreThoseOfTheImporters) {
  std::size_t count = 0;
  for (const FileFormat& format : model_formats()) {
    count += format.extensions.size();
    EXPECT_NE(format.name, "");
    for (const std::string& extension : format.extensions)
      EXPECT_NE(format.name, extension.substr(1)) << "a format needs a name";
  }
  EXPECT_EQ(count, importers::known_extensions().size());
  EXPECT_TRUE(model_formats().front().has("x/A.RVM"));
  EXPECT_FALSE(model_formats().front().has("x/rvm"));
}

TEST_F(FileBrowserTest, ListsFoldersThenFilesOfTheFormats) {
  FileBrowser browser = opening();
  EXPECT_EQ(listed(browser), (Names{"sub2", "sub10", "a2.RVM", "a10.rvm", "B1.glb", "c.gltf"}));
  ASSERT_EQ(browser.filters().size(), 4u);
  EXPECT_EQ(browser.filters()[0].name, "All");
  browser.set_filter(2);
  EXPECT_EQ(listed(browser), (Names{"sub2", "sub10", "B1.glb", "c.gltf"}));
  browser.set_filter(3);
  EXPECT_EQ(listed(browser), (Names{"sub2", "sub10", "a2.RVM", "a10.rvm", "B1.glb", "c.gltf", "notes.md"}));
  browser.set_filter(0);
  browser.type(".s");
  EXPECT_EQ(listed(browser),
            (Names{".hidden", "sub2", "sub10", ".secret.rvm", "a2.RVM", "a10.rvm", "B1.glb", "c.gltf"}));
  EXPECT_EQ(browser.row(*browser.cursor()).name, ".secret.rvm");
  browser.type("s");
  EXPECT_EQ(browser.row_count(), 6u);
  EXPECT_EQ(listed(asked(Purpose::kFolder, {})), (Names{"sub2", "sub10"}));
}

TEST_F(FileBrowserTest, SortsByColumnsAndKeepsWhatIsChosen) {
  write("big.rvm", 1000);
  write("small.rvm", 1);
  fs::last_write_time(folder_ / "B1.glb", fs::file_time_type::clock::now() - std::chrono::hours(50));
  FileBrowser browser = opening();
  choose(browser, "a10.rvm");
  browser.sort(FileBrowser::Column::kSize, true);
  EXPECT_EQ(listed(browser), (Names{"sub2", "sub10", "small.rvm", "a2.RVM", "a10.rvm", "B1.glb", "c.gltf", "big.rvm"}));
  EXPECT_EQ(browser.chosen_count(), 1u);
  EXPECT_TRUE(browser.chosen(4));
  browser.sort(FileBrowser::Column::kSize, false);
  EXPECT_EQ(browser.row(2).name, "big.rvm") << "folders stay before files";
  browser.sort(FileBrowser::Column::kDate, true);
  EXPECT_EQ(browser.row(2).name, "B1.glb");
  browser.sort(FileBrowser::Column::kName, false);
  EXPECT_EQ(browser.row(0).name, "sub10");
  EXPECT_EQ(browser.row(2).name, "small.rvm");
  EXPECT_EQ(answer(browser), Names{"a10.rvm"});
}

TEST_F(FileBrowserTest, GoesUpAndDown) {
  FileBrowser browser = opening();
  choose(browser, "sub2");
  EXPECT_EQ(answer(browser), Names{});
  EXPECT_EQ(browser.folder(), folder_ / "sub2");
  EXPECT_EQ(browser.typed(), "");
  EXPECT_EQ(listed(browser), Names{"deep"});
  browser.go_up();
  EXPECT_EQ(browser.folder(), folder_);
  EXPECT_EQ(browser.row(*browser.cursor()).name, "sub2") << "where it has come from";
  const std::vector<Place> parts = browser.breadcrumb();
  const fs::path root = folder_.root_path();
  EXPECT_EQ(parts.front(), (Place{root.string(), root}));
  EXPECT_EQ(parts.back(), (Place{folder_.filename().string(), folder_}));
  EXPECT_EQ(parts[parts.size() - 2].folder, folder_.parent_path());
  browser.enter(root);
  browser.go_up();
  EXPECT_EQ(browser.folder(), root);
  EXPECT_EQ(browser.breadcrumb(), (std::vector<Place>{{root.string(), root}}));
  browser.begin({Purpose::kOpen, "", kModels}, folder_ / "none" / "at all");
  EXPECT_EQ(browser.folder(), folder_) << "the nearest one that is there";
}

TEST_F(FileBrowserTest, ChoosesOneOrSeveral) {
  FileBrowser browser = opening();
  choose(browser, "a2.RVM");
  EXPECT_EQ(browser.typed(), "a2.RVM");
  choose(browser, "B1.glb", Choose::kRange);
  EXPECT_EQ(browser.typed(), "") << "several have no name";
  EXPECT_EQ(browser.chosen_count(), 3u);
  choose(browser, "a10.rvm", Choose::kToggle);
  EXPECT_EQ(answer(browser), (Names{"a2.RVM", "B1.glb"}));
  choose(browser, "sub2", Choose::kToggle);
  EXPECT_EQ(answer(browser), (Names{"a2.RVM", "B1.glb"})) << "folders do not count among several";
  choose(browser, "c.gltf");
  EXPECT_EQ(answer(browser), Names{"c.gltf"});

  FileBrowser one = asked(Purpose::kOpen, kModels);
  choose(one, "a2.RVM");
  choose(one, "B1.glb", Choose::kRange);
  EXPECT_EQ(answer(one), Names{"B1.glb"});
}

TEST_F(FileBrowserTest, KeysMoveTheCursor) {
  FileBrowser browser = opening();
  browser.move(1, false);
  EXPECT_EQ(browser.typed(), "sub2");
  browser.move(100, false);
  EXPECT_EQ(browser.typed(), "c.gltf");
  browser.move(-2, true);
  EXPECT_EQ(answer(browser), (Names{"a10.rvm", "B1.glb", "c.gltf"}));
  browser.move(1, true);
  EXPECT_EQ(answer(browser), (Names{"B1.glb", "c.gltf"}));
  browser.type("b");
  EXPECT_EQ(browser.chosen_count(), 0u);
  EXPECT_EQ(browser.row(*browser.cursor()).name, "B1.glb");
  browser.move(1, false);
  EXPECT_EQ(browser.typed(), "c.gltf");
}

TEST_F(FileBrowserTest, TakesTypedPaths) {
  FileBrowser browser = opening();
  const auto typed = [&](const std::string& text) {
    browser.type(text);
    return answer(browser);
  };
  EXPECT_EQ(typed("notes.md"), Names{"notes.md"}) << "whatever is listed";
  EXPECT_EQ(typed("sub2/../a2.RVM"), Names{"a2.RVM"});
  EXPECT_EQ(typed((folder_ / "c.gltf").string()), Names{"c.gltf"});
  EXPECT_EQ(typed("b"), Names{"B1.glb"}) << "the first one that begins so";
  EXPECT_EQ(typed("none.rvm"), Names{});
  EXPECT_EQ(browser.error(), (folder_ / "none.rvm").string() + ": no such file");
  EXPECT_EQ(typed(""), Names{});
  EXPECT_EQ(browser.error(), "");
  EXPECT_EQ(typed("sub2/deep"), Names{});
  EXPECT_EQ(browser.folder(), folder_ / "sub2" / "deep");
  EXPECT_EQ(typed("../.."), Names{});
  EXPECT_EQ(browser.folder(), folder_);
  EXPECT_EQ(typed_path("~/x", folder_), core::platform::home_folder() / "x");
  EXPECT_EQ(typed_path("~", folder_), core::platform::home_folder() / "");
  EXPECT_EQ(typed_path("~x", folder_), folder_ / "~x");
}

TEST_F(FileBrowserTest, SavesWithAnExtensionAndAsksFirst) {
  write("old.json", 3);
  FileBrowser browser = asked(Purpose::kSave, kViews, "views.bcfzip");
  EXPECT_EQ(browser.typed(), "views.bcfzip");
  EXPECT_EQ(asked(Purpose::kSave, kViews, "views.json").filter(), 1u) << "the format of the name";
  EXPECT_EQ(browser.filter(), 0u);
  EXPECT_EQ(answer(browser), Names{"views.bcfzip"});
  browser.set_filter(1);
  EXPECT_EQ(browser.typed(), "views.json");
  browser.type("r1.2");
  EXPECT_EQ(answer(browser), Names{"r1.2.json"});
  browser.type("x.BCF");
  EXPECT_EQ(answer(browser), Names{"x.BCF"});
  choose(browser, "old.json");
  choose(browser, "sub2");
  EXPECT_EQ(browser.typed(), "old.json") << "the name stays while folders are looked at";
  EXPECT_EQ(answer(browser), Names{});
  EXPECT_EQ(browser.folder(), folder_ / "sub2");
  EXPECT_EQ(browser.typed(), "old.json");
  browser.go_up();
  browser.type("old");
  EXPECT_EQ(answer(browser), Names{});
  ASSERT_EQ(browser.asks_to_replace(), folder_ / "old.json");
  browser.keep();
  EXPECT_FALSE(browser.asks_to_replace());
  EXPECT_EQ(answer(browser), Names{});
  EXPECT_EQ(browser.replace(), std::vector<fs::path>{folder_ / "old.json"});
  EXPECT_FALSE(browser.asks_to_replace());
  browser.type("none/x.json");
  EXPECT_EQ(answer(browser), Names{});
  EXPECT_EQ(browser.error(), (folder_ / "none").string() + ": no such folder");
  browser.type("sub2/");
  EXPECT_EQ(answer(browser), Names{});
  EXPECT_EQ(browser.folder(), folder_ / "sub2");
  EXPECT_EQ(browser.typed(), "views.bcfzip");
}

TEST_F(FileBrowserTest, AsksForFolders) {
  FileBrowser browser = asked(Purpose::kFolder, {}, "frames");
  EXPECT_TRUE(browser.filters().empty());
  EXPECT_EQ(answer(browser), Names{"frames"}) << "one that is not there yet";
  choose(browser, "sub2");
  EXPECT_EQ(answer(browser), Names{"sub2"});
  browser.type("sub2/");
  EXPECT_EQ(answer(browser), Names{});
  EXPECT_EQ(browser.folder(), folder_ / "sub2");
  browser.type("");
  EXPECT_EQ(answer(browser), Names{"sub2"});
  browser.type("../notes.md");
  EXPECT_EQ(answer(browser), Names{});
  EXPECT_EQ(browser.error(), (folder_ / "notes.md").string() + ": is a file, expected a folder");
}

TEST_F(FileBrowserTest, SeesWhatHasComeAndGone) {
  FileBrowser browser = opening();
  choose(browser, "c.gltf");
  fs::remove(folder_ / "a2.RVM");
  write("d.rvm", 4);
  std::error_code refused;  // by g++'s library for Windows, which sets no times of folders
  fs::last_write_time(folder_, fs::last_write_time(folder_) + std::chrono::seconds(1), refused);
  if (refused) GTEST_SKIP() << refused.message();
  browser.refresh();
  EXPECT_EQ(listed(browser), (Names{"sub2", "sub10", "a10.rvm", "B1.glb", "c.gltf", "d.rvm"}));
  EXPECT_EQ(answer(browser), Names{"c.gltf"});
  fs::remove_all(folder_);
  browser.refresh();
  EXPECT_EQ(browser.row_count(), 0u);
  EXPECT_EQ(browser.error(), folder_.string() + ": cannot be read: No such file or directory");
  EXPECT_FALSE(browser.accept());
}

TEST_F(FileBrowserTest, HasPlacesThatAreThere) {
  const std::string home = core::platform::home_folder().string(), here = (folder_ / "sub2" / "x.rvm").string();
  const std::vector<Place> all =
      places(std::vector{here}, std::vector{here, std::string("/none/y.rvm"), (folder_ / "z.rvm").string()});
  const std::vector<Place> expected{
      {"Home", fs::path(home).lexically_normal()}, {"sub2", folder_ / "sub2"}, {folder_.filename().string(), folder_}};
  EXPECT_EQ(all, expected);
}

}  // namespace
}  // namespace sightline::apps::file_browser_test
