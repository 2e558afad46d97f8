// sightline-info against its contract.
#include "sightline/tests/apps/tool_test.h"
#include "sightline/tests/support/no_gl.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::tests::info_test {
namespace {

using Info = ToolTest;

const std::vector<std::string> kKinds = {"box",    "circular_torus", "cylinder", "elliptical_dish",   "facet_group",
                                         "line",   "mesh",           "pyramid",  "rectangular_torus", "snout",
                                         "sphere", "spherical_dish"};

std::uint64_t total(const Json& info) {
  std::uint64_t sum = 0;
  for (const auto& [kind, count] : info["items"].items()) sum += count.get<std::uint64_t>();
  return sum;
}

/// A pyramid that stands on the plane y = 0, in a format that does not say which axis points up.
TEST_F(Info, TellsWhatItTurnsWhereYSeemsToPointUp) {
  const std::string faces = "f 1 2 3 4\nf 2 1 5\nf 3 2 5\nf 4 3 5\nf 1 4 5\n";
  const std::string standing = write("standing.obj", "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0.5 2 0.5\n" + faces);
  const auto told = [&](const Args& args) {
    const Outcome outcome = run("info", args);
    EXPECT_EQ(outcome.code, 0) << outcome;
    return outcome.err.find("note: standing.obj seems to have y up and is turned; --up z keeps it") !=
           std::string::npos;
  };
  EXPECT_TRUE(told({standing}));
  EXPECT_FALSE(told({standing, "--up", "y"}));
  EXPECT_FALSE(told({standing, "--up", "z"}));
  const auto height = [&](const Args& args) { return run_json("info", args)["bounds"]["max"][2].get<double>(); };
  EXPECT_NEAR(height({standing}), 2.0, 1e-6);
  EXPECT_NEAR(height({standing, "--up", "z"}), 1.0, 1e-6);
  ASSERT_EQ(run("convert", {standing, path("written.obj"), "--up", "z"}).code, 0);
  EXPECT_NEAR(height({path("written.obj")}), 1.0, 1e-6);
}

TEST_F(Info, WritesTheKeysOfTheContract) {
  const Json info = run_json("info", {plant(1000)});
  EXPECT_EQ(keys_of(info),
            (std::vector<std::string>{"attributed", "bounds", "degenerate", "items", "max_depth", "metres_per_unit",
                                      "nodes", "shared_meshes", "sharing_error", "triangles", "warnings"}));
  EXPECT_EQ(keys_of(info["items"]), kKinds);
  EXPECT_EQ(keys_of(info["bounds"]), (std::vector<std::string>{"max", "min"}));
  EXPECT_EQ(info["bounds"]["min"].size(), 3u);
  EXPECT_EQ(info["bounds"]["max"].size(), 3u);
}

TEST_F(Info, CountsAGeneratedPlant) {
  const Json info = run_json("info", {plant(1000)});
  EXPECT_EQ(total(info), 1000u);
  EXPECT_EQ(info["items"]["cylinder"], 650);
  EXPECT_EQ(info["items"]["circular_torus"], 200);
  EXPECT_EQ(info["items"]["snout"], 50);
  EXPECT_EQ(info["items"]["mesh"], 0);
  EXPECT_EQ(info["degenerate"], 0);
  EXPECT_EQ(info["warnings"], Json::array());
  EXPECT_GT(info["nodes"], info["max_depth"]);
  EXPECT_GE(info["max_depth"], 4);  // file, site, zone, pipe, branch
  for (int axis = 0; axis < 3; ++axis) EXPECT_LT(info["bounds"]["min"][axis], info["bounds"]["max"][axis]);
  EXPECT_LT(info["bounds"]["max"][2], 60.0);
}

TEST_F(Info, WritesTheSameJsonToAFile) {
  const std::string model = plant(1000), file = path("info.json");
  const Outcome outcome = run("info", {model, "--json", file});
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_NE(outcome.out.find("cylinder"), std::string::npos) << outcome;
  EXPECT_EQ(json::parse(read_bytes(file)).value(), run_json("info", {model}));
}

TEST_F(Info, KeepsStdoutForTheJson) {
  const Outcome outcome = run("info", {plant(1000), "--explain", "--json", "-"});
  EXPECT_TRUE(json::parse(outcome.out)) << outcome;
  EXPECT_NE(outcome.err.find("left out"), std::string::npos) << outcome;
}

TEST_F(Info, CountsTrianglesOfMeshes) {
  const std::string mesh =
      write("square.stl", tests::stl_text({{{{0, 0, 0}, {2, 0, 0}, {2, 3, 0}}}, {{{0, 0, 0}, {2, 3, 0}, {0, 3, 0}}}}));
  const Json info = run_json("info", {mesh});
  EXPECT_EQ(info["triangles"], 2);
  EXPECT_EQ(info["items"]["mesh"], total(info));
  EXPECT_NEAR(info["bounds"]["max"][1].get<double>(), 3.0, 1e-6);
}

TEST_F(Info, ASceneWithoutItemsHasNoBounds) {
  const Json info = run_json("info", {write("nothing.stl", tests::stl_text({}))});
  EXPECT_EQ(total(info), 0u);
  EXPECT_TRUE(info["bounds"].is_null());
}

TEST_F(Info, MovesTheBoundsWithTheModel) {
  const std::string model = plant(1000);
  const Json here = run_json("info", {model}), there = run_json("info", {model, "--translate", "-3e6,7e6,1e3"});
  const double offset[3] = {-3e6, 7e6, 1e3};
  for (const char* corner : {"min", "max"})
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(there["bounds"][corner][axis].get<double>(),
                  here["bounds"][corner][axis].get<double>() + offset[axis], 1e-6);
  EXPECT_EQ(here["items"], there["items"]);
}

TEST_F(Info, SeveralFilesAddUp) {
  const std::string a = plant(1000, 1), b = plant(2000, 2);
  const Json both = run_json("info", {a, b}), one = run_json("info", {a}), two = run_json("info", {b});
  for (const std::string& kind : kKinds)
    EXPECT_EQ(both["items"][kind], one["items"][kind].get<int>() + two["items"][kind].get<int>()) << kind;
  EXPECT_EQ(both["nodes"], one["nodes"].get<int>() + two["nodes"].get<int>() - 1);  // one root
}

TEST_F(Info, ADamagedFileIsRefusedOrListed) {
  const std::string whole = read_bytes(plant(1000));
  // No UTF-8: file names may hold any bytes, JSON may not.
  const std::string damaged = write("damaged\xff.rvm", whole.substr(0, whole.size() / 2));
  expect_failure("info", {damaged}, damaged);
  const Json info = run_json("info", {damaged, "--lenient"});
  ASSERT_GE(info["warnings"].size(), 1u);
  for (const Json& warning : info["warnings"]) {
    EXPECT_EQ(keys_of(warning), (std::vector<std::string>{"file", "message", "offset"}));
    EXPECT_LE(warning["offset"], whole.size() / 2);
    EXPECT_NE(warning["file"].get<std::string>().find("damaged"), std::string::npos);
    EXPECT_NE(warning["message"], "");
  }
  EXPECT_GT(total(info), 0u);
  EXPECT_LT(total(info), 1000u);
}

TEST_F(Info, TheHuldraFilesAddUp) {
  const std::vector<std::string> names = {"huldra/HA-PIPE.RVM", "huldra/HA-MECH.RVM", "huldra/WD1-PSUP.RVM"};
  Args files;
  for (const std::string& name : names) {
    SIGHTLINE_NEED_DATA(name);
    files.push_back(data_path(name).string());
  }
  const Json all = run_json("info", files);
  std::vector<Json> each;
  for (const std::string& file : files) each.push_back(run_json("info", {file}));
  const auto sum = [&](const auto& pick) {
    std::uint64_t n = 0;
    for (const Json& info : each) n += pick(info).template get<std::uint64_t>();
    return n;
  };
  for (const std::string& kind : kKinds)
    EXPECT_EQ(all["items"][kind], sum([&](const Json& info) { return info["items"][kind]; })) << kind;
  for (const char* key : {"degenerate", "triangles"})
    EXPECT_EQ(all[key], sum([&](const Json& info) { return info[key]; })) << key;
  EXPECT_EQ(all["nodes"], sum([&](const Json& info) { return info["nodes"]; }) - (each.size() - 1));
  for (int axis = 0; axis < 3; ++axis) {
    double low = 1e300, high = -1e300;
    for (const Json& info : each) {
      low = std::min(low, info["bounds"]["min"][axis].get<double>());
      high = std::max(high, info["bounds"]["max"][axis].get<double>());
    }
    EXPECT_DOUBLE_EQ(all["bounds"]["min"][axis].get<double>(), low);
    EXPECT_DOUBLE_EQ(all["bounds"]["max"][axis].get<double>(), high);
  }
  EXPECT_EQ(total(each[2]), 2757u);  // as its publisher counts them
}

TEST_F(Info, TellsOfOpenGl) {
  const Outcome page = run("info", {"--gl", "--gl-workaround", "plain-depth=on"});
  if (page.code == 2) GTEST_SKIP() << "without GL: " << page.err;
  if (page.code != 0 && may_skip(page.err)) GTEST_SKIP() << page.err;
  ASSERT_EQ(page.code, 0) << page;
  for (const char* line : {"renderer ", "\nLimits", "\nSelf-test", "clip-control ", "\nWorkarounds", "on, by switch: "})
    EXPECT_NE(page.out.find(line), std::string::npos) << line << page;
  const Json json = run_json("info", {"--gl", "--gl-workaround", "no-timer=on"});
  EXPECT_EQ(json["self_test"]["checks"]["conservative-depth"], "passed");
  EXPECT_EQ(json["workarounds"].size(), 8u);
  for (const Json& row : json["workarounds"]) EXPECT_EQ(row["on"], row["name"] == "no-timer") << row;
  EXPECT_EQ(run("info", {"--gl", "--gl-workaround", "no-timer"}).code, 2);
  EXPECT_EQ(run("info", {"--gl", plant(1000)}).code, 2);
  EXPECT_EQ(run("info", {}).code, 2);
}

}  // namespace
}  // namespace sightline::tests::info_test
