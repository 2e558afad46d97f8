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
                    "expect /camera/target/0 > -5\nexpect /camera/target/0 < -3\nexpect /camera/target/2 > 0.5\n"
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
