// sightline-view beside another version of the model: what changed. Skipped without Xvfb.
#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_comparison_test {
namespace {

/// Boxes in a row from left to right, and what became of them. From the front a metre is 20 pixels.
class ViewComparison : public ViewScript {
 protected:
  void SetUp() override {
    ViewScript::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    old_ = write_boxes(
        "old.obj", {{"gone", -8, 0, 0, 0.8}, {"moved", -4, 0, 0, 1}, {"changed", 0, 0, 0, 1}, {"same", 4, 0, 0, 1}});
    new_ = write_boxes(
        "new.obj",
        {{"moved", -4, 0, 1.5, 1}, {"changed", 0, 0, 0, 1.5}, {"same", 4, 0, 0, 1}, {"added", 8, 0, 0, 0.9}});
    front_ = "load-view " +
             write("front.json",
                   R"({"eye": [0, -100, 0], "target": [0, 0, 0], "up": [0, 0, 1], "fovy_deg": 11.4212, "near": 1})") +
             "\n";
  }
  /// The shares of red, green and blue in a pixel, which shading leaves as they are.
  static std::array<double, 3> hue(const Image& image, int x, int y) {
    const std::size_t at = 3 * (std::size_t(y) * std::size_t(image.width) + std::size_t(x));
    const double sum = image.rgb.at(at) + image.rgb.at(at + 1) + image.rgb.at(at + 2);
    return {image.rgb[at] / sum, image.rgb[at + 1] / sum, image.rgb[at + 2] / sum};
  }
  static void expect_hue(const Image& image, int x, int y, const std::array<int, 3>& rgb) {
    const std::array<double, 3> found = hue(image, x, y);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(found[c], double(rgb[c]) / (rgb[0] + rgb[1] + rgb[2]), 0.1) << x << ", " << y << ": " << c;
  }

  std::string old_, new_, front_;
};

TEST_F(ViewComparison, ColoursWhatChanged) {
  const std::string before = path("before.png"), during = path("during.png"), some = path("some.png"),
                    after = path("after.png");
  expect_driven(front_ + "expect /compare = null\nexpect /items = 4\nscreenshot " + before + "\ncompare " + old_ +
                    "\nexpect /compare/added = 1\nexpect /compare/removed = 1\nexpect /compare/moved = 1\n"
                    "expect /compare/changed = 1\nexpect /compare/unchanged = 1\nexpect /compare/rows = 4\n"
                    "expect /items = 5\nexpect /undo_steps = 0\nscreenshot " +
                    during +
                    "\ncompare-toggle changed\ncompare-toggle unchanged\nexpect /compare/shown/changed = false\n"
                    "expect /compare/rows = 3\nscreenshot " +
                    some + "\ncompare-end\nexpect /compare = null\nexpect /items = 4\nscreenshot " + after + "\n",
                {new_, "--size", kSize, "--no-panels"});
  const Image old = read_png(before), all = read_png(during), three = read_png(some), end = read_png(after);
  EXPECT_EQ(old.rgb, end.rgb) << "all is as it was";
  const std::array<double, 3> sky = hue(old, 140, 200);
  for (const Image* image : {&all, &three}) {
    expect_hue(*image, 140, 200, {213, 94, 0});
    expect_hue(*image, 220, 170, {86, 180, 233});
    expect_hue(*image, 460, 200, {0, 158, 115});
  }
  expect_hue(all, 300, 200, {240, 228, 66});
  EXPECT_EQ(hue(three, 300, 200), sky);
  EXPECT_EQ(hue(three, 380, 200), sky);
  EXPECT_NE(hue(all, 380, 200), sky) << "faint, but there";
}

/// Each half is what the file alone shows, but for the colours of what changed.
TEST_F(ViewComparison, TheSliderShowsBothRevisions) {
  const Args view{"--size", kSize, "--no-panels"};
  const auto with = [&](const std::string& model) {
    Args args{model};
    args.insert(args.end(), view.begin(), view.end());
    return args;
  };
  const auto shot = [&](const std::string& name) { return "screenshot " + path(name) + "\n"; };
  expect_driven(front_ + shot("older.png"), with(old_));
  expect_driven(front_ + shot("newer.png") + "select-all\nhide\n" + shot("sky.png") + "undo\nundo\ncompare " + old_ +
                    "\n" + shot("before.png") + "compare-slider\nexpect /compare/slider = 0.5\nexpect /items = 7\n" +
                    shot("half.png") + "compare-slider 1\n" + shot("left.png") + "compare-slider 0\n" +
                    shot("right.png") + "compare-slider off\nexpect /compare/slider = null\nexpect /items = 5\n" +
                    shot("after.png"),
                with(new_));
  const Image older = read_png(path("older.png")), newer = read_png(path("newer.png")), sky = read_png(path("sky.png")),
              half = read_png(path("half.png")), left = read_png(path("left.png")), right = read_png(path("right.png"));
  EXPECT_EQ(read_png(path("before.png")).rgb, read_png(path("after.png")).rgb);
  const auto same = [](const Image& a, const Image& b, int x, int y) {
    const std::size_t at = 3 * (std::size_t(y) * std::size_t(a.width) + std::size_t(x));
    return std::equal(a.rgb.begin() + long(at), a.rgb.begin() + long(at) + 3, b.rgb.begin() + long(at));
  };
  /// Pixels between two columns in which one shows something and the other nothing.
  const auto differ = [&](const Image& a, const Image& b, int begin, int end) {
    int count = 0, seen = 0;
    for (int y = 0; y < sky.height; ++y)
      for (int x = begin; x < end; ++x) {
        count += same(a, sky, x, y) != same(b, sky, x, y);
        seen += !same(a, sky, x, y);
      }
    EXPECT_GT(seen, 500);
    return count;
  };
  EXPECT_LE(differ(half, older, 0, 300), 5);
  EXPECT_LE(differ(half, newer, 300, 600), 5);
  EXPECT_LE(differ(left, older, 0, 600), 5);
  EXPECT_LE(differ(right, newer, 0, 600), 5);
  EXPECT_GT(differ(half, newer, 0, 300), 500) << "they are not alike";
  for (int y = 185; y < 215; ++y)
    for (int x = 365; x < 395; ++x)
      ASSERT_TRUE(same(left, older, x, y) && same(right, newer, x, y)) << "the unchanged box has its own colour";
  expect_hue(half, 140, 200, {213, 94, 0});
  expect_hue(half, 220, 200, {86, 180, 233});
  expect_hue(half, 290, 200, {240, 228, 66});
  expect_hue(half, 460, 200, {0, 158, 115});
}

/// Clicks select what is there, and the mouse drags the line.
TEST_F(ViewComparison, TheSliderIsDraggedAndPicked) {
  expect_driven(front_ + "compare " + old_ +
                    "\ncompare-slider\nclick 220 200\nexpect /selection/count = 1\nclick 220 165\n"
                    "expect /selection/count = 0\nclick 140 200\nexpect /selection/count = 1\nclick 460 200\n"
                    "expect /selection/count = 1\nhide\nexpect /hidden = 1\n"
                    "drag 300 100 120 100\nexpect /compare/slider = 0.2\nexpect /selection/count = 0\n"
                    "click 220 200\nexpect /selection/count = 0\nclick 220 165\nexpect /selection/count = 1\n"
                    "drag 120 300 700 300\nexpect /compare/slider = 1\nclick 460 200\n"
                    "expect /selection/count = 0\ncompare-slider 0.5\ndrag 1 1 599 399 ctrl\n"
                    "expect /selection/count = 3\npress escape\nexpect /compare/slider = null\n"
                    "expect /compare/added = 1\nexpect /selection/count = 2\ncompare-slider 0.3\nlose-context\n"
                    "expect /compare/slider = 0.3\ncompare-end\nexpect /compare = null\nexpect /items = 4\n",
                {new_, "--size", kSize, "--no-panels"});
  for (const auto& [script, message] :
       {std::pair<std::string, std::string>{"compare-slider\n", "compare with an older revision first"},
        {"compare " + old_ + "\ncompare-slider 2\n", "between 0 and 1"},
        {"compare " + old_ + "\ncompare-slider\nscreenshot a.png 900x600\n", "end the slider"}}) {
    const Outcome outcome = drive(script, {new_, "--size", kSize});
    EXPECT_EQ(outcome.code, 1) << outcome;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome;
  }
}

TEST_F(ViewComparison, TheListIsOfGroupsAndIsWritten) {
  const std::string page = path("changes.html"), table = path("changes.csv");
  expect_driven(
      "compare " + old_ + "\nexpect /compare/rows = 4\ncompare-save " + page + "\ncompare-save " + table + "\n",
      {new_, "--size", kSize, "--no-panels"});
  EXPECT_NE(read_bytes(page).find("<summary>"), std::string::npos);
  const std::string lines = read_bytes(table);
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 5) << lines;
  const Outcome refused = drive("compare " + old_ + "\ncompare-save changes.txt\n", {new_, "--size", kSize});
  EXPECT_NE(refused.err.find("changes.txt: expected a name that ends in .html"), std::string::npos) << refused;
}

/// Removed items are picked, hidden, cut, found and undone like others, and leave nothing behind.
TEST_F(ViewComparison, RemovedItemsTakePart) {
  expect_driven(front_ + "click 380 200\nexpect /selection/count = 1\nhide\nexpect /hidden = 1\nselect-none\ncompare " +
                    old_ +
                    "\nexpect /hidden = 1\nclick 380 200\nexpect /selection/count = 0\n"
                    "wait 0.5\nclick 140 200\nexpect /selection/count = 1\nsection-box\nexpect /sections = 6\n"
                    "drag 1 1 599 399 ctrl\nexpect /selection/count = 1\nsection-clear\n"
                    "hide\nexpect /hidden = 2\nundo\nexpect /hidden = 1\nexpect /selection/count = 1\n"
                    "find gone\nexpect /found = 1\nselect-none\nselect-found\nexpect /selection/count = 1\nhide\n"
                    "compare-end\nexpect /hidden = 1\nexpect /found = 0\nexpect /items = 4\n"
                    "expect /selection/count = 0\nundo\nexpect /hidden = 0\nexpect /selection/count = 1\n"
                    "undo\nexpect /undo_steps = 0\nredo\nredo\nexpect /hidden = 1\n",
                {new_, "--size", kSize, "--no-panels"});
}

TEST_F(ViewComparison, GoesFromChangeToChange) {
  const std::string shot = path("tab.png");
  expect_driven("compare " + old_ +
                    "\npress n\nexpect /compare/current = 1\nexpect /selection/count = 1\n"
                    "expect /camera/target/0 > -1\nexpect /camera/target/0 < 1\n"  // the largest
                    "press shift+n\nexpect /compare/current = 4\nexpect /camera/target/0 < -7\nwindow-shot " +
                    shot +
                    "\npress n\npress n\nexpect /compare/current = 2\npress backspace\npress backspace\n"
                    "expect /camera/target/0 < -7\n",
                {new_, "--size", "800x600"});
  const Image image = read_png(shot);
  for (const std::array<int, 3>& colour : {std::array{0, 158, 115}, {213, 94, 0}, {86, 180, 233}, {240, 228, 66}}) {
    int pixels = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 570; x < image.width; ++x) {
        const std::size_t at = 3 * (std::size_t(y) * std::size_t(image.width) + std::size_t(x));
        pixels += image.rgb[at] == colour[0] && image.rgb[at + 1] == colour[1] && image.rgb[at + 2] == colour[2];
      }
    EXPECT_GT(pixels, 2 * 100) << "the legend and a row have squares of it: " << colour[0];
  }
}

/// What cannot be read or is not there changes nothing; another model ends the comparison, a broken one does not.
TEST_F(ViewComparison, EndsWithTheModelAlone) {
  const std::string broken = write("broken.rvm", "no model"), other = boxes();
  const Args args{new_, "--size", kSize};
  expect_driven("compare " + broken +
                    "\nexpect /compare = null\nexpect /message != comparing\nexpect /items = 4\ncompare " + old_ +
                    "\ncompare " + broken + "\nexpect /compare/added = 1\nopen " + broken +
                    "\nexpect /compare/added = 1\ncompare " + new_ +
                    "\nexpect /compare/added = 0\nexpect /compare/unchanged = 4\nexpect /items = 4\n"
                    "expect /message = nothing has changed since new.obj\ncompare " +
                    old_ + "\nexpect /items = 5\nlose-context\nexpect /compare/removed = 1\nexpect /items = 5\nopen " +
                    other + "\nexpect /compare = null\nexpect /items = 4\n",
                args);
  for (const auto& [script, message] :
       {std::pair<std::string, std::string>{"compare-end\n", "compare with an older revision first"},
        {"compare-next\n", "compare with an older revision first"},
        {"compare " + old_ + "\ncompare-toggle blue\n", "expected added, removed"},
        {"compare " + new_ + "\ncompare-next\n", "no changes"}}) {
    const Outcome outcome = drive(script, args);
    EXPECT_EQ(outcome.code, 1) << outcome;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome;
  }
}

}  // namespace
}  // namespace sightline::tests::view_comparison_test
