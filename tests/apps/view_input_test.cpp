// What mouse, keys and panels of sightline-view do to camera, selection, marks and views. Skipped without Xvfb.
#include "sightline/tests/apps/view_window.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::tests::view_input_test {
namespace {

TEST_F(ViewScript, SelectsHidesAndUndoes) {
  const std::string model = boxes();
  expect_driven(
      "front\n"
      "expect /items = 4\n"
      "click 300 200\nexpect /selection/count = 1\n"
      "press h\nexpect /hidden = 1\nexpect /selection/count = 0\n"
      "click 300 200\nexpect /selection/count = 1\n"  // what was behind
      "press ctrl+z\npress ctrl+z\nexpect /hidden = 0\nexpect /selection/count = 1\n"
      "press ctrl+shift+z\nexpect /hidden = 1\n"
      "press u\nexpect /hidden = 0\n"
      "press ctrl+a\nexpect /selection/count = 4\n"
      "press escape\nexpect /selection/count = 0\n"
      "find left\nexpect /found = 1\nselect-found\nexpect /selection/count = 1\n"
      "isolate\nexpect /hidden = 3\nshow-all\n"
      "ghost-others\nexpect /ghosts = 3\nshow-all\nexpect /ghosts = 0\n",
      {model, "--size", kSize, "--no-panels"});
}

/// At first parts, here the equipment of nine items in front; what a click takes is known before it. Four pipes of
/// seven items lie wholly in the image.
TEST_F(ViewScript, ClicksSelectWhatTheLevelSays) {
  const Args args{data_path("small_plant.rvm").string(), "--size", "800x500", "--scale", "1"};
  const std::string click = "press escape\nmove 370 300\nmove 370 250\n", after = "click 370 250\nexpect /tab = Item\n";
  expect_driven("find PIPE-1\nselect-found\nfocus\nexpect /level = part\nmeasure\nexpect /tab = Measure\nselect\n" +
                    click + "expect /hovered_items = 9\n" + after + "expect /selection/count = 9\nlevel-item\n" +
                    click + "expect /hovered_items = 1\n" + after + "expect /selection/count = 1\nlevel-assembly\n" +
                    click + after + "expect /selection/count = 37\n" +
                    "click 130 36\nclick 130 60\nexpect /level = item\nlevel-part\n" +
                    "drag 217 55 536 478 ctrl\nexpect /selection/count = 28\n",
                args);
}

TEST_F(ViewScript, DistancesAreOfTwoParts) {
  const Args args{data_path("small_plant.rvm").string(), "--size", kSize, "--no-panels"};
  const std::string two = "find re:/PIPE-[12]$\nselect-found\nexpect /selection/count = 14\n";
  expect_driven(two +
                    "measure-selected\nexpect /measure/list = 1\nexpect /measure/distance > 0\n"
                    "expect /measure/distance < 1\n",
                args);
  EXPECT_EQ(drive(two + "level-item\nmeasure-selected\n", args).code, 1) << "14 items";
}

TEST_F(ViewScript, MenusAreCommandsByTheirWords) {
  const Args args{boxes(), "--size", kSize, "--no-panels"};
  expect_driven(
      "menu Edit, Select all\nexpect /selection/count = 4\nmenu Edit, Clicks select, Files\nexpect /level = file\n"
      "menu Section, Through the middle, Horizontal\nexpect /sections = 1\n"
      "menu View, Add to the views: above: all\nexpect /views/name = \"above: all\"\nmenu File, Open\n"
      "expect /dialog = open\n",
      args);
  for (const char* none : {"menu Edit", "menu Select all", "menu Edit, Nothing"})
    EXPECT_EQ(drive(std::string(none) + "\n", args).code, 1) << none;
}

/// K stands on the nearest floor and looks ahead, though none lies below; without one it says so.
TEST_F(ViewScript, WalkingBeginsOnTheNearestFloor) {
  const Args args{write_boxes("slab.obj", {{"slab", 0, 0, -6, 1}, {"sign", 0, 0, 0, 1}}), "--size", kSize};
  const Json state = state_after("front\nwalk\nexpect /walk = true\n", args);
  const auto message = state["message"].get<std::string>();
  EXPECT_TRUE(message.starts_with("no floor below: the nearest one is ")) << message;
  EXPECT_EQ(state["camera"]["eye"][2], state["camera"]["target"][2]);
  EXPECT_NEAR(state["camera"]["eye"][2].get<double>(), -5.0 + 1.7, 1e-6);
  const Json none = state_after("front\nselect-all\nhide\nwalk\nexpect /walk = false\n", args);
  EXPECT_EQ(none["message"], "there is no floor to walk on, below or beside");
}

/// Ctrl+F takes the former text, so that another one can be typed in its place.
TEST_F(ViewScript, FindSelectsWhatWasSearchedFor) {
  expect_driven(
      "press ctrl+f\ntype left\nexpect /found = 1\npress escape\nfind left\npress ctrl+f\ntype zzz\n"
      "expect /found = 0\n",
      {boxes(), "--size", "800x500", "--scale", "1"});
}

/// The list may show more while a text is typed; what is carried out takes what the text names.
TEST_F(ViewScript, CommandsTakePartsByTheirNames) {
  const std::string model = write_boxes(
      "line.obj", {{"PIPE-2", 0, 0, 0, 1}, {"PIPE-21", 4, 0, 0, 1}, {"pump A", 8, 0, 0, 1}, {"pump B", 12, 0, 0, 1}});
  const Args args{model, "--size", kSize, "--no-panels"};
  expect_driven(
      "find PIPE-2\nexpect /found = 1\nselect-found\nexpect /selection/count = 1\nselect-none\n"
      "find line.obj/PIPE-21\nexpect /found = 1\nfind pump\nexpect /found = 2\n"
      "expect /message = \"\\\"pump\\\": 2 parts by whole words: line.obj/pump A, line.obj/pump B\"\n"
      "find *2*\nexpect /found = 2\nfind Name=pump a\nexpect /found = 1\n"
      "isolate PIPE-2\nexpect /hidden = 3\nshow-all\nhide pump\nexpect /hidden = 2\n"
      "ghost-others PIPE-21\nexpect /ghosts = 3\nshow-all\n"
      "toggle-part PIPE-2\nexpect /hidden = 1\ntoggle-part line.obj/PIPE-2\nexpect /hidden = 0\n",
      args);
  for (const char* none : {"find PIPE-", "hide PIPE-", "toggle-part PIPE-", "isolate re:("}) {
    const Outcome refused = drive(std::string(none) + "\n", args);
    EXPECT_EQ(refused.code, 1) << none << refused;
  }
  EXPECT_NE(drive("find PIP-21\n", args).err.find("no part fits \"PIP-21\"; similar names: PIPE-21"),
            std::string::npos);
}

TEST_F(ViewScript, RectanglesSelectWhatLiesInThem) {
  // From left to right: wholly; from right to left: any part. With the front box in the middle, of 115 pixels or so.
  expect_driven(
      "front\n"
      "drag 200 100 400 300 ctrl\nexpect /selection/count = 2\n"
      "drag 300 190 310 210 ctrl\nexpect /selection/count = 0\n"
      "drag 310 210 300 190 ctrl\nexpect /selection/count = 2\n"
      "drag 1 1 599 399 ctrl\nexpect /selection/count = 4\n"
      "click 300 200 ctrl\nexpect /selection/count = 3\n"
      "click 300 200 shift\nexpect /selection/count = 4\n",
      {boxes(), "--size", kSize, "--no-panels"});
}

TEST_F(ViewScript, ViewsHaveAStatusAndAType) {
  expect_driven(
      "view-add one\nview-status Open\nview-type Clash\nexpect /views/status = Open\nexpect /views/type = Clash\n",
      {boxes(), "--size", kSize});
}

TEST_F(ViewScript, WeighsWhatIsSelected) {
  expect_driven(
      "find front\nselect-found\nweigh 1000\nexpect /tab = Measure\nexpect /measure/rows/items = \"1\"\n"
      "expect /measure/rows/volume = \"8 m³\"\n"
      "measure-angle\nexpect /tool = measure\nmeasure\nexpect /tool = measure\nmeasure\nexpect /tool = select\n",
      {boxes(), "--size", kSize});
}

TEST_F(ViewScript, TheMouseMovesTheCamera) {
  expect_driven(
      "front\n"
      "expect /camera/eye/1 < -5\n"
      "click 10 10\nclick 300 200\nexpect /camera/eye/1 < -5\nselect-none\n"  // no double click: elsewhere
      "move 300 200\nwheel 6\nexpect /camera/eye/1 > -5\n"
      "press backspace\nexpect /camera/eye/1 < -5\n"
      "drag 300 200 500 200\nexpect /camera/eye/0 < -3\n"  // the model follows the hand to the right
      "expect /selection/count = 0\n"
      "press 5\nexpect /camera/eye/2 > 5\n"
      "press p\nexpect /camera/orthographic = true\n"
      "drag 300 200 400 200 middle\nexpect /camera/target/0 < -1\n"
      "press backspace\npress backspace\nexpect /camera/orthographic = false\n"
      "fit\n",
      {boxes(), "--size", kSize, "--no-panels"});
}

TEST_F(ViewScript, MeasuresBetweenMarksAndItems) {
  // Between the front box and the left one lie 4 m along x and 3 m along y.
  expect_driven(
      "top\n"
      "click 300 360\nexpect /selection/count = 1\n"
      "click 100 200 ctrl\nexpect /selection/count = 2\n"
      "measure-selected\nexpect /measure/distance = 5\n"
      "press m\nclick 300 360\nexpect /measure/marks = 1\n"
      "click 300 360\nexpect /measure/marks = 2\nexpect /measure/distance = 0\n"
      "click 300 360\nexpect /measure/marks = 1\n"
      "measure-clear\nexpect /measure/marks = 0\n"
      "press m\npress escape\n",
      {boxes(), "--size", kSize, "--no-panels"});
}

TEST_F(ViewScript, ViewsAreSavedAndComeBack) {
  const std::string view = path("saved.json"), shot = path("shot.png"), again = path("again.png"), model = boxes();
  for (const char* projection : {"", "orthographic\n"}) {
    SCOPED_TRACE(projection);
    expect_driven("front\nmove 300 200\nsection-here\ndrag 300 200 360 230\n" + std::string(projection) + "save-view " +
                      view + "\nscreenshot " + shot + "\n",
                  {model, "--size", kSize, "--no-panels", "--translate", "1000,2000,3000"});
    const Outcome same = compare(shot, {model, "--size", kSize, "--view", view});
    EXPECT_EQ(same.code, 0) << same;
    expect_driven("top\nload-view " + view + "\nexpect /sections = 1\nscreenshot " + again + "\n",
                  {model, "--size", kSize, "--no-panels"});
    const Outcome back = compare(again, {model, "--size", kSize, "--view", view});
    EXPECT_EQ(back.code, 0) << back;
  }
}

/// A list of views comes back from files, also for the model read again, with what was hidden, faint and selected.
TEST_F(ViewScript, KeepsAListOfViews) {
  const std::string model = boxes(), json = path("views.json"), garbage = write("bad.bcfzip", "PK no archive");
  std::vector<std::string> files{json};
#if SIGHTLINE_HAS_BCF
  files.push_back(path("views.bcfzip"));
#endif
  const Args args{model, "--size", kSize, "--no-panels"};
  std::string make =
      "front\nfind left\nselect-found\nhide\nfind right\nselect-found\nview-add First\nview-comment look here\n"
      "expect /views/count = 1\nexpect /views/name = \"First\"\nexpect /views/comment = \"look here\"\n"
      "show-all\nselect-none\nmove 300 200\nsection-here\nfind behind\nselect-found\nghost-others\nview-add\n"
      "expect /views/current = 2\nview-rename Second one\n";
  for (const std::string& file : files) make += "views-save " + file + "\n";
  expect_driven(make, args);
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    expect_driven("views-load " + file +
                      "\nexpect /views/count = 2\nexpect /hidden = 0\n"
                      "view-show First\nexpect /hidden = 1\nexpect /selection/count = 1\nexpect /ghosts = 0\n"
                      "expect /sections = 0\nexpect /views/comment = \"look here\"\n"
                      "view-show Second one\nexpect /hidden = 0\nexpect /ghosts = 3\nexpect /sections = 1\n"
                      "undo\nexpect /hidden = 1\n"
                      "view-delete First\nexpect /views/count = 1\nexpect /views/current = 1\n"
                      "view-delete\nexpect /views/count = 0\nexpect /views/current = 0\n",
                  args);
  }
  EXPECT_NE(drive("view-show nothing\n", args).code, 0);
  EXPECT_NE(drive("views-load " + garbage + "\n", args).code, 0);
}

TEST_F(ViewScript, PanelsShowAndHideAtAnySize) {
  const std::string model = plant(3000), wide = path("wide.png"), small = path("small.png"), bare = path("bare.png");
  expect_driven(
      "expect /panels = true\n"
      "window-shot " +
          wide +
          "\n"
          "press f1\nexpect /dialog = help\npress f1\nexpect /dialog = none\n"
          "driver\nexpect /dialog = driver\ndriver\nexpect /dialog = none\n"
          "resize 500x400\nexpect /window/0 = 500\nwindow-shot " +
          small +
          "\n"
          "press tab\nfit\nexpect /panels = false\nexpect /size/0 = 500\nwindow-shot " +
          bare +
          "\n"
          "theme\n",
      {model, "--size", "700x500"});
  EXPECT_EQ(read_png(wide).width, 700);
  EXPECT_EQ(read_png(small).height, 400);
  const Outcome same = compare(bare, {model, "--size", "500x400"});
  EXPECT_EQ(same.code, 0) << same;
}

/// What is under the cursor has a line in the window, and none in images that are written.
TEST_F(ViewScript, HoveringLeavesTheImage) {
  const std::string with = path("with.png"), without = path("without.png");
  expect_driven("front\nmove 5 5\nexpect /hovered = -1\nwindow-shot " + without + "\nscreenshot " + path("a.png") +
                    "\nmove 300 200\nexpect /hovered >= 0\nwindow-shot " + with + "\nscreenshot " + path("b.png") +
                    "\nclick 300 200\nhide\nmove 300 201\nexpect /hovered >= 0\n",
                {boxes(), "--size", kSize, "--no-panels"});
  EXPECT_EQ(read_png(path("a.png")).rgb, read_png(path("b.png")).rgb);
  EXPECT_EQ(read_png(path("a.png")).rgb, read_png(without).rgb);
  const Image lined = read_png(with), bare = read_png(without);
  int changed = 0;
  for (std::size_t i = 0; i < bare.rgb.size(); i += 3)
    changed += lined.rgb[i + 2] + 100 < bare.rgb[i + 2] && lined.rgb[i] > 240;  // orange
  EXPECT_GT(changed, 300);
  EXPECT_LT(changed, 2000);
}

/// Dragged at once or slowly, and not beyond what leaves room for the image.
TEST_F(ViewScript, PanelsAreAsWideAsOneDragsThem) {
  const std::string settings = path("settings.json");
  expect_driven(
      "expect /image/width = 360\ndrag 241 300 148 300\nexpect /image/width = 453\n"
      "drag 605 300 602 290\nexpect /image/width = 450\n"
      "drag 602 300 12 300\nexpect /image/width = 345\ndrag 148 200 1 200\nexpect /image/width = 375\n",
      {plant(1000), "--size", "900x600", "--scale", "1", "--settings", settings});
  expect_driven("expect /image/width = 375\n",
                {plant(1000), "--size", "900x600", "--scale", "1", "--settings", settings});
}

/// The axes lie in the lower left corner of the image, 56 pixels from its sides; the tree takes 189, the bar 21.
TEST_F(ViewScript, EndsOfTheAxesLeadToViews) {
  const std::string model = boxes(), with = path("with.png"), without = path("without.png"), shot = path("shot.png");
  expect_driven("fit\nexpect /triad = true\nwindow-shot " + with + "\nscreenshot " + shot +
                    "\ntriad\nexpect /triad = false\nwindow-shot " + without + "\nscreenshot " + path("bare.png") +
                    "\n",
                {model, "--size", "700x500"});
  EXPECT_NE(read_png(with).rgb, read_png(without).rgb);
  EXPECT_EQ(read_png(shot).rgb, read_png(path("bare.png")).rgb) << "the image of the model has no axes";
  expect_driven(
      "front\nclick 281 423\nexpect /camera/eye/0 > 5\n"
      "click 245 387\nexpect /camera/eye/2 > 5\n"
      "click 245 423\nexpect /camera/eye/2 < -5\n"
      "expect /selection/count = 0\n",
      {model, "--size", "700x500"});
}

/// A floor and a wall across it: the eye falls to the floor, and the wall stops it.
TEST_F(ViewScript, WalksOnTheFloorUpToTheWall) {
  std::string text;
  int vertex = 0;
  for (const auto& [low, high] : {std::pair{std::array{-6.0, -6.0, -0.2}, std::array{6.0, 6.0, 0.0}},
                                  {std::array{-6.0, 2.0, 0.0}, std::array{6.0, 2.2, 3.0}}}) {
    for (std::size_t i = 0; i < 8; ++i)
      text += "v " + std::to_string(i & 1 ? high[0] : low[0]) + " " + std::to_string(i & 2 ? high[1] : low[1]) + " " +
              std::to_string(i & 4 ? high[2] : low[2]) + "\n";
    for (const auto& f : {std::array{1, 3, 4, 2}, {5, 6, 8, 7}, {1, 2, 6, 5}, {3, 7, 8, 4}, {1, 5, 7, 3}, {2, 4, 8, 6}})
      text += "f " + std::to_string(vertex + f[0]) + " " + std::to_string(vertex + f[1]) + " " +
              std::to_string(vertex + f[2]) + " " + std::to_string(vertex + f[3]) + "\n";
    vertex += 8;
  }
  const std::string view = write("inside.json", R"({"eye": [0, 0.5, 4], "target": [0, 2, 4], "up": [0, 0, 1],
                                                    "fovy_deg": 60, "near": 0.05})");
  expect_driven(
      "load-view " + view +
          "\nexpect /walk = false\nwalk\nexpect /walk = true\nexpect /camera/eye/2 > 1.699\n"
          "expect /camera/eye/2 < 1.701\nhold w 2\nexpect /camera/eye/1 > 1.6\nexpect /camera/eye/1 < 1.75\n"
          "hold s 0.3\nexpect /camera/eye/1 < 1.6\nexpect /camera/eye/2 < 1.701\nexpect /camera/eye/2 > 1.699\n"
          "walk\nexpect /walk = false\n",
      {write("room.obj", text), "--size", kSize, "--no-panels"});
}

}  // namespace
}  // namespace sightline::tests::view_input_test
