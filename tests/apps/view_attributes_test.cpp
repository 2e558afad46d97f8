// Attributes in sightline-view: colours, the legend, searches by conditions, sets. Skipped without Xvfb.
#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_attributes_test {
namespace {

/// Two of the four boxes are one part.
class ViewAttributes : public ViewScript {
 protected:
  std::string model() {
    return write_boxes(
        "line.obj", {{"PIPE-2", 0, 0, 0, 1}, {"PIPE-21", 4, 0, 0, 1}, {"pump A", 8, 0, 0, 2}, {"pump B", 12, 0, 0, 2}});
  }
};

TEST_F(ViewAttributes, ConditionsAreFoundSelectedAndHidden) {
  expect_driven(
      "find @size>3\nexpect /found = 2\nselect-found\nexpect /selection/count = 2\n"
      "find @size>3 & !pump A\nexpect /found = 1\nselect-found\nexpect /selection/count = 1\n"
      "select-named PIPE-2\nexpect /selection/count = 1\n"
      "hide @near<=2.1m of PIPE-2\nexpect /hidden = 1\nshow-all\n"
      "isolate @size<=3\nexpect /hidden = 2\n",
      {model(), "--size", kSize, "--no-panels"});
  const Outcome refused = drive("find @size>tall\n", {model(), "--size", kSize});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("expected @size with <, <=, > or >= and a length"), std::string::npos) << refused;
}

/// Enter selects what the list shows: also parts that have the letters alone.
TEST_F(ViewAttributes, EnterSelectsWhatTheListShows) {
  expect_driven(
      "press ctrl+f\ntype PIP\nexpect /found = 2\npress enter\nexpect /selection/count = 2\n"
      "expect /message = \"2 parts have \\\"PIP\\\" in a name or value\"\n"
      "find @size>3\nexpect /found = 2\nselect-found\nexpect /message = \"2 items are selected: @size>3\"\n",
      {model(), "--size", "800x600", "--scale", "1"});
  expect_driven("press ctrl+f\ntype PIPE-2\nexpect /found = 2\npress enter\nexpect /selection/count = 1\n",
                {model(), "--size", "800x600", "--scale", "1"});
}

/// The legend lies in the image's upper left corner; its first row has the smallest sizes.
TEST_F(ViewAttributes, ColoursHaveALegendThatSelects) {
  const std::string plain = path("plain.png"), coloured = path("coloured.png"), again = path("again.png");
  expect_driven("front\nscreenshot " + plain +
                    "\nexpect /colours = null\ncolour-by @size\nexpect /colours/key = @size\n"
                    "expect /colours/groups/0/items = 2\nexpect /colours/groups/1/label = \"4 m\"\nscreenshot " +
                    coloured +
                    "\nclick 30 36\nexpect /selection/count = 2\nclick 30 53\nexpect /selection/count = 2\n"
                    "select-none\ncolour-by\nexpect /colours = null\nscreenshot " +
                    again + "\n",
                {model(), "--size", kSize, "--no-panels", "--scale", "1"});
  const Image before = read_png(plain);
  EXPECT_GT(differing(before, read_png(coloured)), 500u);
  EXPECT_EQ(differing(before, read_png(again)), 0u);
}

TEST_F(ViewAttributes, ViewsKeepColours) {
  expect_driven(
      "colour-by @size\nview-add sizes\ncolour-by\nview-add plain\nview-show sizes\nexpect /colours/key = @size\n"
      "view-show plain\nexpect /colours = null\nsave-view " +
          path("plain.json") + "\nview-show sizes\nload-view " + path("plain.json") + "\nexpect /colours = null\n",
      {model(), "--size", kSize, "--no-panels"});
}

TEST_F(ViewAttributes, AComparisonHasColoursOfItsOwn) {
  const std::string file = model();
  expect_driven("colour-by @size\ncompare " + file + "\nexpect /colours = null\ncompare-end\nexpect /colours = null\n",
                {file, "--size", kSize, "--no-panels"});
  const Outcome refused = drive("compare " + file + "\ncolour-by @size\n", {file, "--size", kSize, "--no-panels"});
  EXPECT_NE(refused.err.find("end the comparison first"), std::string::npos) << refused;
}

/// What is kept is there in the next run, and a click on its row selects.
TEST_F(ViewAttributes, SearchesAreKeptAsSets) {
  const Args args{model(), "--size", "800x600", "--scale", "1", "--settings", path("settings.json")};
  expect_driven("find @size>3\nset-keep\nset-keep PIPE-2\nexpect /sets/0 = @size>3\n", args);
  // The header opens; the second set has the second row.
  expect_driven(
      "expect /sets/1 = PIPE-2\nclick 60 91\nclick 60 129\nexpect /selection/count = 1\nexpect /found = 1\n"
      "set-remove PIPE-2\nset-remove @size>3\n",
      args);
  EXPECT_EQ(drive("set-remove PIPE-2\n", args).code, 1);
}

TEST_F(ViewAttributes, TheTabListsAndColours) {
  expect_driven("colour-by\nexpect /tab = Attributes\n", {model(), "--size", "800x600", "--scale", "1"});
}

TEST_F(ViewAttributes, PropertiesAreWritten) {
  const std::string file = path("properties.csv");
  expect_driven("select-named pump\nproperties-save " + file + "\n", {model(), "--size", kSize, "--no-panels"});
  EXPECT_EQ(read_bytes(file), "path,kind\nline.obj/pump A,mesh\nline.obj/pump B,mesh\n");
}

}  // namespace
}  // namespace sightline::tests::view_attributes_test
