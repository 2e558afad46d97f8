// Section planes of sightline-view: what they cut, their handles and commands. Skipped without Xvfb.
#include <cmath>

#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_sections_test {
namespace {

TEST_F(ViewScript, SectionsCutTheImageAndPicks) {
  expect_driven(
      "front\n"
      "move 300 200\npress x\nexpect /sections = 1\n"  // at the front box's face: nothing is gone
      "click 300 200\nexpect /selection/count = 1\n"
      "press b\nexpect /sections = 6\npress escape\n"
      "drag 1 1 599 399 ctrl\nexpect /selection/count = 1\n"
      "move 300 200\npress x\npress x\nexpect /sections = 8\npress x\n"
      "expect /message = \"there are eight sections: take one away first\"\n"
      "section-clear\nexpect /sections = 0\n"
      "drag 1 1 599 399 ctrl\nexpect /selection/count = 4\n",
      {boxes(), "--size", kSize, "--no-panels"});
}

TEST_F(ViewScript, HandlesOfSectionsMoveTurnAndFlip) {
  const std::string model = boxes(), before = path("before.png"), after = path("after.png");
  const Args args{model, "--size", "1000x600", "--theme", "light"};
  // The front box's face to the south, seen from the east: the arrow out points to the left.
  const std::string begin =
      "front\nmove 485 300\nsection-here\nexpect /section_selected = 1\nsection-move "
      "-0.25\nright\nzoom-out\nzoom-out\n";
  const Json seen = state_after(begin + "screenshot " + before + "\n", args);
  const Json section = seen.at("section_list").at(0);
  EXPECT_EQ(section.at("normal"), Json::array({0.0, -1.0, 0.0}));
  EXPECT_NEAR(section.at("at").at(1).get<double>(), -0.75, 1e-9);
  ASSERT_EQ(section.at("handles").size(), 5u) << "of the plane's sides, two lie behind the middle: " << section;
  const auto drag = [&](const char* handle, int x, int y, const std::string& with = "") {
    const Json& at = section.at("handles").at(handle);
    const double from[] = {at.at(0).get<double>(), at.at(1).get<double>()};
    return "drag " + std::to_string(from[0]) + ' ' + std::to_string(from[1]) + ' ' + std::to_string(from[0] + x) + ' ' +
           std::to_string(from[1] + y) + ' ' + with + '\n';
  };
  const auto dragged = [&](const char* handle, int x, int y, const std::string& with = "", const char* then = "") {
    return state_after(begin + drag(handle, x, y, with) + then, args).at("section_list").at(0);
  };
  const double depth = seen.at("camera").at("eye").at(0).get<double>() - section.at("at").at(0).get<double>(),
               pixel = 2.0 * depth * std::tan(0.125 * 3.14159265358979) / seen.at("size").at(1).get<double>();

  // Moved by as much as the cursor, along the normal alone; the image changes, camera and selection do not.
  const Json whole = state_after(begin + drag("out", 60, 30) + "screenshot " + after + "\n", args),
             moved = whole.at("section_list").at(0);
  EXPECT_NEAR(moved.at("moved").get<double>(), -0.25 - 60.0 * pixel, pixel);
  EXPECT_EQ(moved.at("normal"), section.at("normal"));
  EXPECT_EQ(whole.at("camera"), seen.at("camera"));
  EXPECT_EQ(whole.at("selection").at("count"), 0);
  EXPECT_NE(read_png(before).rgb, read_png(after).rgb);
  EXPECT_NEAR(dragged("in", -20, 0).at("moved").get<double>(), -0.25 + 20.0 * pixel, pixel);
  EXPECT_NEAR(dragged("middle", 20, 0).at("moved").get<double>(), -0.25 - 20.0 * pixel, pixel);

  // With Ctrl at round places, by whole steps of angle; with Shift at what the model has there.
  const auto round = dragged("out", 57, 0, "ctrl").at("at").at(1).get<double>();
  EXPECT_NEAR(round, 0.05 * std::round(round / 0.05), 1e-9);
  EXPECT_GT(round, -0.75);
  const Json turned = dragged("up", -20, 2, "ctrl");
  EXPECT_NEAR(turned.at("normal").at(1).get<double>(), -std::sqrt(0.75), 1e-9);
  EXPECT_NEAR(turned.at("normal").at(2).get<double>(), -0.5, 1e-9);

  // A click on the middle flips the selected section, or selects; without handles, and beside them, all is as ever.
  const Json& at = section.at("handles").at("middle");
  const std::string click =
      "click " + std::to_string(at.at(0).get<double>()) + ' ' + std::to_string(at.at(1).get<double>()) + '\n';
  expect_driven(begin + click + "expect /section_list/0/normal/1 = 1\n" + click +
                    "expect /section_list/0/normal/1 = -1\nexpect /selection/count = 0\nsection-select 0\n" + click +
                    "expect /section_selected = 1\nexpect /section_list/0/normal/1 = -1\nsection-handles\n" + click +
                    "expect /section_list/0/normal/1 = -1\nexpect /selection/count = 1\n" + drag("out", 60, 0) +
                    "expect /section_list/0/at/1 < -0.7499\nexpect /section_list/0/at/1 > -0.7501\n",
                args);
}

TEST_F(ViewScript, SectionsHaveCommands) {
  const std::string model = boxes();
  const Args args{model, "--size", kSize, "--no-panels"};
  expect_driven(
      "front\nsection-box\nexpect /section_selected = 0\nexpect /section_list/5/normal/2 = -1\n"
      "section-flip 6\nexpect /section_list/5/normal/2 = 1\nsection-move 2 1.5\n"
      "expect /section_list/1/moved = 1.5\nsection-select 3\nsection-remove 2\nexpect /sections = 5\n"
      "expect /section_selected = 2\nsection-move 0.5\nexpect /section_list/1/moved = 0.5\n"
      "section-remove\nexpect /sections = 4\nexpect /section_selected = 0\n"
      "hatch\nexpect /hatching = true\nhatch\nexpect /hatching = false\n",
      args);
  for (const char* wrong : {"section-flip 3", "section-remove", "section-move 1 far", "section-select x"}) {
    const Outcome refused = drive(std::string(wrong) + "\n", args);
    EXPECT_EQ(refused.code, 1) << wrong << refused;
  }
}

/// Through the middle, with the lower half kept; the edges of a box show in the image, as one entry in the tab.
TEST_F(ViewScript, SectionsGoThroughTheMiddle) {
  const std::string plain = path("plain.png"), edges = path("edges.png");
  const Args args{boxes(), "--size", "900x600", "--scale", "1"};
  expect_driven(
      "section-z\nexpect /section_list/0/at/2 = 0\nexpect /section_list/0/normal/2 = 1\nexpect /section_selected = 1\n"
      "section-x\nsection-y\nexpect /sections = 3\nexpect /section_list/2/at/1 = 5\n"
      "section-clear\nsection-box\nexpect /section_box = true\nsection-remove 2\nexpect /section_box = false\n",
      args);
  const auto orange = [](const Image& image) {
    int count = 0;
    for (std::size_t i = 0; i < image.rgb.size(); i += 3)
      count += image.rgb[i] > 230 && image.rgb[i + 1] > 130 && image.rgb[i + 1] < 190 && image.rgb[i + 2] < 80;
    return count;
  };
  expect_driven("fit\nsection-box\nwindow-shot " + edges + "\nsection-remove 6\nwindow-shot " + plain + "\n", args);
  EXPECT_GT(orange(read_png(edges)), orange(read_png(plain)) + 500);
}

}  // namespace
}  // namespace sightline::tests::view_sections_test
