// What every subcommand of sightline-bench promises on its command line, and quick runs of those without tests of their
// own.
#include "sightline/tests/apps/tool_test.h"
#include "sightline/tests/support/no_gl.h"

namespace sightline::tests::bench_test {
namespace {

class Bench : public ToolTest {
 protected:
  /// The names that --help lists.
  std::vector<std::string> subcommands() const {
    const Outcome outcome = run("bench", {"--help"});
    EXPECT_EQ(outcome.code, 0) << outcome;
    std::istringstream help(outcome.out.substr(outcome.out.find("Subcommands:")));
    std::vector<std::string> names;
    std::string line;
    std::getline(help, line);
    while (std::getline(help, line) && !line.empty()) names.push_back(line.substr(2, line.find(' ', 2) - 2));
    return names;
  }

  /// One view from outside a made-up plant.
  std::string view_file() const {
    const std::array<double, 16> clip_from_world = {0.01, 0, 0, 0, 0, 0.01, 0, 0, 0, 0, -0.01, 0, -1, -1, 0, 1};
    return write("views.f64", std::string(reinterpret_cast<const char*>(clip_from_world.data()), 128));
  }
};

TEST_F(Bench, ListsItsSubcommands) {
  const std::vector<std::string> names = subcommands();
  for (const char* name : {"cull", "views", "edit", "controller", "occlusion", "import", "recognise"})
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  const auto with_gl = std::count(names.begin(), names.end(), "hybrid");
  for (const char* name : {"context", "gpu-cull", "error-time", "proxies"})
    EXPECT_EQ(std::count(names.begin(), names.end(), name), with_gl) << name;
}

TEST_F(Bench, EverySubcommandHasHelpWithExamples) {
  for (const std::string& name : subcommands()) {
    const Outcome outcome = run("bench", {name, "--help"});
    EXPECT_EQ(outcome.code, 0) << outcome;
    EXPECT_EQ(outcome.err, "");
    const std::size_t examples = outcome.out.find("Examples:");
    ASSERT_NE(examples, std::string::npos) << outcome;
    EXPECT_NE(outcome.out.find("sightline-bench " + name, examples), std::string::npos) << outcome;
    EXPECT_NE(outcome.out.find("--json"), std::string::npos) << outcome;
    expect_usage_error("bench", {name, "--json"}, "--json");
  }
}

TEST_F(Bench, RefusesWhatItDoesNotKnow) {
  expect_usage_error("bench", {}, "subcommand");
  expect_usage_error("bench", {"no-such-subcommand"}, "subcommand");
  expect_usage_error("bench", {"edit", "--no-such-flag"}, "--no-such-flag");
  EXPECT_EQ(run("bench", {"--version"}).code, 0);
}

TEST_F(Bench, MeasuresViews) {
  const Json json = run_json("bench", {"views", "--generate", "2000", "--views", view_file()});
  EXPECT_EQ(json["items"], 2000);
  ASSERT_EQ(json["rows"].size(), 13u);
  EXPECT_GT(json["rows"][0]["mean_visible"], 0.0);
}

TEST_F(Bench, MeasuresEdits) {
  const Json json = run_json("bench", {"edit", "--items", "2000", "--commits", "1", "--views", view_file()});
  EXPECT_EQ(json["edits"].size(), 6u);
  EXPECT_GT(json["rebuild"]["rebuild_ms"], 0.0);
  ASSERT_EQ(json["boxes"].size(), 2u);
  EXPECT_GT(json["boxes"][0]["batch_us"], 0.0);
  const Json boxes =
      run_json("bench", {"edit", "--subject", "boxes", "--items", "2000", "--commits", "1", "--views", view_file()});
  EXPECT_FALSE(boxes.contains("edits"));
  EXPECT_EQ(boxes["boxes"].size(), 2u);
}

TEST_F(Bench, MeasuresImports) {
  const Json json = run_json("bench", {"import", plant(1000), "--passes", "1"});
  ASSERT_EQ(json.size(), 1u);
  EXPECT_EQ(json[0]["items"], 1000);
  expect_failure("bench", {"import", path("none.rvm")}, "none.rvm");
}

TEST_F(Bench, MeasuresRecognition) {
  const Json json = run_json("bench", {"recognise", "--items", "1000", "--passes", "1", "--segments", "12", "--chords",
                                       "0.02", "--tolerances", "0,0.001", "--plot", path("recognise.svg")});
  ASSERT_EQ(json["rows"].size(), 6u);  // two tessellations, three roundings
  for (const Json& row : json["rows"]) {
    SCOPED_TRACE(row.dump());
    const auto rounding = row["rounding"].get<double>(), of_triangles = row["error_of_triangles"]["mean"].get<double>();
    ASSERT_EQ(row["tolerances"].size(), 2u);
    for (const Json& outcome : row["tolerances"]) {
      EXPECT_GT(outcome["triangles_per_s"], 0.0);
      EXPECT_LE(outcome["surface_error"]["mean"], 1.01 * of_triangles);
    }
    if (rounding > 0.0) continue;
    const Json& automatic = row["tolerances"][0];
    EXPECT_GE(automatic["recovered"], 0.99);
    EXPECT_GE(automatic["items_of_the_kind"], 0.99);
    EXPECT_LT(automatic["surface_error"]["median"], 1e-6);
    EXPECT_LT(automatic["length_error"]["mean"], 1e-6);
    EXPECT_GT(automatic["reported_deviation"], of_triangles);
  }
  // Coordinates in whole millimetres: only with a tolerance as wide is most recognised.
  const Json& rounded = json["rows"][4];
  EXPECT_EQ(rounded["rounding"], 0.001);
  EXPECT_GT(rounded["tolerances"][1]["recovered"], rounded["tolerances"][0]["recovered"]);
  EXPECT_GT(read_bytes(path("recognise.svg")).size(), 500u);
  expect_failure("bench", {"recognise", write("triangle.stl", stl_text({{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}}))},
                 "has no primitives");
  expect_usage_error("bench", {"recognise", "--tolerances", "-1"}, "--tolerances");
}

TEST_F(Bench, MeasuresComparisons) {
  const Json json = run_json("bench", {"compare", "--items", "1000", "--rounds", "1"});
  ASSERT_EQ(json["rows"].size(), 5u);
  EXPECT_EQ(json["rows"][0]["unchanged"], 1000);
  EXPECT_EQ(json["rows"][2]["unchanged"], 1000);
  EXPECT_EQ(json["rows"][3]["moved"], 1000);
  EXPECT_EQ(json["rows"][4]["removed"], 1000);
}

TEST_F(Bench, MeasuresTreeAndSearch) {
  const std::vector<std::string> known = subcommands();
  if (std::find(known.begin(), known.end(), "tree") == known.end()) GTEST_SKIP() << "without the viewer";
  const Json json = run_json("bench", {"tree", plant(1000), "--repeats", "1", "--text", "pipe", "no such text"});
  EXPECT_FALSE(json["tree"]["rows"].empty());
  EXPECT_GT(json["search"]["rows"][0]["found"], 0);
  EXPECT_EQ(json["search"]["rows"][1]["found"], 0);
  EXPECT_EQ(run_json("bench", {"tree", "--nodes", "2000", "--repeats", "1"})["nodes"], 2000);
}

TEST_F(Bench, MeasuresCallsThroughC) {
  const std::vector<std::string> known = subcommands();
  if (std::find(known.begin(), known.end(), "capi") == known.end()) GTEST_SKIP() << "without the C API";
  const Json json = run_json("bench", {"capi", "--rounds", "1"});
  EXPECT_GE(json["rows"].size(), 7u);
  for (const Json& row : json["rows"]) {
    EXPECT_GT(row["cpp_ns"], 0.0) << row;
    EXPECT_GT(row["c_ns"], 0.0) << row;
  }
}

TEST_F(Bench, SaysWhatAContextOffers) {
  const std::vector<std::string> known = subcommands();
  if (std::find(known.begin(), known.end(), "context") == known.end()) GTEST_SKIP() << "without GL";
  const Outcome probe = run("bench", {"context"});
  if (probe.code != 0 && may_skip(probe.err)) GTEST_SKIP() << probe.err;
  ASSERT_EQ(probe.code, 0) << probe;
  for (const char* line : {"platform: ", "renderer: ", "max_clip_distances: ", " extensions: "})
    EXPECT_NE(probe.out.find(line), std::string::npos) << line << probe;
  const Json json = run_json("bench", {"context"});
  EXPECT_GE(json["limits"]["max_clip_distances"], 8);
  EXPECT_GT(json["extensions"].size(), 50u);
  EXPECT_GT(json["milliseconds"], 0.0);
}

TEST_F(Bench, MeasuresTheController) {
  const Json json = run_json("bench", {"controller", "--seeds", "1", "--plot", path("regret.svg")});
  ASSERT_GT(json["traces"].size(), 5u);
  for (const Json& trace : json["traces"]) EXPECT_GE(trace["frame-cost"]["chosen_to_oracle"], 1.0) << trace;
  EXPECT_GT(read_bytes(path("regret.svg")).size(), 500u);
  const std::string views = view_file(), recorded = path("recorded.csv");
  EXPECT_EQ(run("bench", {"controller", "--record", recorded, "--items", "2000", "--views", views}).code, 0);
  EXPECT_EQ(run("bench", {"controller", recorded, "--seeds", "1"}).code, 0);
}

TEST_F(Bench, MeasuresOcclusion) {
  const Json json = run_json("bench", {"occlusion", "--generate", "20000", "--walls", "500", "--occluders", "200",
                                       "--views", "6", "--passes", "1", "--size", "97x55"});
  EXPECT_EQ(json["box_ns"].size(), 3u);
  EXPECT_EQ(json["triangle_ns"].size(), 3u);
  ASSERT_EQ(json["scenes"].size(), 2u);
  for (const Json& scene : json["scenes"]) {
    EXPECT_EQ(scene["owning_but_culled"], 0) << scene;
    EXPECT_GT(scene["owning_a_pixel"], 10.0) << scene;
    EXPECT_GE(scene["left"], scene["left_with_exact_depth"]) << scene;
    EXPECT_GT(scene["culled_of_hidden"], 0.5) << scene;
  }
  expect_usage_error("bench", {"occlusion", "--size", "97"}, "--size");
}

/// The names of the benchmarks that Google Benchmark ran.
std::vector<std::string> names_of(const Json& json) {
  std::vector<std::string> names;
  for (const Json& run : json["benchmarks"]) {
    names.push_back(run["name"].string());
    EXPECT_GT(run["real_time"], 0.0) << run;
  }
  return names;
}

TEST_F(Bench, RunsMicrobenchmarks) {
  const std::vector<std::string> known = subcommands();
  if (std::find(known.begin(), known.end(), "queries") == known.end()) GTEST_SKIP() << "without Google Benchmark";
  const Json queries = run_json("bench", {"queries", "--generate", "2000", "--filter", "box", "--min-time", "0.001"});
  EXPECT_EQ(names_of(queries),
            (std::vector<std::string>{"intersecting a box of 2 m/hierarchy", "intersecting a box of 2 m/linear",
                                      "intersecting a box of 20 m/hierarchy", "intersecting a box of 20 m/linear",
                                      "inside a box of 20 m/hierarchy", "inside a box of 20 m/linear"}));
  for (const Json& run : queries["benchmarks"]) EXPECT_GT(run["found"], 0.0) << run;
  const Json rays = run_json("bench", {"intersect", "--rays", "1000", "--filter", "^box", "--min-time", "0.001"});
  EXPECT_EQ(names_of(rays), (std::vector<std::string>{"box/double"}));
  for (const Json& run : rays["benchmarks"]) {
    EXPECT_GT(run["hit"], 0.1) << run;
    const double rays_ms = 1e3 * 1e3 * run["per ray"].get<double>(), ms = run["cpu_time"].get<double>();
    EXPECT_NEAR(rays_ms, ms, 1e-3 * ms) << run;
  }
  const std::string bad = unwritable("out.json");
  const Args quick = {"intersect", "--rays", "1000", "--filter", "^box/double", "--min-time", "0.001", "--json", bad};
  EXPECT_EQ(run("bench", quick).code, 1);
  EXPECT_EQ(run("bench", {"intersect", "--rays", "1000", "--filter", "no such name"}).code, 1);
}

}  // namespace
}  // namespace sightline::tests::bench_test
