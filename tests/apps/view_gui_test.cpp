// What surrounds the image in sightline-view: menus, dialogs, tools, panels. Skipped without Xvfb.
#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_gui_test {
namespace {

/// Part of an image, as rows of pixels.
std::vector<std::uint8_t> part(const Image& image, int x0, int y0, int x1, int y1) {
  std::vector<std::uint8_t> rgb;
  for (int y = y0; y < y1; ++y)
    for (int i = 3 * (y * image.width + x0); i < 3 * (y * image.width + x1); ++i)
      rgb.push_back(image.rgb[std::size_t(i)]);
  return rgb;
}

/// A menu first, then the dialog, the tool, walking, and the selection at last; one of them each time.
TEST_F(ViewScript, EscapeEndsOneThingAfterAnother) {
  expect_driven(
      "find front\nselect-found\nexpect /selection/count = 1\n"
      "walk\nmeasure\nexpect /tool = measure\nopen\nexpect /dialog = open\ntype boxes\n"
      "click 15 8\nexpect /menu = true\n"
      "press escape\nexpect /menu = false\nexpect /dialog = open\n"
      "press escape\nexpect /dialog = none\nexpect /tool = measure\n"
      "press escape\nexpect /tool = select\nexpect /walk = true\n"
      "press escape\nexpect /walk = false\nexpect /selection/count = 1\n"
      "press escape\nexpect /selection/count = 0\npress escape\n",
      {boxes(), "--size", kSize});
}

TEST_F(ViewScript, ThereIsOneDialogAtATime) {
  expect_driven(
      "open\nexpect /dialog = open\nhelp\nexpect /dialog = help\nlarge-image\nexpect /dialog = image\n"
      "camera-path\nexpect /dialog = path\ncompare\nexpect /dialog = compare\nlarge-image\nlarge-image\n"
      "expect /dialog = none\n",
      {boxes(), "--size", kSize});
}

/// The menu lies over the image: only the click that follows says which face.
TEST_F(ViewScript, PickingAFaceWaitsForAClick) {
  expect_driven(
      "front\nsection-face\nexpect /tool = section\nexpect /sections = 0\n"
      "click 5 5\nexpect /tool = section\nexpect /message = \"there is no face under the cursor\"\n"
      "click 300 200\nexpect /sections = 1\nexpect /tool = select\nexpect /selection/count = 0\n"
      "section-face\npress escape\nexpect /tool = select\n",
      {boxes(), "--size", kSize, "--no-panels"});
}

TEST_F(ViewScript, AnErrorStaysUntilAnActionSucceeds) {
  const std::string refused = "expect /message = \"select something first: click on it\"\n",
                    none = "expect /message = \"\"\n";
  expect_driven("front\npress h\n" + refused + "move 10 10\n" + refused + "click 300 200\n" + none +
                    "press escape\npress h\n" + refused + "press i\n" + refused + "top\n" + none +
                    "section-face\nclick 5 5\nexpect /message = \"there is no face under the cursor\"\npress escape\n" +
                    "press h\n" + refused,
                {boxes(), "--size", kSize, "--no-panels"});
}

TEST_F(ViewScript, WhatIsUnderTheCursorFollowsTheCamera) {
  expect_driven(
      "front\nmove 300 200\nexpect /hovered = 0\nback\nexpect /hovered = 1\nfront\nexpect /hovered = 0\n"
      "hold d 2\nexpect /hovered != 0\n",
      {boxes(), "--size", kSize, "--no-panels"});
}

/// In three rows where the panel is narrow. A tab that goes leaves the first one in front.
TEST_F(ViewScript, AllTabsAreReached) {
  const std::string model = boxes();
  expect_driven("expect /tab = Item\ndiagnostics\nexpect /tab = Diagnostics\ncompare " + model +
                    "\nexpect /tab = Compare\nclick 641 70\nexpect /tab = Item\nclick 767 96\nexpect /tab = Views\n"
                    "click 585 121\nexpect /tab = Diagnostics\nmeasure\nexpect /tab = Measure\nclick 567 70\n"
                    "expect /tab = Compare\ncompare-end\nexpect /tab = Item\n",
                {model, "--size", "800x600"});
}

TEST_F(ViewScript, NothingLiesOverDialogs) {
  const std::string plain = path("plain.png"), lined = path("lined.png"), model = boxes();
  const std::string begin = "top\nmove 590 390\nlarge-image\n", mark = "top\nmeasure\nclick 300 360\nclick 300 40\n";
  expect_driven(begin + "window-shot " + plain + "\n", {model, "--size", kSize, "--no-panels"});
  expect_driven(mark + "expect /measure/distance > 5\nmeasure\n" + begin + "window-shot " + lined + "\n",
                {model, "--size", kSize, "--no-panels"});
  const Image a = read_png(plain), b = read_png(lined);
  EXPECT_NE(a.rgb, b.rgb) << "the line shows beside the dialog";
  EXPECT_EQ(part(a, 100, 170, 500, 230), part(b, 100, 170, 500, 230));
  expect_driven(
      "front\nmove 300 200\nexpect /hovered = 0\nfind front\nselect-found\nhide\nexpect /hovered = 1\n"
      "find behind\nselect-found\nhide\nexpect /hovered = -1\n",
      {model, "--size", kSize, "--no-panels"});
}

/// A click of the right button without a drag; it selects what it hits, unless that is selected with others.
TEST_F(ViewScript, TheRightButtonOpensAMenu) {
  const Args args{boxes(), "--size", kSize, "--no-panels"};
  expect_driven(
      "front\ndrag 300 200 330 200 right\nexpect /menu = false\nfront\n"
      "click 300 200 right\nexpect /menu = true\nexpect /selection/count = 1\n"
      "section-at\nexpect /sections = 1\npress escape\nexpect /menu = false\nexpect /selection/count = 1\n"
      "select-all\nclick 300 200 right\nexpect /selection/count = 4\npress escape\n"
      "click 3 3 right\nexpect /menu = true\nexpect /selection/count = 4\n",
      args);
  const Outcome refused = drive("front\nclick 3 3 right\nsection-at\n", args);
  EXPECT_NE(refused.err.find("there is no face"), std::string::npos) << refused;
}

/// A mode of clicks stays pressed, and impossible commands do nothing but say why.
TEST_F(ViewScript, TheToolbarRunsCommands) {
  const std::string before = path("before.png"), after = path("after.png");
  // At scale 1 buttons are 26 pixels wide: open, image, select, a list, hide, isolate, show all, fit …, in blocks.
  expect_driven("window-shot " + before + "\nclick 213 36\nexpect /hidden = 0\n" +
                    "expect /message = \"4 items\"\nselect-all\nclick 213 36\nexpect /hidden = 4\n" +
                    "expect /selection/count = 0\nclick 264 36\nexpect /hidden = 0\npress h\n" +
                    "expect /message = \"select something first: click on it\"\nmeasure\nmove 500 300\nwindow-shot " +
                    after + "\nclick 79 36\nexpect /tool = select\nresize 300x300\n",
                {boxes(), "--size", "800x500", "--scale", "1"});
  EXPECT_NE(part(read_png(before), 0, 22, 800, 50), part(read_png(after), 0, 22, 800, 50)) << "pressed";
}

/// They stay when the next one begins, in views and their files, too; a view adds those that the list lacks.
TEST_F(ViewScript, MeasurementsAreAList) {
  const Args args{boxes(), "--size", kSize, "--no-panels"};
  std::vector<std::string> files{path("views.json")};
#if SIGHTLINE_HAS_BCF
  files.push_back(path("views.bcfzip"));
#endif
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    expect_driven(
        "top\nmeasure\nclick 300 360\nclick 100 200\nexpect /measure/list = 1\nclick 300 360\nclick 500 200\n"
        "expect /measure/list = 2\nclick 300 360\nexpect /measure/marks = 1\npress escape\nexpect /measure/marks = 0\n"
        "expect /measure/list = 2\nmeasure-copy\nexpect /message = \"copied: 2 measurements\"\n"
        "view-add\nviews-save " +
            file +
            "\nmeasure-remove 1\nexpect /measure/list = 1\nview-show 1\n"
            "expect /measure/list = 2\nview-show 1\nexpect /measure/list = 2\nmeasure-clear\nexpect /measure/list = "
            "0\n",
        args);
    expect_driven("views-load " + file + "\nview-show 1\nexpect /measure/list = 2\n", args);
  }
  EXPECT_NE(drive("measure-remove 1\n", args).code, 0);
}

/// What a click on an eye of the tree does, and what is odd about a model.
TEST_F(ViewScript, PartsOfTheTreeAreHiddenAndShown) {
  const std::string model = write("odd.obj", read_bytes(boxes()) + "o flat\nv 0 0 0\nv 1 1 1\nv 2 2 2\nf 33 34 35\n");
  const Args args{model, "--size", "800x500", "--scale", "1"};
  expect_driven(
      "toggle-part odd.obj/left\nexpect /hidden = 1\ntoggle-part odd.obj/right\nexpect /hidden = 2\n"
      "toggle-part odd.obj/left\nexpect /hidden = 1\nundo\nexpect /hidden = 2\n",
      args);
  EXPECT_NE(drive("toggle-part odd.obj/nothing\n", args).code, 0);
  EXPECT_NE(drive("select-finding 9\n", args).code, 0);
  // The eye of the first row, at the right end of the panel.
  expect_driven("click 199 94\nexpect /hidden > 3\nclick 199 94\nexpect /hidden = 0\nexpect /selection/count = 0\n",
                args);
}

/// While no model is open, a click on a file that was open before opens it again.
TEST_F(ViewScript, TheStartPageOpensRecentModels) {
  const Args args{"--size",     "800x600",
                  "--scale",    "1",
                  "--settings", write("settings.json", Json({{"recent", {path("gone.obj"), boxes()}}}).dump())};
  expect_driven("click 290 240\nexpect /model = []\nclick 440 240\nexpect /items = 4\n", args);
}

/// Kept for the next time, as the tab of what the culler does, which is off at first.
TEST_F(ViewScript, UnitsAreKept) {
  const Args args{boxes(), "--size", "800x500", "--settings", path("settings.json")};
  expect_driven(
      "expect /units = auto\nexpect /diagnostics = false\nunits-ft\ndiagnostics\nexpect /units = ft\n"
      "front\nmove 376 262\nexpect /cursor/1 < -0.99\nmove 230 80\nexpect /cursor = null\n",
      args);
  expect_driven("expect /units = ft\nexpect /diagnostics = true\nunits-auto\n", args);
  expect_driven("expect /units = auto\n", args);
}

}  // namespace
}  // namespace sightline::tests::view_gui_test
