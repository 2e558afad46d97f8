// sightline-view writes models: what is read back is what was shown. Skipped without Xvfb.
#include "sightline/tests/apps/view_window.h"

namespace sightline::tests::view_export_test {
namespace {

class ViewExport : public ViewScript {};

TEST_F(ViewExport, WritesWhatConvertWrites) {
  const std::string model = plant(1000);
  ASSERT_EQ(run("convert", {model, path("con.obj")}).code, 0);
  const Json end = state_after("find PIPE-2-B1\nselect-found\nhide\nexport-model " + path("all.rvm") +
                                   "\nexport-model " + path("all.obj") + "\n",
                               {model, "--size", kSize});
  EXPECT_NE(end["message"].get<std::string>().find("all.obj: 1000 of 1000 items, "), std::string::npos);
  EXPECT_TRUE(read_bytes(model) == read_bytes(path("all.rvm")));
  EXPECT_EQ(read_bytes(path("con.obj")).size(), read_bytes(path("all.obj")).size());
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
        {"export-model " + path("a.stl") + "\n", "expected a name ending in"},
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

}  // namespace
}  // namespace sightline::tests::view_export_test
