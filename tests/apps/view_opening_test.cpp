// sightline-view opens models, and opens them as settings say. Skipped without Xvfb.
#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_opening_test {
namespace {

/// Each step of opening takes its time, and none is left at the end.
TEST_F(ViewScript, TellsTheStepsOfOpening) {
  const Json opening = state_after("", {plant(3000), "--size", kSize})["opening"];
  EXPECT_EQ(opening["step"], "");
  for (const char* step : {"reading", "building", "uploading", "drawing"})
    EXPECT_GT(opening[std::string(step) + "_ms"], 0.0) << step;
  EXPECT_GE(opening["portions"], 3);
}

/// Clicks, drags and turns of the wheel that come before picks are ready are carried out, and another model lands while
/// one is open.
TEST_F(ViewScript, AModelIsThereOnceItHasLanded) {
  const std::string model = plant(30'000), first = path("first.png"), other = path("other.png"),
                    twin = path("twin.png");
  expect_driven("level-item\nscreenshot " + first + "\nclick 300 200\nexpect /selection/count = 1\nopen " + boxes() +
                    "\nexpect /items = 4\nexpect /selection/count = 0\nopen " + model +
                    "\nexpect /items > 20000\nscreenshot " + other +
                    "\nselect-all\nhide\nundo\nselect-none\nscreenshot " + twin +
                    "\nlose-context\nwait 0.2\nexpect /recovered = 1\nexpect /items > 20000\n",
                {model, "--size", kSize, "--no-panels"});
  EXPECT_EQ(read_png(first).rgb, read_png(other).rgb);
  EXPECT_LE(differing(read_png(first), read_png(twin)), kTies);
}

TEST_F(ViewScript, AFileThatCannotBeReadLeavesTheModelOpen) {
  const std::string broken = write("broken.rvm", "no model");
  expect_driven("open " + broken +
                    "\nexpect /items = 4\nexpect /message != reading\n"
                    "click 300 200\n",
                {boxes(), "--size", kSize});
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

TEST_F(ViewScript, SettingsAreKeptInTheNamedFileAlone) {
  const std::string model = boxes(), mine = path("config/mine.json"), own = path("sightline/view.json");
  const Variable settings("XDG_CONFIG_HOME", path(""));
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
  const Args named = {model, "--settings", path("mine.json"), "--size", "200x150"};
  expect_driven("expect /recognise = false\n" + none + "recognise\n" + none + "open " + model + "\n" + found +
                    "expect /message = \"4 items, 4 of them recognised in meshes\"\n" +
                    "expect /recognition/triangles_after = 0\n",
                named);
  expect_driven("expect /recognise = true\n" + found, named);
  // What is open is compared as it was read, however the switch is now.
  expect_driven("recognise\n" + same + "open " + model + "\n" + none + "recognise\n" + same, named);
  const std::string kept = read_bytes(path("mine.json"));
  EXPECT_EQ(json::parse(kept).value()["recognise"], true);
  expect_driven("expect /recognise = true\n" + found, {model, "--recognise", "--size", "200x150"});
  expect_driven("expect /recognise = false\n" + none, {model, "--size", "200x150"});
  EXPECT_EQ(read_bytes(path("mine.json")), kept);
}

}  // namespace
}  // namespace sightline::tests::view_opening_test
