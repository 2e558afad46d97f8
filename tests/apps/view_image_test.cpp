// Images of sightline-view: in motion, at rest, and beside a frozen camera. Skipped without Xvfb.
#include "sightline/tests/apps/view_window.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::tests::view_image_test {
namespace {

int magenta_pixels(const Image& image) {
  int count = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
    const int red = image.rgb[i], green = image.rgb[i + 1], blue = image.rgb[i + 2];
    count += red > 60 && 5 * green < 2 * blue && 5 * blue > 2 * red && red > blue;
  }
  return count;
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
  const std::size_t changed = differing(lines, plain);
  EXPECT_GT(changed, 500u);
  EXPECT_LT(changed, 600u * 400u / 4u);
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
                      "\nwait 0.5\nexpect /playing = true\nexpect /lod_error = " + moving +
                      "\npress escape\nfront\nwait 0.5\nexpect /lod_error = 0\nscreenshot " + shot +
                      "\nexpect /culling/loss/lod_error = 0\n",
                  {model, "--size", "300x200", "--no-panels"});
    return read_png(shot);
  };
  const Image exact = expect(meshes, "expect /levels = false\n", "0");
  EXPECT_LE(differing(expect(meshes, "lod-error 8\nexpect /levels = true\n", "8"), exact), kTies);
  EXPECT_LE(differing(expect(meshes, "lod-error 8\nlevels\nexpect /levels = false\n", "0"), exact), kTies);
  expect(solids, "lod-error 8\n", "0");
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

/// Exact surfaces: finer the nearer one comes, and as they were for an export and a comparison.
TEST_F(ViewScript, FacetsThatShowBecomeFiner) {
  const std::string model = data_path("machined.stp").string(), near = "zoom-in\nzoom-in\nzoom-in\nzoom-in\nzoom-in\n";
  if (run("info", {model}).code != 0) GTEST_SKIP() << "built without STEP";
  ASSERT_EQ(run("convert", {model, path("whole.stl")}).code, 0);
  expect_driven("expect /finer_meshes = 0\n" + near + "expect /finer_meshes = 0\nsmooth\nexpect /finer_meshes = 1\n" +
                    "export-model " + path("zoomed.stl") + "\nexpect /finer_meshes = 1\ncompare " + model +
                    "\nexpect /compare/changed = 0\nexpect /compare/unchanged = 2\nexpect /finer_meshes = 0\n",
                {model, "--size", "800x600", "--no-panels"});
  EXPECT_TRUE(read_bytes(path("whole.stl")) == read_bytes(path("zoomed.stl")));
}

}  // namespace
}  // namespace sightline::tests::view_image_test
