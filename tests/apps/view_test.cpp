// sightline-view in a window of a virtual display: images, scripts, real keys. Skipped without Xvfb; keys without
// xdotool.
#include <array>
#include <chrono>
#include <csignal>
#include <optional>

#include <png.h>

#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_test {
namespace {

int magenta_pixels(const Image& image) {
  int count = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const int red = image.rgb[i], green = image.rgb[i + 1], blue = image.rgb[i + 2];
    count += red > 60 && 5 * green < 2 * blue && 5 * blue > 2 * red && red > blue;
  }
  return count;
}

/// Items against the sky: without them the image would be of one colour.
void expect_not_empty(const std::string& file) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&header, file.c_str())) << header.message;
  header.format = PNG_FORMAT_GRAY;
  std::string grey(PNG_IMAGE_SIZE(header), '\0');
  ASSERT_TRUE(png_image_finish_read(&header, nullptr, grey.data(), 0, nullptr)) << header.message;
  EXPECT_GT(std::count_if(grey.begin(), grey.end(), [&](char c) { return c != grey[0]; }), std::ptrdiff_t(100));
}

/// Pixels in which surfaces that coincide may change places when items are drawn in another order.
constexpr std::size_t kTies = 5;

std::size_t differing(const Image& a, const Image& b) {
  if (a.rgb.size() != b.rgb.size()) return a.rgb.size() + b.rgb.size();
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.rgb.size(); i += 3) count += !std::equal(&a.rgb[i], &a.rgb[i] + 3, &b.rgb[i]);
  return count;
}

TEST_F(View, DrawsWhatRenderDraws) {
  const std::string model = plant(12000), shot = path("shot.png");
  for (const char* culler : {"auto", "linear", "gpu", "hybrid"}) {
    SCOPED_TRACE(culler);
    const Json results =
        run_json("view", {model, "--size", "320x200", "--frames", "6", "--culler", culler, "--screenshot", shot});
    EXPECT_EQ(results["frames"], 6);
    EXPECT_EQ(results["size"], Json::array({320, 200}));
    EXPECT_EQ(results["items"], 12000);
    EXPECT_GT(results["visible"], 11000);
    expect_not_empty(shot);
    const Outcome same = compare(shot, {model, "--size", "320x200"});
    EXPECT_EQ(same.code, 0) << same;
  }
}

TEST_F(View, PlaysAPath) {
  const std::string model = plant(3000), shot = path("shot.png"), tour = path("tour.json");
  ASSERT_EQ(run("replay", {model, "--no-render", "--frames", "2", "--save-path", tour}).code, 0);
  for (const Args& moved : {Args{}, Args{"--translate", "3e6,7e6,1e3"}}) {
    Args args = {model, "--size", "200x200", "--path", tour, "--frames", "4", "--screenshot", shot};
    args.insert(args.end(), moved.begin(), moved.end());
    view(args);
    expect_not_empty(shot);
    Args last = {model, "--size", "200x200", "--path", tour, "--frames", "4", "--frame", "3"};
    last.insert(last.end(), moved.begin(), moved.end());
    const Outcome same = compare(shot, last);
    EXPECT_EQ(same.code, 0) << same;
  }
}

TEST_F(View, RefusesWhatItCannotDo) {
  const std::string model = plant(1000);
  expect_usage_error("view", {model, "--frames", "0"}, "--frames");
  expect_usage_error("view", {model, "--size", "0x3"}, "--size");
  expect_failure("view", {model, "--path", path("missing.json")}, "missing.json");
  expect_failure("view", {model, "--frames", "1", "--screenshot", unwritable("a.png")}, "a.png", true);
  for (const char* display : {"", ":54321"}) {
    setenv("DISPLAY", display, 1);
    expect_failure("view", {model, "--frames", "1"}, "no window can be opened");
  }
  unsetenv("DISPLAY");
  expect_failure("view", {model, "--frames", "1"}, "no window can be opened");
}

TEST_F(View, RefusesWhatIsNoModel) {
  const std::string good = plant(1000);
  for (const std::string& file : bad_models()) {
    const std::string name = fs::path(file).filename();
    expect_failure("view", {file, "--frames", "1"}, name, true);
    expect_failure("view", {good, file, "--frames", "1"}, name, true);
  }
  for (const char* bad : {"1,2", "x", "", "nan,0,0", "1,2,3m"})
    expect_usage_error("view", {good, "--translate", bad}, "--translate");
  expect_failure("view", {good, "--translate", "1e300,0,0", "--frames", "1"}, "beyond", true);
}

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

TEST_F(ViewScript, ImagesArePngAndShowSomething) {
  const std::string model = boxes(), image = path("a.png");
  const Args args{model, "--size", kSize, "--no-panels"};
  for (const char* step : {"screenshot ", "window-shot "}) {
    const Outcome refused = drive("screenshot " + image + "\n" + step + path("b.jpg") + "\n", args);
    EXPECT_EQ(refused.code, 1) << refused;
    EXPECT_NE(refused.err.find(":2: " + path("b.jpg") + ": expected a name that ends in .png"), std::string::npos)
        << refused;
    EXPECT_FALSE(fs::exists(image)) << "refused before any work";
  }
  const Outcome sized = drive("screenshot " + path("b.jpg") + " 64x64\n", args);
  EXPECT_EQ(sized.code, 1) << sized;
  const std::string cut = "front\nsection-z\nsection-move 1 -1000\n";
  for (const char* size : {"", " 64x64"}) {
    const Outcome empty = drive(cut + "screenshot " + image + size + "\n", args);
    EXPECT_EQ(empty.code, 1) << empty;
    EXPECT_NE(empty.err.find("the sections leave nothing of the model"), std::string::npos) << empty;
    EXPECT_FALSE(fs::exists(image));
  }
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

TEST_F(ViewScript, CullersAndTheFrozenCamera) {
  const std::string shot = path("frozen.png");
  expect_driven(
      "press alt+2\nexpect /culled_by = gpu\n"
      "press alt+3\nexpect /culler = hybrid\n"
      "press alt+1\nexpect /culled_by = cpu\n"
      "press alt+0\n"
      "press c\nexpect /frozen = true\n"
      "move 100 75\nwheel 8\nscreenshot " +
          shot + "\npress c\nexpect /frozen = false\n",
      {plant(12000), "--size", "200x150", "--no-panels"});
  EXPECT_GT(magenta_pixels(read_png(shot)), 0) << "what the frozen camera sees nothing of";
}

/// Four boxes from a camera that is then left: shown, hidden, cut away; and its boxes come and go with their switches.
TEST_F(ViewScript, AFrozenCameraIsSeenFromOutside) {
  const std::string without = path("without.png"), with = path("with.png"), again = path("again.png");
  expect_driven(
      "front\nzoom-out\nzoom-out\n"  // so that the box about all is inside, too
      "press c\nexpect /culling/occluded = 1\nexpect /culling/inside = 3\nexpect /culling/outside = 0\n"
      "expect /culling/too_small = 0\nexpect /culling/intersecting = 0\n"
      "left\nzoom-out\nzoom-out\nzoom-out\nexpect /culling/occluded = 1\n"
      "expect /culling/boxes = 1\nexpect /culling/drawn = 1\n"  // around the three that are inside
      "boxes occluded\nexpect /culling/boxes = 2\nboxes occluded\nexpect /culling/boxes = 1\nwindow-shot " +
          with + "\npress shift+c\nexpect /culling/boxes = 0\nwindow-shot " + without +
          "\npress shift+c\nexpect /culling/boxes = 1\nwindow-shot " + again +
          "\nfind front\nselect-found\nhide\nexpect /culling/occluded = 0\nexpect /culling/inside = 3\n"
          "undo\nexpect /culling/occluded = 1\n"
          "section-box\nexpect /sections = 6\nexpect /culling/intersecting = 0\nsection-clear\n"  // it only touches
          "section-z\nexpect /culling/intersecting > 0\nsection-clear\n"
          "min-projected-area 1e9\nexpect /culling/too_small = 4\nmin-projected-area 0\nexpect /culling/too_small = 0\n"
          "resize 300x200\nexpect /culling/occluded = 1\n"
          "lose-context\nwait 0.2\nexpect /culling/occluded = 1\n"
          "press c\nexpect /frozen = false\nexpect /culling/loss/items = 0\n",
      {boxes(), "--size", kSize, "--no-panels"});
  const Image lines = read_png(with), plain = read_png(without);
  EXPECT_EQ(lines.rgb, read_png(again).rgb);
  ASSERT_EQ(lines.rgb.size(), plain.rgb.size());
  int changed = 0;
  for (std::size_t i = 0; i < lines.rgb.size(); i += 3)
    changed += !std::equal(lines.rgb.begin() + std::ptrdiff_t(i), lines.rgb.begin() + std::ptrdiff_t(i + 3),
                           plain.rgb.begin() + std::ptrdiff_t(i));
  EXPECT_GT(changed, 500);
  EXPECT_LT(changed, 600 * 400 / 4);
  EXPECT_NE(drive("boxes green\n", {boxes(), "--size", kSize}).code, 0);
}

/// What contribution and budget leave out is told at rest.
TEST_F(ViewScript, TellsWhatIsLost) {
  expect_driven(
      "expect /culling/loss/items = 0\n"
      "min-projected-area 40\nexpect /culling/loss/items > 0\nexpect /culling/loss/pixels > 0\n"
      "min-projected-area 0\nexpect /culling/loss/items = 0\n"
      "budget 5\nexpect /culling/loss/items = 0\n",  // complete, since nothing moves
      {plant(12000), "--size", "200x150", "--no-panels"});
}

/// As sightline-render draws it with the same options, and as without it once it is switched off.
TEST_F(ViewScript, DepthShadingAndWhatIsLeftOut) {
  const std::string model = plant(3000), with = path("with.png"), without = path("without.png");
  expect_driven(
      "expect /depth_shading = false\nfit\npress l\nexpect /depth_shading = true\nscreenshot " + with +
          "\ndepth-shading\nexpect /depth_shading = false\nscreenshot " + without +
          "\nbudget 40\nexpect /budget_ms = 40\nbudget 0\nmin-projected-area 1000000\n"
          "expect /min_projected_area = 1000000\nexpect /drawn = 0\nmin-projected-area 0\nexpect /drawn > 900\n",
      {model, "--size", "200x150", "--no-panels"});
  for (const auto& [shot, args] :
       {std::pair{with, Args{"--depth-shading", "0.4", "--edge-lines", "0.4"}}, {without, Args{}}}) {
    Args all{model, "--size", "200x150"};
    all.insert(all.end(), args.begin(), args.end());
    const Outcome same = compare(shot, all);
    EXPECT_EQ(same.code, 0) << same;
  }
  const Outcome refused = drive("budget -1\n", {model});
  EXPECT_EQ(refused.code, 1) << refused;
  EXPECT_NE(refused.err.find("budget_ms"), std::string::npos) << refused;
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

/// Each pixel of the smooth image lies between those of sharp ones; on edges it is none of them.
TEST_F(ViewScript, EdgesBecomeSmoothAtRest) {
  const std::string sharp = path("sharp.png"), smooth = path("smooth.png"), many = path("many.png");
  const std::string model = boxes();
  for (const char* projection : {"", "orthographic\n"})
    expect_driven("expect /smooth = false\ndrag 300 200 330 190 right\n" + std::string(projection) + "screenshot " +
                      sharp + "\nsmooth\nscreenshot " + smooth + "\n",
                  {model, "--size", kSize, "--no-panels"});
  expect_driven("drag 300 200 330 190 right\northographic\nscreenshot " + many + "\n",
                {model, "--size", kSize, "--no-panels", "--samples", "4"});
  const Image a = read_png(sharp), b = read_png(smooth), reference = read_png(many);
  ASSERT_EQ(a.rgb.size(), b.rgb.size());
  ASSERT_EQ(a.rgb.size(), reference.rgb.size());
  double sharp_error = 0.0, smooth_error = 0.0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) {
    sharp_error += std::abs(int(a.rgb[i]) - int(reference.rgb[i]));
    smooth_error += std::abs(int(b.rgb[i]) - int(reference.rgb[i]));
  }
  EXPECT_GT(sharp_error, 0.0);
  EXPECT_LT(smooth_error, 0.5 * sharp_error) << smooth_error << " of " << sharp_error;
}

/// A budget and pixels left out while the view moves leave the image at rest as it is.
TEST_F(ViewScript, MotionAtLessQualityEndsInTheSameImage) {
  const std::string model = plant(3000);
  std::vector<Image> images;
  for (const char* budget : {"0", "1"}) {
    const std::string file = path("at-rest.png");
    expect_driven(
        "smooth\nexpect /lower = true\ndrag 300 200 380 230\nexpect /response_ms > 0\nscreenshot " + file + "\n",
        {model, "--size", kSize, "--no-panels", "--budget-ms", budget});
    images.push_back(read_png(file));
  }
  const std::string file = path("same.png");
  expect_driven("smooth\nlower-resolution\nexpect /lower = false\ndrag 300 200 380 230\nscreenshot " + file + "\n",
                {model, "--size", kSize, "--no-panels"});
  EXPECT_EQ(read_png(file).rgb, images[0].rgb);
  EXPECT_EQ(images[1].rgb, images[0].rgb);
}

/// Levels of detail are drawn while the view moves alone, and only where there are meshes.
TEST_F(ViewScript, MeshesAreCoarserInMotionAlone) {
  const std::string solids = plant(1000), meshes = path("meshes.obj"), tour = path("tour.json");
  ASSERT_EQ(run("convert", {solids, meshes}).code, 0);
  ASSERT_EQ(run("replay", {solids, "--no-render", "--frames", "2", "--save-path", tour}).code, 0);
  const auto expect = [&](const std::string& model, const std::string& first, const std::string& moving) {
    const std::string shot = path("at-rest.png");
    expect_driven(first + "wait 1\nexpect /lod_error = 0\npath-loop\nplay-path " + tour +
                      "\nwait 1\nexpect /playing = true\nexpect /lod_error = " + moving +
                      "\npress escape\nfront\nwait 0.5\nexpect /lod_error = 0\nscreenshot " + shot +
                      "\nexpect /culling/loss/lod_error = 0\n",
                  {model, "--size", kSize, "--no-panels"});
    return read_png(shot);
  };
  const Image exact = expect(meshes, "expect /levels = false\n", "0");
  EXPECT_LE(differing(expect(meshes, "lod-error 8\nexpect /levels = true\n", "8"), exact), kTies);
  EXPECT_LE(differing(expect(meshes, "lod-error 8\nlevels\nexpect /levels = false\n", "0"), exact), kTies);
  expect(solids, "lod-error 8\n", "0");
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

/// The window shows the last image of a motion until the one at rest is complete, and then that one.
TEST_F(ViewScript, ShowsTheCompleteImageAfterAMotion) {
  std::vector<Image> shots;
  for (const char* budget : {"0", "0.1"}) {
    const std::string file = path("window.png");
    expect_driven("levels\ndrag 300 200 380 230\nmove 590 390\nwait 0.5\nwindow-shot " + file + "\n",
                  {plant(3000), "--size", kSize, "--no-panels", "--budget-ms", budget, "--depth-shading", "0.5"});
    shots.push_back(read_png(file));
  }
  EXPECT_EQ(shots[0].rgb, shots[1].rgb);
}

/// On a software rasteriser, and for people alone: scripts have the budget that they ask for.
TEST_F(ViewScript, FramesHaveABudgetUnlessTheGpuCulls) {
  const std::string model = plant(1000), settings = path("settings.json");
  const auto state_with = [&](const std::string& script, Args args) {
    args.insert(args.begin(), {model, "--size", kSize});
    return state_after(script, args);
  };
  EXPECT_EQ(state_with("", {})["budget_ms"], 0.0);
  const Json state = state_with("", {"--settings", settings});
  if (state["renderer"].get<std::string>().find("llvmpipe") == std::string::npos) GTEST_SKIP() << "a GPU";
  EXPECT_EQ(state["budget_ms"], 33.0);
  EXPECT_EQ(state_with("", {"--settings", settings, "--budget-ms", "0"})["budget_ms"], 0.0);
  EXPECT_EQ(state_with("", {"--settings", settings, "--budget-ms", "50"})["budget_ms"], 50.0);
  EXPECT_EQ(state_with("", {"--settings", settings, "--culler", "hybrid"})["budget_ms"], 0.0);
  EXPECT_EQ(state_with("cull-gpu\n", {"--settings", settings})["budget_ms"], 0.0);
  EXPECT_EQ(state_with("cull-cpu\n", {"--settings", settings})["budget_ms"], 33.0);
}

/// Each step of opening takes its time, and none is left at the end.
TEST_F(ViewScript, TellsTheStepsOfOpening) {
  const Json opening = state_after("", {plant(3000), "--size", kSize})["opening"];
  EXPECT_EQ(opening["step"], "");
  for (const char* step : {"reading", "building", "uploading", "drawing"})
    EXPECT_GT(opening[std::string(step) + "_ms"], 0.0) << step;
  EXPECT_GE(opening["portions"], 3);
}

/// Its last line is carried out, too.
TEST_F(ViewScript, WaitsInItsLastLine) {
  const auto begin = std::chrono::steady_clock::now();
  expect_driven("expect /pause_ms >= 0\nwait 1.5", {boxes(), "--size", kSize});
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(1500));
}

/// Clicks, drags and turns of the wheel that come before picks are ready are carried out, and another model lands while
/// one is open.
TEST_F(ViewScript, AModelIsThereOnceItHasLanded) {
  const std::string model = plant(30'000), first = path("first.png"), other = path("other.png"),
                    twin = path("twin.png");
  expect_driven("screenshot " + first + "\nclick 300 200\nexpect /selection/count = 1\nopen " + boxes() +
                    "\nexpect /items = 4\nexpect /selection/count = 0\nopen " + model +
                    "\nexpect /items > 20000\nscreenshot " + other +
                    "\nselect-all\nhide\nundo\nselect-none\nscreenshot " + twin +
                    "\nlose-context\nwait 0.2\nexpect /recovered = 1\nexpect /items > 20000\n",
                {model, "--size", kSize, "--no-panels"});
  EXPECT_EQ(read_png(first).rgb, read_png(other).rgb);
  EXPECT_LE(differing(read_png(first), read_png(twin)), kTies);
}

TEST_F(ViewScript, RecordsAPathThatCanBePlayed) {
  const std::string model = plant(3000), saved = path("walk.json");
  expect_driven("record\nexpect /recording = true\nfront\nwait 0.4\ntop\nrecord\nexpect /recording = false\n",
                {model, "--size", "200x150", "--save-path", saved});
  const Json walk = json::parse(read_bytes(saved)).value();
  ASSERT_TRUE(walk.is_object());
  ASSERT_GE(walk["keys"].size(), 2u);
  EXPECT_EQ(walk["keys"].front()["t"], 0.0);
  EXPECT_NE(walk["keys"].front()["eye"], walk["keys"].back()["eye"]);
  EXPECT_EQ(run("replay", {model, "--no-render", "--frames", "3", "--path", saved}).code, 0);
}

/// In the window's size as at once; in other sizes, by tiles, as sightline-render draws them.
TEST_F(ViewScript, WritesImagesOfAnySize) {
  const std::string model = plant(3000), seen = path("seen.json");
  const auto shot = [&](const char* name) { return path(name) + ".png"; };
  expect_driven("drag 300 200 330 190 right\nmove 1 1\nsave-view " + seen + "\nscreenshot " + shot("at once") +
                    "\nscreenshot " + shot("in steps") + " 600x400\nexpect /message = \"image: " + shot("in steps") +
                    "\"\ndepth-shading\nsmooth\nscreenshot " + shot("smooth") + "\nscreenshot " + shot("smooth steps") +
                    " 600x400\nsmooth\nbudget 5\nscreenshot " + shot("wide") + " 2500x300\nexpect /budget_ms = 5\n" +
                    "expect /size/0 = 600\nbudget 0\nscreenshot " + shot("again") + "\nscreenshot " + shot("last") +
                    " 64x32\n",
                {model, "--size", kSize, "--no-panels"});
  EXPECT_EQ(read_png(shot("at once")).rgb, read_png(shot("in steps")).rgb);
  EXPECT_EQ(read_png(shot("last")).width, 64) << "a script waits for its last image";
  const Image a = read_png(shot("smooth")), b = read_png(shot("smooth steps"));
  ASSERT_EQ(a.rgb.size(), b.rgb.size());
  double error = 0.0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) error += std::abs(int(a.rgb[i]) - int(b.rgb[i]));
  EXPECT_LT(error / double(a.rgb.size()), 0.01);
  const Args depth_shading = {"--view", seen, "--depth-shading", "0.4", "--edge-lines", "0.4"};
  for (const auto& [name, size] : {std::pair("wide", "2500x300"), {"again", kSize}}) {
    Args args = {model, "--size", size};
    args.insert(args.end(), depth_shading.begin(), depth_shading.end());
    const Outcome same = compare(shot(name), args);
    EXPECT_EQ(same.code, 0) << name << "\n" << same;
  }
}

TEST_F(ViewScript, PlaysPathsAndWritesTheirFrames) {
  const std::string model = boxes(), folder = path("frames");
  const std::string flight =
      write("flight.json", R"({"keys":[{"t":2,"eye":[0,-30,6],"target":[0,5,0],"up":[0,0,1],"fovy_deg":40},)"
                           R"({"t":2.5,"eye":[9,-25,9],"target":[0,5,0],"up":[0,0,1],"fovy_deg":50}],"near":0.1})");
  expect_driven("orthographic\nplay-path " + flight +
                    "\nexpect /playing = false\nexpect /camera/eye/0 = 9.0\nexpect /camera/orthographic = false\n"
                    "select-all\npath-loop\npath-speed 0.5\nplay-path\nwait 0.2\nexpect /playing = true\npress escape\n"
                    "expect /playing = false\nexpect /selection/count = 4\nplay-path\nwheel 1\nwait 0.1\nexpect "
                    "/playing = false\n"
                    "select-none\nplay-path\nplay-path\nexpect /playing = false\nfront\nwrite-frames " +
                    folder + " 4 240x160\nexpect /message = \"3 frames: " + folder + "\"\nexpect /camera/eye/0 = 0.0\n",
                {model, "--size", kSize, "--no-panels"});
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 3);
  for (int i = 0; i < 3; ++i) {
    const Outcome same =
        compare(folder + "/frame-00000" + std::to_string(i + 1) + ".png",
                {model, "--size", "240x160", "--path", flight, "--frames", "3", "--frame", std::to_string(i)});
    EXPECT_EQ(same.code, 0) << same;
  }
  const std::string two = path("recorded");
  expect_driven("record\nfront\nwait 0.3\ntop\nrecord\nwrite-frames " + two + " 10\n",
                {model, "--size", kSize, "--save-path", path("walk.json")});
  EXPECT_GE(std::distance(fs::directory_iterator(two), {}), 3) << "of what was recorded";
}

TEST_F(ViewScript, RefusesImagesAndFramesThatCannotBe) {
  const std::string model = boxes(), flight = path("flight.json"), folder = path("used");
  ASSERT_EQ(run("replay", {model, "--no-render", "--frames", "2", "--save-path", flight}).code, 0);
  fs::create_directory(folder);
  write("used/file", "");
  const std::string play = "path-speed 100\nplay-path " + flight + "\n";
  for (const auto& [script, message] :
       {std::pair<std::string, std::string>{"screenshot a.png 20000x20000\n", "between 1 and 16384"},
        {"screenshot a.png 0x0\n", "between 1 and 16384"},
        {"screenshot a.png -5x5\n", "between 1 and 16384"},
        {"screenshot /no/such/a.png 64x64\n", "/no/such/a.png: cannot be written"},
        {"write-frames " + path("new") + "\n", "record or play a camera path first"},
        {"play-path\n", "record a camera path first"},
        {"play-path " + model + "\n", "boxes.obj"},
        {play + "write-frames\n", "expected FOLDER"},
        {play + "write-frames " + folder + "\n", "is not empty"},
        {play + "write-frames " + folder + "/file/below\n", "below"},
        {play + "write-frames " + path("new") + " 0\n", "frames per second"},
        {play + "write-frames " + path("new") + " 25 1x99999\n", "between 1 and 16384"},
        {"path-speed 0\n", "between 0.01 and 100"}}) {
    const Outcome outcome = drive(script, {model, "--size", "200x150"});
    EXPECT_EQ(outcome.code, 1) << script << outcome;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << script << outcome;
  }
}

TEST_F(ViewScript, AFileThatCannotBeReadLeavesTheModelOpen) {
  const std::string broken = write("broken.rvm", "no model");
  expect_driven("open " + broken +
                    "\nexpect /items = 4\nexpect /message != reading\n"
                    "click 300 200\n",
                {boxes(), "--size", kSize});
}

TEST_F(ViewScript, FailsWhereTheScriptExpectsOtherwise) {
  const std::string model = boxes();
  for (const auto& [script, message] :
       {std::pair<std::string, std::string>{"fit\nexpect /items = 5\n", ":2: expected /items = 5, found 4"},
        {"nonsense\n", ":1: no command nonsense"},
        {"expect /nothing = 1\n", "no /nothing"},
        {"click 3\n", "click: expected"},
        {"hide\n", "select something first"}}) {
    const Outcome outcome = drive(script, {model, "--size", "200x150"});
    EXPECT_EQ(outcome.code, 1) << outcome;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome;
  }
}

/// The image is the same after the context was made anew, and all that the user has done is still there.
TEST_F(ViewScript, ALostContextIsMadeAnew) {
  const std::string before = path("before.png"), after = path("after.png"), model = boxes();
  for (const char* culler : {"cpu", "gpu"}) {
    SCOPED_TRACE(culler);
    expect_driven("front\nclick 282 214\nmove 282 214\nsection-here\ndrag 300 200 360 230\nsmooth\nscreenshot " +
                      before +
                      "\nlose-context\nexpect /recovered = 1\nexpect /selection/count = 1\nexpect /sections = 1\n"
                      "expect /window/0 = 600\nexpect /window/1 = 400\nscreenshot " +
                      after + "\nlose-context\nundo\nexpect /selection/count = 0\nexpect /recovered = 2\n",
                  {model, "--size", kSize, "--culler", culler});
    EXPECT_EQ(read_png(before).rgb, read_png(after).rgb);
  }
  expect_driven("lose-context\nexpect /recovered = 1\n", {"--size", kSize});
}

TEST_F(View, SaysWhatOpenGLThereIsAndWhatItNeeds) {
  setenv("MESA_GL_VERSION_OVERRIDE", "3.3", 1);
  const Outcome outcome = run("view", {plant(1000), "--frames", "1"});
  unsetenv("MESA_GL_VERSION_OVERRIDE");
  if (outcome.code == 0) GTEST_SKIP() << "not Mesa's driver";
  EXPECT_EQ(outcome.code, 1) << outcome;
  for (const char* words : {"OpenGL 4.5 core", "the display offers 3.3"})
    EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome;
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
  const std::string view = write("inside.json", R"({"eye": [0, -2, 4], "target": [0, 2, 4], "up": [0, 0, 1],
                                                    "fovy_deg": 60, "near": 0.05})");
  expect_driven(
      "load-view " + view +
          "\nexpect /walk = false\nwalk\nexpect /walk = true\nexpect /camera/eye/2 > 1.699\n"
          "expect /camera/eye/2 < 1.701\nhold w 6\nexpect /camera/eye/1 > 1.6\nexpect /camera/eye/1 < 1.75\n"
          "hold s 0.3\nexpect /camera/eye/1 < 1.6\nexpect /camera/eye/2 < 1.701\nexpect /camera/eye/2 > 1.699\n"
          "walk\nexpect /walk = false\n",
      {write("room.obj", text), "--size", kSize, "--no-panels"});
}

TEST_F(ViewScript, SettingsAreKeptInTheNamedFileAlone) {
  const std::string model = boxes(), mine = path("config/mine.json"), own = path("sightline/view.json");
  setenv("XDG_CONFIG_HOME", path("").c_str(), 1);
  expect_driven("theme\npanels\nresize 500x400\nexpect /theme = light\n", {model, "--size", kSize});
  EXPECT_FALSE(fs::exists(own));
  const Args named = {model, "--settings", mine};
  expect_driven("expect /smooth = true\ntheme\npanels\nsmooth\nresize 500x400\nexpect /window/0 = 500\n", named);
  EXPECT_FALSE(fs::exists(own));
  expect_driven(
      "expect /theme = light\nexpect /panels = false\nexpect /smooth = false\nexpect /window/0 = 500\n"
      "expect /recent/0 = " +
          model + "\n",
      named);
  const std::string kept = read_bytes(mine);
  expect_driven("expect /theme = dark\nexpect /panels = false\n", {model, "--settings", mine, "--theme", "dark"});
  EXPECT_EQ(read_bytes(mine), kept) << "what the command line says is not kept";
  write("config/mine.json", "{");
  expect_driven("expect /theme = dark\nexpect /panels = true\n", {"--settings", mine});
  EXPECT_EQ(read_bytes(mine), "{") << "nothing was changed";
  expect_driven("expect /message = \"" + mine + ": expected a JSON object\"\ntheme\n", named);
  EXPECT_EQ(json::parse(read_bytes(mine)).value(), Json({{"theme", "light"}, {"recent", {model}}}));
  unsetenv("XDG_CONFIG_HOME");
}

TEST_F(ViewScript, SettingsNameAFolderOfCaches) {
  const std::string model = boxes(), folder = path("caches"), other = path("others");
  Args args = {model, "--settings", write("mine.json", Json({{"cache", folder}}).dump())};
  const auto count = [](const std::string& where) {
    return fs::exists(where) ? std::distance(fs::directory_iterator(where), fs::directory_iterator()) : 0;
  };
  expect_driven("wait 0\n", args);
  EXPECT_EQ(count(folder), SIGHTLINE_HAS_SLC);
  fs::remove_all(folder);
  args.insert(args.end(), {"--cache", other});
  expect_driven("wait 0\n", args);
  EXPECT_EQ(count(folder), 0) << "the command line goes before";
  EXPECT_EQ(count(other), SIGHTLINE_HAS_SLC);
}

TEST_F(ViewScript, FilesThatDoNotSayMayBeTurned) {
  const std::string model = write("standing.obj",
                                  "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0.5 2 0.5\n"
                                  "f 1 2 3 4\nf 2 1 5\nf 3 2 5\nf 4 3 5\nf 1 4 5\n"),
                    turned = path("turned.png");
  expect_driven(
      "expect /y_up = true\nexpect /message = \"1 items; y seems to point up, so it is turned: File, Y is up\"\n"
      "y-up\nexpect /y_up = false\nexpect /message = \"1 items\"\nscreenshot " +
          turned + "\n",
      {model, "--size", "200x150", "--no-panels"});
  const Outcome same = compare(turned, {model, "--size", "200x150", "--up", "z"});
  EXPECT_EQ(same.code, 0) << same;
}

TEST_F(ViewScript, PrimitivesAreRecognisedWhereThatIsSwitchedOn) {
  const std::string model = boxes(),
                    same = "compare " + model + "\nexpect /message = \"nothing has changed since boxes.obj\"\n";
  const std::string found = "expect /recognition/items/box = 4\n", none = "expect /recognition/meshes = 0\n";
  const Args named = {model, "--settings", path("mine.json")};
  expect_driven("expect /recognise = false\n" + none + "recognise\n" + none + "open " + model + "\n" + found +
                    "expect /message = \"4 items, 4 of them recognised in meshes\"\n" +
                    "expect /recognition/triangles_after = 0\n",
                named);
  expect_driven("expect /recognise = true\n" + found, named);
  // What is open is compared as it was read, however the switch is now.
  expect_driven("recognise\n" + same + "open " + model + "\n" + none + "recognise\n" + same, named);
  const std::string kept = read_bytes(path("mine.json"));
  EXPECT_EQ(json::parse(kept).value()["recognise"], true);
  expect_driven("expect /recognise = true\n" + found, {model, "--recognise"});
  expect_driven("expect /recognise = false\n" + none, {model});
  EXPECT_EQ(read_bytes(path("mine.json")), kept);
}

/// A window that stays open, and somebody at its keyboard.
class ViewKeys : public View {
 protected:
  void SetUp() override {
    View::SetUp();
    if (!IsSkipped() && !HasFatalFailure()) need("xdotool", {"version"});
  }
  void TearDown() override {
    if (child_.pid != 0) {
      kill(child_.pid, SIGTERM);
      wait_for(child_);
    }
    unsetenv("XDG_CONFIG_HOME");
    View::TearDown();
  }

  void open(const Args& args) {
    setenv("XDG_CONFIG_HOME", path("").c_str(), 1);
    child_ = start_program(program_of("view"), args, "view");
    ASSERT_TRUE(comes_true([&] {
      const Outcome found = xdotool({"search", "--name", " - Sightline"});
      window_ = found.out.substr(0, found.out.find('\n'));
      return !window_.empty();
    })) << read_bytes(child_.err);
    ASSERT_EQ(xdotool({"windowfocus", "--sync", window_}).code, 0);
  }
  Outcome xdotool(const Args& args) const { return run_program("xdotool", args); }
  void press(const std::string& key) const { EXPECT_EQ(xdotool({"key", key}).code, 0); }

  Child child_;
  std::string window_;
};

/// Real keys reach the commands, the window follows its size, and the screen shows the image.
TEST_F(ViewKeys, TheWindowShowsTheImageAtAnySize) {
  const std::string model = plant(3000), results = path("figures.json");
  open({model, "--size", "320x200", "--no-panels", "--no-smooth", "--plain", "--depth-shading", "0.4", "--edge-lines",
        "0.4", "--json", results});
  for (const std::array<int, 2>& wanted : {std::array{320, 200}, {200, 300}, {500, 400}}) {
    const int width = wanted[0], height = wanted[1];
    const std::string size = std::to_string(width) + "x" + std::to_string(height);
    SCOPED_TRACE(size);
    ASSERT_EQ(xdotool({"windowsize", window_, std::to_string(width), std::to_string(height)}).code, 0);
    Outcome same;
    ASSERT_TRUE(comes_true([&] {
      press("Home");
      same = compare(screen(width, height), {model, "--size", size, "--depth-shading", "0.4", "--edge-lines", "0.4"});
      return same.code == 0;
    })) << same;
  }
  xdotool({"keydown", "w"});
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  xdotool({"keyup", "w"});
  press("ctrl+q");
  const Outcome outcome = wait_for(child_);
  child_.pid = 0;
  EXPECT_EQ(outcome.code, 0) << outcome;
  const Json state = json::parse(read_bytes(results)).value();
  EXPECT_EQ(state["size"], Json::array({500, 400}));
  EXPECT_GT(state["frames"], 4);
  const Json kept = json::parse(read_bytes(path("sightline/view.json"))).value();
  EXPECT_EQ(kept["window"], Json::array({500, 400}));
  EXPECT_EQ(kept["recent"], Json::array({model}));
  EXPECT_FALSE(kept.contains("panels")) << "nobody has switched them";
}

/// The first attempt asks, the second one quits.
TEST_F(ViewKeys, QuittingAsksOnceForUnsavedViews) {
  const auto runs = [&] {
    siginfo_t ended{};
    return waitid(P_PID, id_t(child_.pid), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == 0;
  };
  const auto shown = [&] { return read_screen(path("Xvfb_screen0"), 640, 480).rgb; };
  open({plant(1000), "--size", "640x480", "--no-smooth"});
  const auto empty = shown();
  ASSERT_TRUE(comes_true([&] { return press("v"), shown() != empty; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const auto before = shown();
  press("ctrl+q");
  ASSERT_TRUE(comes_true([&] { return shown() != before; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  screen(640, 480);
  ASSERT_TRUE(runs()) << "it asks";
  press("ctrl+q");
  const Outcome outcome = wait_for(child_);
  child_.pid = 0;
  EXPECT_EQ(outcome.code, 0) << outcome;
}

/// Nothing is left of an image that is cancelled, and the window goes on as before.
TEST_F(ViewKeys, EscapeCancelsAnImage) {
  const std::string huge = path("huge.png"), after = path("after.png"), model = plant(3000);
  open({model, "--size", "320x200", "--no-panels", "--script",
        write("script.txt", "smooth\nscreenshot " + huge + " 16384x16384\nexpect /message = \"cancelled, image: " +
                                huge + "\"\nsmooth\nscreenshot " + after + "\n")});
  const auto parts = [&] {
    return std::count_if(
        fs::directory_iterator(path("")), fs::directory_iterator(),
        [](const fs::directory_entry& entry) { return entry.path().filename().string().starts_with("huge.png"); });
  };
  ASSERT_TRUE(comes_true([&] { return parts() == 1; })) << read_bytes(child_.err);
  EXPECT_TRUE(comes_true([&] {
    xdotool({"key", "Escape"});
    return fs::exists(after);
  }));
  const Outcome outcome = wait_for(child_);
  child_.pid = 0;
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_EQ(parts(), 0);
  const Outcome same = compare(after, {model, "--size", "320x200"});
  EXPECT_EQ(same.code, 0) << same;
}

}  // namespace
}  // namespace sightline::tests::view_test
