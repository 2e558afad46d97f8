// Mark-ups of the viewer: by mouse and by scripts, in views and sessions, and in the images that it writes. Skipped
// without Xvfb.
#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_marks_test {
namespace {

/// The mark-ups' red.
std::size_t red_pixels(const Image& image, int from_column = 0) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3)
    count += int(i / 3) % image.width >= from_column && image.rgb[i] > 170 && image.rgb[i + 1] < 90 &&
             image.rgb[i + 2] < 100;
  return count;
}

TEST_F(ViewScript, DragsAndClicksMarkUp) {
  const Args args{boxes(), "--size", kSize, "--no-panels"};
  const Json before = state_after("front\n", args);
  const Json arrow = state_after(
      "front\nmark\nexpect /tool = mark\nexpect /tab = \"Mark up\"\ndrag 300 200 200 100\nexpect /markups/count = 1\n"
      "press escape\nexpect /tool = select\n",
      args);
  EXPECT_EQ(arrow["camera"], before["camera"]) << "no drag has turned it";
  EXPECT_EQ(arrow["markups"]["last"]["kind"], "arrow");
  // The tip is on the box in front, whose face is at y = -1, and the other end on the same plane.
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NEAR(arrow["markups"]["last"]["points"][i][1].get<double>(), -1.0, 1e-3) << i;
  EXPECT_NEAR(arrow["markups"]["last"]["points"][1][0].get<double>(), 0.0, 0.1);
  EXPECT_LT(arrow["markups"]["last"]["points"][0][0].get<double>(), -1.0);
  // A click draws no arrow; a drag with Shift moves the model.
  const Json moved = state_after("front\nmark\nclick 300 200\ndrag 300 200 200 100 shift\n", args);
  EXPECT_EQ(moved["markups"]["count"], 0);
  EXPECT_NE(moved["camera"], before["camera"]);
}

/// The tab's choices and its field for words lie beside the image.
TEST_F(ViewScript, TheTabHasWordsAndAList) {
  const Args args{boxes(), "--size", "800x600", "--scale", "1"};
  const Json text = state_after(
      "front\npress shift+m\nclick 696 125\nclick 640 150\ntype bolt M12\nclick 400 300\nexpect /markups/count = "
      "1\nclick 400 "
      "350\npress escape\nexpect /markups/count = 1\n",
      args);
  EXPECT_EQ(text["markups"]["last"]["kind"], "text") << text["markups"].dump();
  EXPECT_EQ(text["markups"]["last"]["words"], "bolt M12") << "which are used once";
}

TEST_F(ViewScript, MarkUpsBelongToViews) {
  const std::string views = path("views.json"), session = path("s.sightline");
  const Args args{boxes(), "--size", kSize, "--no-panels"};
  const std::string three =
      "front\nmark arrow 300 200 200 100 look\nmark cloud 250 150 350 250\nmark text 100 100 two words\n";
  expect_driven(three +
                    "expect /markups/count = 3\nexpect /markups/last/words = \"two words\"\nview-add three\n"
                    "mark-remove 3\nexpect /markups/count = 2\nmark-remove 2\nmark-remove 1\nview-add none\n"
                    "mark text 10 10 lost\nview-show three\nexpect /markups/count = 3\nview-show none\n"
                    "expect /markups/count = 0\nview-show 1\nmarks-clear\nexpect /markups/count = 0\nview-show 1\n"
                    "views-save " +
                    views + "\nsession-save " + session + "\n",
                args);
  expect_driven("views-load " + views + "\nview-show three\nexpect /markups/count = 3\n", args);
  expect_driven("expect /markups/count = 3\nexpect /markups/last/words = \"two words\"\n", {session, "--no-panels"});
#if SIGHTLINE_HAS_BCF
  const std::string bcf = path("views.bcfzip");
  expect_driven(three + "view-add three\nviews-save " + bcf + "\n", args);
  expect_driven("views-load " + bcf + "\nview-show three\nexpect /markups/count = 3\n" +
                    "expect /markups/last/words = \"two words\"\n",
                args);
#endif
  for (const char* bad : {"mark circle 1 2\n", "mark text 10 10\n", "mark arrow 1 2 3\n", "mark-remove 1\n"})
    EXPECT_EQ(drive(bad, args).code, 1) << bad;
}

/// Words that are typed after a mark-up was drawn are its own, and no keys of commands.
TEST_F(ViewScript, WordsFollowWhatIsDrawn) {
  expect_driven(
      "front\npress shift+m\nclick 696 125\nclick 400 300\ntype hide 12 <50 mm>\nexpect /markups/last/words = \"hide "
      "12 <50 "
      "mm>\"\npress enter\nexpect /hidden = 0\nexpect /tool = mark\nclick 450 350\nexpect /markups/count = 2\n"
      "press escape\nexpect /markups/count = 1\ndrag 300 200 200 100\nexpect /markups/count = 1\n",
      {boxes(), "--size", "800x600", "--scale", "1"});
}

/// Also in tiles, where the image is larger than the window; without marks, images are what they were.
TEST_F(ViewScript, WrittenImagesHaveMarks) {
  const auto file = [&](const char* name) { return path(name); };
  const Args args{boxes(), "--size", kSize, "--no-panels"};
  expect_driven("front\nscreenshot " + file("bare.png") + "\nscreenshot " + file("bare-large.png") +
                    " 2400x1600\nmark arrow 300 200 200 100 look\nmark cloud 250 150 350 250\nscreenshot " +
                    file("marked.png") + "\nscreenshot " + file("marked-large.png") +
                    " 2400x1600\nimage-marks\nscreenshot " + file("off.png") + "\nscreenshot " + file("off-large.png") +
                    " 2400x1600\n",
                args);
  const Image bare = read_png(file("bare.png")), marked = read_png(file("marked.png")),
              large = read_png(file("marked-large.png")), bare_large = read_png(file("bare-large.png"));
  EXPECT_LE(differing(read_png(file("off.png")), bare), kTies);
  EXPECT_LE(differing(read_png(file("off-large.png")), bare_large), kTies);
  EXPECT_EQ(red_pixels(bare), 0u);
  EXPECT_GT(red_pixels(marked), 500u);
  EXPECT_GT(red_pixels(large), 10 * red_pixels(marked)) << "lines and letters are larger, too";
  EXPECT_LT(red_pixels(large), 22 * red_pixels(marked));
}

TEST_F(ViewScript, ImagesHaveMeasurementsAndTheLegend) {
  const auto file = [&](const char* name) { return path(name); };
  const Args args{boxes(), "--size", kSize, "--no-panels"};
  expect_driven("top\ncolour-by @size\nimage-marks\nscreenshot " + file("bare.png") + "\nimage-marks\nscreenshot " +
                    file("legend.png") +
                    "\nmeasure\nclick 300 360\nclick 300 40\nexpect /measure/list = 1\nscreenshot " +
                    file("measured.png") + "\n",
                args);
  const Image bare = read_png(file("bare.png")), legend = read_png(file("legend.png")),
              measured = read_png(file("measured.png"));
  const std::size_t of_legend = differing(bare, legend), of_both = differing(bare, measured);
  EXPECT_GT(of_legend, 1000u);
  EXPECT_GT(of_both, of_legend + 500);
  EXPECT_LT(of_both, of_legend + 20000);
}

/// The list of views shows them.
TEST_F(ViewScript, SnapshotsHaveMarks) {
  const std::string shot = path("window.png"), bare = path("bare.png");
  const Args args{boxes(), "--size", "800x600", "--scale", "1"};
  expect_driven("front\nview-add a\nwindow-shot " + bare +
                    "\nview-delete a\nmark cloud 300 200 500 400\nview-add b\nmarks-clear\nwindow-shot " + shot + "\n",
                args);
  EXPECT_EQ(red_pixels(read_png(bare), 600), 0u);
  EXPECT_GT(red_pixels(read_png(shot), 600), 10u);
}

}  // namespace
}  // namespace sightline::tests::view_marks_test
