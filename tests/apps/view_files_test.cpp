// How sightline-view asks for files, and what it shows of them. Skipped without Xvfb.
#include <set>

#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_files_test {
namespace {

/// A folder of models: `a`, `b2` and `b10` of one, two and three boxes, and one below it.
class ViewFiles : public ViewScript {
 protected:
  void SetUp() override {
    ViewScript::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    fs::create_directories(path("models/sub"));
    models_ = fs::canonical(path("models")).string();
    const std::vector<Box> boxes{{"one", 0, 0, 0, 1}, {"two", 5, 0, 0, 1}, {"three", 10, 0, 0, 1}};
    write_boxes("models/a.obj", {boxes[0]});
    write_boxes("models/b2.obj", {boxes[0], boxes[1]});
    write_boxes("models/b10.obj", boxes);
    write_boxes("models/sub/c.obj", boxes);
    write("models/readme.md", "no model");
  }
  Args opened() const {
    return {in_models("a.obj"), "--size", "800x600", "--scale", "1", "--save-path", path("recorded.json")};
  }

  std::string in_models(const std::string& name) const { return (fs::path(models_) / name).make_preferred().string(); }

  std::string models_;
};

TEST_F(ViewFiles, ASessionIsAsItWas) {
  const std::string session = path("s.sightline"), before = path("before.png"), after = path("after.png");
  const std::string state =
      "expect /items = 3\nexpect /hidden = 1\nexpect /sections = 1\nexpect /colours/key = @size\n"
      "expect /views/count = 1\nexpect /views/name = kept\nexpect /selection/count = 1\n";
  expect_driven("top\nview-add kept\nhide two\nsection-z\ncolour-by @size\nfind three\nselect-found\nfront\n" + state +
                    "session-save " + session + "\nscreenshot " + before + "\n",
                {in_models("b10.obj"), "--size", kSize, "--no-panels"});
  expect_driven(state + "screenshot " + after + "\n", {session, "--size", kSize, "--no-panels"});
  EXPECT_LE(differing(read_png(before), read_png(after)), kTies);
  expect_driven("open " + session + "\n" + state, {in_models("a.obj"), "--size", kSize, "--no-panels"});
  EXPECT_EQ(drive("session-save " + path("s.json") + "\n", opened()).code, 1);
  fs::remove(in_models("b10.obj"));
  const Outcome gone = drive("open " + session + "\nexpect /items = 1\n", opened());
  EXPECT_EQ(gone.code, 0) << gone << "what is open stays";
}

TEST_F(ViewFiles, AFileIsAppendedAndTheViewStays) {
  expect_driven("hide one\nsection-z\nview-add kept\nappend " + in_models("b2.obj") +
                    "\nexpect /items = 3\nexpect /hidden = 1\nexpect /sections = 1\nexpect /views/count = 1\n"
                    "expect /model/1 = " +
                    in_models("b2.obj") +
                    "\nappend\nexpect /dialog = append\npress escape\n"
                    "session-save\nexpect /dialog = session-save\npress escape\n",
                opened());
}

TEST_F(ViewFiles, DamagedFilesOpenAsFarAsTheyCanBeRead) {
  const std::string bad = in_models("bad.obj"), gone = in_models("gone.obj");
  write("models/bad.obj", "o good\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\no bad\nf 1 2 9\n");
  const Json end = state_after("open " + gone + "\nexpect /damaged = []\nopen " + bad +
                                   "\nexpect /items = 3\nexpect /damaged/0 = " + bad +
                                   "\nopen-lenient\nexpect /items = 1\nexpect /damaged = []\n",
                               {in_models("b10.obj"), "--size", "800x600"});
  EXPECT_NE(end["message"].get<std::string>().find("1 warning says what was lost"), std::string::npos)
      << end["message"];
  write_boxes("models/sub/b2.obj", {{"one", 0, 0, 0, 1}});
  // It stays open, however it is read again.
  const std::string session = path("bad.sightline");
  expect_driven("open-lenient " + bad + "\nexpect /items = 1\ny-up\nexpect /items = 1\nappend " + in_models("b2.obj") +
                    "\nexpect /items = 3\ncompare " + in_models("sub/b2.obj") +
                    "\nexpect /compare/added = 1\nsession-save " + session + "\n",
                {"--size", "800x600"});
  expect_driven("expect /items = 3\nexpect /compare/added = 1\n", {session, "--size", "800x600"});
  // A session that was saved before the file was damaged.
  std::string strict = read_bytes(session);
  const std::size_t at = strict.find("\"lenient\": true");
  ASSERT_NE(at, std::string::npos) << strict;
  write("strict.sightline", strict.replace(at, 15, "\"lenient\": false"));
  expect_driven("open " + path("strict.sightline") + "\nexpect /items = 1\nexpect /damaged/0 = " + bad +
                    "\nopen-lenient\nexpect /items = 3\nexpect /compare/added = 1\n",
                {in_models("a.obj"), "--size", "800x600"});
  expect_driven("open-lenient " + path("strict.sightline") + "\nexpect /items = 3\nopen " + in_models("readme.md") +
                    "\nexpect /damaged = []\n",
                {"--size", "800x600"});
}

/// With a settings file of its own, a run keeps what was open, and the next one offers it.
TEST_F(ViewFiles, TheLastSessionIsOffered) {
  const Args settings{"--settings", path("settings.json"), "--size", "800x600", "--scale", "1"};
  Args first = settings;
  first.insert(first.begin(), in_models("b10.obj"));
  expect_driven("hide two\n", first);
  // The button lies below the area for files.
  expect_driven("click 300 181\nexpect /items = 3\nexpect /hidden = 1\n", settings);
}

TEST_F(ViewFiles, OpensByKeyboard) {
  expect_driven("open\nexpect /browser/folder = " + models_ +
                    "\nexpect /browser/rows = 4\n"
                    "press down\nexpect /browser/name = sub\npress enter\nexpect /browser/folder = " +
                    in_models("sub") +
                    "\npress backspace\nexpect /browser/row = sub\n"
                    "press down\npress shift+down\nexpect /browser/chosen = 2\npress enter\nexpect /dialog = none\n"
                    "expect /items = 3\nexpect /model/1 = " +
                    in_models("b2.obj") +
                    "\n"
                    "open\ntype b1\nexpect /browser/row = b10.obj\npress enter\nexpect /items = 3\n"
                    "expect /model/0 = " +
                    in_models("b10.obj") +
                    "\nopen\ntype none.obj\npress enter\nexpect /dialog = open\nexpect /browser/error = " +
                    in_models("none.obj") +
                    ": no such file\npress escape\nexpect /dialog = none\nexpect /browser = null\n"
                    "open\ntype sub/c.obj\npress enter\nexpect /items = 3\n",
                opened());
}

/// The first row of the list is 141 pixels below the window's upper edge, the others follow by 19.
TEST_F(ViewFiles, OpensByMouse) {
  expect_driven(
      "open\nclick 300 179\nexpect /browser/name = b2.obj\nclick 300 198 ctrl\nexpect /browser/chosen = 2\n"
      "click 300 160 shift\nexpect /browser/chosen = 3\nclick 300 198\nclick 300 198\nexpect /dialog = none\n"
      "expect /items = 3\n",
      opened());
}

TEST_F(ViewFiles, ComparesWithAFile) {
  expect_driven("compare\ntype b2\npress enter\nexpect /compare/removed = 1\n", opened());
}

/// In the window's size, which the button before 4K asks for. A file is replaced only by a second answer.
TEST_F(ViewFiles, SavesAnImageAndAsksBeforeReplacing) {
  const std::string image = in_models("shot.png");
  expect_driven(
      "large-image\ntype x\npress escape\nlarge-image\nexpect /browser/name = a.png\ntype shot\nclick 57 472\npress "
      "enter\nexpect /dialog = none\n"
      "expect /message = \"image: " +
          image + "\"\n",
      opened());
  const std::string first = read_bytes(image);
  EXPECT_EQ(read_png(image).width, state_after("", opened())["image"]["width"].get<int>());
  const std::string again = "top\nlarge-image\nclick 57 472\ntype shot\npress enter\nexpect /browser/replaces = true\n";
  expect_driven(again +
                    "press escape\nexpect /browser/replaces = false\nexpect /dialog = image\npress escape\n"
                    "expect /dialog = none\n",
                opened());
  EXPECT_EQ(read_bytes(image), first);
  expect_driven(again + "press enter\nexpect /dialog = none\n", opened());
  EXPECT_NE(read_bytes(image), first);
}

TEST_F(ViewFiles, SavesAndReadsPathsAndViews) {
  expect_driven(
      "record\ntop\nrecord\nsave-path\ntype flight\npress enter\nexpect /dialog = path\n"
      "view-add\nviews-save\npress enter\nexpect /dialog = none\nviews-save\nexpect /browser/rows = 2\n"
      "press escape\nview-delete\nviews-load\ntype views.\nexpect /browser/rows > 1\npress enter\n"
      "expect /views/count = 1\n",
      opened());
  EXPECT_TRUE(fs::exists(in_models("flight.json")));
  expect_driven("play-path " + in_models("flight.json") + "\n", opened());
}

/// With a folder of caches of its own.
class ViewThumbnails : public ViewFiles {
 protected:
  void SetUp() override {
    ViewFiles::SetUp();
    cache_.set(path("cache"));
  }
  std::vector<std::string> thumbnails() const {
    std::vector<std::string> names;
    if (!fs::exists(path("cache/sightline/thumbnails"))) return names;
    for (const auto& entry : fs::directory_iterator(path("cache/sightline/thumbnails")))
      names.push_back(entry.path().string());
    return names;
  }
  Args kept(Args args) const {
    args.insert(args.end(), {"--size", "800x600", "--scale", "1", "--settings", path("settings.json")});
    return args;
  }
  static Image crop(const Image& whole, int left, int top, int width, int height) {
    Image part{width, height, {}};
    for (int y = top; y < top + height; ++y)
      for (int i = 3 * (y * whole.width + left); i < 3 * (y * whole.width + left + width); ++i)
        part.rgb.push_back(whole.rgb[std::size_t(i)]);
    return part;
  }
  /// The first image of the page.
  Image first_image() const {
    expect_driven("window-shot " + path("page.png") + "\n", kept({}));
    return crop(read_png(path("page.png")), 232, 200, 120, 80);
  }
  static int colours(const Image& image) {
    std::set<std::array<int, 3>> found;
    for (std::size_t i = 0; i < image.rgb.size(); i += 3)
      found.insert({image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]});
    return int(found.size());
  }

 private:
  const Variable cache_{"XDG_CACHE_HOME"};
};

TEST_F(ViewThumbnails, ShowOnTheStartPageOfTheNextStart) {
  const std::string model = in_models("b10.obj");
  expect_driven("wait 0\n", {model, "--size", kSize});
  EXPECT_TRUE(thumbnails().empty()) << "scripts leave nothing behind";
  expect_driven("wait 0\n", kept({model}));
  ASSERT_EQ(thumbnails().size(), 1u);
  const std::string first = thumbnails()[0];
  EXPECT_EQ(read_png(first).width, 256);
  EXPECT_GT(colours(first_image()), 50);
  expect_driven("click 290 240\nexpect /items = 3\n", kept({}));
  EXPECT_EQ(thumbnails(), std::vector{first}) << "the model is as it was";

  write_boxes("models/b10.obj", {{"one", 0, 0, 0, 1}});
  EXPECT_GT(colours(first_image()), 50) << "an older one shows until the model is opened";
  expect_driven("wait 0\n", kept({model}));
  ASSERT_EQ(thumbnails().size(), 1u);
  EXPECT_NE(thumbnails()[0], first);

  const Image there = first_image();
  fs::remove(model);
  EXPECT_NE(first_image().rgb, there.rgb);
  expect_driven("click 290 240\nexpect /model = []\n", kept({}));
  fs::remove(thumbnails()[0]);
  EXPECT_LT(colours(first_image()), 5);
}

/// The image of several models would not show one of them.
TEST_F(ViewThumbnails, AreOfSingleModels) {
  expect_driven("wait 0\n", kept({in_models("a.obj"), in_models("b2.obj")}));
  EXPECT_TRUE(thumbnails().empty());
}

/// A plain rectangle where the file keeps none.
TEST_F(ViewThumbnails, OfViewsShowInTheirTab) {
  const std::string shot = path("shot.png");
  const auto colours_after = [&](const std::string& commands) {
    expect_driven(commands + "window-shot " + shot + "\n", opened());
    return colours(crop(read_png(shot), 570, 130, 60, 40));
  };
  const std::string json = path("v.json"), bcf = path("v.bcfzip");
  EXPECT_GT(colours_after("view-add\nviews-save " + json + "\n"), 20);
  EXPECT_LT(colours_after("views-load " + json + "\n"), 5);
#if SIGHTLINE_HAS_BCF
  expect_driven("view-add\nviews-save " + bcf + "\n", opened());
  EXPECT_GT(colours_after("views-load " + bcf + "\n"), 20);
#endif
}

}  // namespace
}  // namespace sightline::tests::view_files_test
