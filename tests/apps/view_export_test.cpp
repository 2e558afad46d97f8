// sightline-view writes models, images, paths and frames: what is read back is what was shown. Skipped without Xvfb.
#include "sightline/render/image/image.h"
#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_export_test {
namespace {

class ViewExport : public ViewScript {};

TEST_F(ViewExport, WritesWhatConvertWrites) {
  const std::string model = plant(1000);
  ASSERT_EQ(run("convert", {model, path("one.obj")}).code, 0);
  const Json end = state_after("find PIPE-2-B1\nselect-found\nhide\nexport-model " + path("all.rvm") +
                                   "\nexport-model " + path("all.obj") + "\n",
                               {model, "--size", kSize});
  EXPECT_NE(end["message"].get<std::string>().find("all.obj: 1000 of 1000 items, "), std::string::npos);
  EXPECT_TRUE(read_bytes(model) == read_bytes(path("all.rvm")));
  EXPECT_EQ(read_bytes(path("one.obj")).size(), read_bytes(path("all.obj")).size());
}

/// The selection alone looks as the isolated selection does, and keeps its names.
TEST_F(ViewExport, TheSelectionIsWhatItLooks) {
  const std::string model = plant(1000), image = path("isolated.png"),
                    view =
                        R"({"eye": [10, -9, 9], "target": [10, -1, 6.6], "up": [0, 0, 1], "fovy_deg": 45, "near": 1})";
  expect_driven("load-view " + write("view.json", view) + "\nfind PIPE-2-B1\nselect-found\nisolate\nexport-selection " +
                    path("part.rvm") + "\nselect-none\nscreenshot " + image + "\n",
                {model, "--size", kSize, "--no-panels"});
  const Json facts = run_json("info", {path("part.rvm"), "--list", "PIPE-2-B1"});
  EXPECT_EQ(facts["found"].size(), 1u);
  EXPECT_EQ(facts["nodes"], 6) << "root, file, site, zone, pipe, branch";
  const std::string alone = path("alone.png");
  expect_driven("load-view " + path("view.json") + "\nscreenshot " + alone + "\n",
                {path("part.rvm"), "--size", kSize, "--no-panels"});
  const Image a = read_png(image), b = read_png(alone);
  EXPECT_EQ(a.rgb, b.rgb);
  EXPECT_NE(std::count(a.rgb.begin(), a.rgb.end(), a.rgb[0]), std::ptrdiff_t(a.rgb.size())) << "it shows something";
}

TEST_F(ViewExport, RefusesWhatWouldBeLostAndWhatIsNothing) {
  const std::string model = boxes(), bytes = read_bytes(model);
  for (const auto& [script, message] :
       {std::pair<std::string, std::string>{"export-model " + model + "\n", "would be lost"},
        {"export-selection " + path("a.rvm") + "\n", "select something first"},
        {"export-model " + path("a.vtk") + "\n", "expected a name ending in"},
        {"export-model " + unwritable("a.rvm") + "\n", "a.rvm"}}) {
    const Outcome outcome = drive(script, {model, "--size", kSize});
    EXPECT_EQ(outcome.code, 1) << outcome;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome;
  }
  EXPECT_EQ(read_bytes(model), bytes);
  EXPECT_FALSE(fs::exists(path("a.rvm")));
}

/// Without a name a dialog asks; what is typed there is written, and an empty field takes a free name.
TEST_F(ViewExport, DialogsAskForAFile) {
  const std::string model = boxes();
  const Json end = state_after(
      "export-model\nexpect /dialog = export-model\npress escape\nexpect /dialog = none\nselect-all\n"
      "export-selection\nexpect /dialog = export-selection\ntype " +
          path("typed.rvm") + "\npress enter\nexpect /dialog = none\n",
      {model, "--size", "800x600"});
  EXPECT_NE(end["message"].get<std::string>().find("typed.rvm: 4 of 4 items"), std::string::npos);
  EXPECT_TRUE(fs::exists(path("typed.rvm")));
}

TEST_F(ViewScript, ImagesAreOfTheFormatThatTheirNameSays) {
  const std::string model = boxes(), image = path("a.png");
  const Args args{model, "--size", kSize, "--no-panels"};
  for (const auto& [step, name] : {std::pair{"screenshot ", "b.gif"}, std::pair{"window-shot ", "b.jpg"}}) {
    const Outcome refused = drive("screenshot " + image + "\n" + step + path(name) + "\n", args);
    EXPECT_EQ(refused.code, 1) << refused;
    EXPECT_NE(refused.err.find(":2: " + path(name) + ": expected a name that ends in .png"), std::string::npos)
        << refused;
    EXPECT_FALSE(fs::exists(image)) << "refused before any work";
  }
  const Outcome sized = drive("screenshot " + path("b.gif") + " 64x64\n", args);
  EXPECT_EQ(sized.code, 1) << sized;
  expect_driven("screenshot " + path("c.jpg") + "\nscreenshot " + path("d.jpg") + " 64x64\nwait 0.2\n", args);
  for (const char* name : {"c.jpg", "d.jpg"}) EXPECT_TRUE(read_bytes(path(name)).starts_with("\xff\xd8\xff")) << name;
  const std::string cut = "front\nsection-z\nsection-move 1 -1000\n";
  for (const char* size : {"", " 64x64"}) {
    const Outcome empty = drive(cut + "screenshot " + image + size + "\n", args);
    EXPECT_EQ(empty.code, 1) << empty;
    EXPECT_NE(empty.err.find("the sections leave nothing of the model"), std::string::npos) << empty;
    EXPECT_FALSE(fs::exists(image));
  }
}

TEST_F(ViewScript, ImagesHaveTheBackgroundThatIsAsked) {
  const std::string model = boxes();
  const Args args{model, "--size", kSize, "--no-panels"};
  expect_driven("image-background 204080\nscreenshot " + path("blue.png") +
                    " 80x60\nwait 0.2\n"
                    "image-background transparent\nscreenshot " +
                    path("clear.png") +
                    "\nwait 0.2\n"
                    "image-background shown\nscreenshot " +
                    path("shown.png") + " 80x60\n",
                args);
  const auto blue = image::read_png(path("blue.png")), shown = image::read_png(path("shown.png"));
  ASSERT_TRUE(blue && shown);
  EXPECT_EQ(std::vector<int>(blue->pixels.begin(), blue->pixels.begin() + 3), (std::vector<int>{0x20, 0x40, 0x80}));
  EXPECT_NE(blue->pixels, shown->pixels);
  const std::string clear = read_bytes(path("clear.png"));
  ASSERT_GT(clear.size(), 26u);
  EXPECT_EQ(clear[25], 6) << "RGBA";
  const Outcome refused = drive("image-background blurred\n", args);
  EXPECT_EQ(refused.code, 1) << refused;
  EXPECT_NE(refused.err.find("image-background: expected a colour"), std::string::npos) << refused;
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
  expect_driven(
      "orthographic\nplay-path " + flight +
          "\nexpect /playing = false\nexpect /camera/eye/0 = 9.0\nexpect /camera/orthographic = false\n"
          "select-all\npath-loop\npath-speed 0.5\nplay-path\nwait 0.2\nexpect /playing = true\npress escape\n"
          "expect /playing = false\nexpect /selection/count = 4\nplay-path\nmove 160 120\nwheel 1\nwait 0.1\nexpect "
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

}  // namespace
}  // namespace sightline::tests::view_export_test
