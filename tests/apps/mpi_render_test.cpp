// One view by several processes of mpirun: the image of one.
#include <algorithm>

#include "sightline/tests/apps/mpi_launcher.h"
#include "sightline/tests/apps/render_test.h"
#include "sightline/tests/support/places.h"

namespace sightline::tests::mpi_render_test {
namespace {

class MpiRender : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
#if !SIGHTLINE_HAS_MPI
    GTEST_SKIP() << "this build has no MPI";
#endif
    if (run_program("mpirun", {"--version"}).code != 0) GTEST_SKIP() << "no mpirun (openmpi-bin)";
  }

  Outcome mpirun(int ranks, const std::string& tool, const Args& args) const {
    Args all = joined(mpirun_here(), {"-np", std::to_string(ranks), program_of(tool)});
    all.insert(all.end(), args.begin(), args.end());
    all.push_back("--mpi");
    return run_program("env", all);
  }

  static Args joined(Args a, const Args& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  }

  /// Colours, ids and depths of one process and of several.
  void expect_same_images(const Args& args, const std::vector<int>& ranks, const std::string& more = "") const {
    const auto outputs = [&](const std::string& name) {
      return Args{"--out", path(name + ".png"), "--ids", path(name + "-ids.png"), "--depth", path(name + ".pfm")};
    };
    render(joined(args, outputs("one")));
    for (const int n : ranks) {
      SCOPED_TRACE(std::to_string(n) + " ranks " + more);
      const std::string name = std::to_string(n);
      const Outcome outcome = mpirun(n, "render", joined(args, outputs(name)));
      ASSERT_EQ(outcome.code, 0) << outcome;
      EXPECT_EQ(read_bytes(path(name + ".png")), read_bytes(path("one.png")));
      EXPECT_EQ(read_bytes(path(name + "-ids.png")), read_bytes(path("one-ids.png")));
      EXPECT_EQ(read_bytes(path(name + ".pfm")), read_bytes(path("one.pfm")));
    }
  }

  std::string near_view(const std::string& more = "") const {
    return write("view.json", R"({"eye":[-30,-12,6],"target":[5,2,3],"fovy_deg":60,"near":0.1)" + more + "}");
  }
};

TEST_F(MpiRender, DrawsTheImageOfOneProcess) {
  const std::string model = plant(4000);
  expect_same_images({model, "--plain", "--size", "400x240"}, {1, 2, 4, 7}, "of the whole");
  expect_same_images({model, "--plain", "--size", "400x240", "--view", near_view()}, {4}, "near");
  expect_same_images(
      {model, "--plain", "--size", "400x240", "--view", near_view(R"(,"sections":[{"n":[0,1,0],"d":-1}])")}, {4},
      "cut");
  expect_same_images({model, "--plain", "--size", "401x243", "--tile", "160", "--view", near_view()}, {3}, "in tiles");
}

TEST_F(MpiRender, DrawsMeshesAndMaterialsAsOneProcess) {
  const std::string model = in_checkout("tests/data/small_plant.rvm").string();
  expect_same_images({model, "--plain", "--size", "320x200"}, {2, 4});
  std::vector<std::array<std::array<int, 3>, 3>> triangles;
  for (int i = 0; i < 200; ++i)
    triangles.push_back({{{i % 20, i / 20, 0}, {i % 20 + 2, i / 20, i % 7}, {i % 20, i / 20 + 2, 3}}});
  expect_same_images({write("soup.stl", stl_text(triangles)), "--plain", "--size", "320x200"}, {4});
}

/// Machines of a cluster seldom have OpenGL.
TEST_F(MpiRender, DrawsTheImageOfOneProcessByRays) {
  const std::string model = plant(4000);
  expect_same_images({model, "--renderer", "rays", "--plain", "--size", "400x240"}, {2, 5});
  expect_same_images({model, "--renderer", "rays", "--plain", "--size", "401x243", "--tile", "160", "--samples", "1",
                      "--view", near_view()},
                     {3}, "in tiles");
}

/// Items that lie in one place have equal depths: the order in which one process draws them decides. The sample test
/// changes that order.
TEST_F(MpiRender, TiesAreDecidedAsInOneProcess) {
  const std::string model = plant(2000);
  expect_same_images({model, model, "--plain", "--size", "320x200", "--sample-test", "off"}, {4});
}

/// But for shading by depth, of which a process knows that of its own part alone.
TEST_F(MpiRender, LooksForPeopleAreThoseOfOneProcess) {
  const Args args = {plant(2000), "--size", "200x120"};
  render(joined(args, {"--depth-shading", "0", "--edge-lines", "0", "--out", path("one.png")}));
  const Outcome outcome = mpirun(3, "render", joined(args, {"--out", path("three.png")}));
  ASSERT_EQ(outcome.code, 0) << outcome;
  EXPECT_EQ(read_bytes(path("three.png")), read_bytes(path("one.png")));
}

TEST_F(MpiRender, PartsOutOfViewAreLeftOut) {
  const std::string model = plant(4000);
  const Args args = {model, "--plain", "--size", "200x120", "--json", path("figures.json"), "--out", path("a.png")};
  const auto results = [&] {
    Json json = json::parse(read_bytes(path("figures.json"))).value();
    EXPECT_TRUE(json.is_object());
    return json;
  };
  ASSERT_EQ(mpirun(4, "render", args).code, 0);
  Json all = results();
  EXPECT_EQ(all["processes"], 4);
  EXPECT_EQ(all["drawing"], 4);
  EXPECT_EQ(all["visible"], 4000);
  double items = 0.0;
  for (const Json& part : all["part_items"]) {
    items += part.get<double>();
    EXPECT_NEAR(part.get<double>(), 1000.0, 33.0);
  }
  EXPECT_EQ(items, 4000.0);
  // Into the far end of the plant, and at nothing at all.
  const std::string away = write("away.json", R"({"eye":[-300,0,5],"target":[-400,0,5],"fovy_deg":30,"near":0.1})");
  const Outcome outcome = mpirun(4, "render", joined(args, {"--view", away}));
  ASSERT_EQ(outcome.code, 0) << outcome;
  all = results();
  EXPECT_EQ(all["drawing"], 0);
  render({model, "--plain", "--size", "200x120", "--view", away, "--out", path("b.png")});
  EXPECT_EQ(read_bytes(path("a.png")), read_bytes(path("b.png")));
}

TEST_F(MpiRender, ComparesWithAReferenceOnRankZero) {
  const std::string model = plant(2000);
  render({model, "--plain", "--size", "200x120", "--out", path("reference.png")});
  const Args args = {model, "--plain", "--size", "200x120", "--compare", path("reference.png")};
  EXPECT_EQ(mpirun(2, "render", args).code, 0);
  EXPECT_EQ(mpirun(2, "render", joined(args, {"--view", near_view(), "--max", "1"})).code, 1);
}

TEST_F(MpiRender, AnErrorIsToldOnceAndEndsAll) {
  const auto lines = [](const Outcome& outcome, const std::string& tool) {
    const auto all = outcome.error_lines();
    return std::count_if(all.begin(), all.end(),
                         [&](const std::string& line) { return line.rfind("sightline-" + tool + ": ", 0) == 0; });
  };
  for (const char* tool : {"render", "replay"}) {
    const Args output = {tool == std::string("render") ? "--out" : "--images", path("a.png")};
    const Outcome outcome = mpirun(3, tool, joined({path("missing.rvm")}, output));
    EXPECT_NE(outcome.code, 0) << outcome;
    EXPECT_EQ(lines(outcome, tool), 1) << outcome;
    EXPECT_NE(outcome.err.find("missing.rvm"), std::string::npos) << outcome;
  }
  const Outcome outcome = mpirun(3, "render", {plant(1000), "--size", "64x64", "--out", unwritable("a.png")});
  EXPECT_NE(outcome.code, 0) << outcome;
  EXPECT_EQ(lines(outcome, "render"), 1) << outcome;
  expect_usage_error("render", {"model.rvm", "--mpi", "--edge-lines", "0.5"}, "--mpi");
  expect_usage_error("replay", {"model.rvm", "--mpi", "--no-render"}, "--mpi");
}

TEST_F(MpiRender, ReplaysAFlightAsOneProcess) {
  const std::string model = plant(3000);
  const Args args = {model, "--size", "200x120", "--frames", "5", "--every", "2"};
  ASSERT_EQ(run("replay", joined(args, {"--images", path("one")})).code, 0);
  const Outcome outcome = mpirun(4, "replay", joined(args, {"--images", path("four"), "--json", path("figures.json")}));
  ASSERT_EQ(outcome.code, 0) << outcome;
  for (const char* frame : {"frame_00000.png", "frame_00002.png", "frame_00004.png"}) {
    const std::string one = read_bytes(path("one") + "/" + frame);
    EXPECT_FALSE(one.empty());
    EXPECT_EQ(read_bytes(path("four") + "/" + frame), one) << frame;
  }
  EXPECT_EQ(json::parse(read_bytes(path("figures.json"))).value()["frames"].size(), 5u);
}

}  // namespace
}  // namespace sightline::tests::mpi_render_test
