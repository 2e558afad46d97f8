// sightline-bench error-time as a user runs it: finer triangles are nearer to the truth, and rays nearest.
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::bench_error_time_test {
namespace {

const Args kQuick = {"error-time", "--size", "160x120", "--segments", "8,32", "--passes", "1"};

Args quick(std::initializer_list<std::string> more) {
  Args args = kQuick;
  args.insert(args.end(), more);
  return args;
}

using BenchErrorTime = RenderTest;

TEST_F(BenchErrorTime, MeasuresKinds) {
  const Json rows = run_json(
      "bench", quick({"--only", "cylinder,box", "--images", "1", "--samples", "2", "--plot", path("kinds")}))["rows"];
  ASSERT_EQ(rows.size(), 2u * 3 + 2 * 2);  // two sizes each; boxes have one number of triangles
  for (const Json& row : rows) {
    SCOPED_TRACE(row.dump());
    EXPECT_GT(row["ms"], 0.0);
    EXPECT_TRUE(row["form"] != "GLSL" || row["bytes_per_item"] < 120.0);
  }
  for (const std::size_t first : {0, 3}) {
    SCOPED_TRACE(rows[first].dump());
    ASSERT_EQ(rows[first]["primitive"], "cylinder");
    EXPECT_GT(rows[first]["hits"], 5000);
    for (const char* error : {"depth", "normal", "silhouette"}) {
      SCOPED_TRACE(error);
      const auto mean = [&](std::size_t form) { return rows[first + form][error]["mean"].get<double>(); };
      EXPECT_GT(mean(0), 5.0 * mean(1)) << "8 and 32 segments";
      EXPECT_GT(mean(1), 10.0 * mean(2)) << "GLSL";
    }
  }
  for (const char* file : {"kinds-silhouette.svg", "kinds-depth.svg", "kinds-normal.svg"})
    EXPECT_GT(read_bytes(path(file)).size(), 500u) << file;
}

TEST_F(BenchErrorTime, MeasuresModels) {
  const Json rows =
      run_json("bench", quick({plant(1000), "--segments", "64", "--reference", "64", "--plot", path("plant")}))["rows"];
  ASSERT_EQ(rows.size(), 3u * 4);  // GLSL, and triangles, from three views
  for (std::size_t first = 0; first < rows.size(); first += 4) {
    SCOPED_TRACE(rows[first]["view"].get<std::string>());
    const auto mean = [&](std::size_t form, const char* measure) {
      return rows[first + form][measure]["mean"].get<double>();
    };
    EXPECT_LT(mean(0, "gpu_kb"), mean(2, "gpu_kb"));
    EXPECT_GT(mean(1, "flip"), mean(2, "flip"));
    EXPECT_GT(mean(1, "flip"), mean(0, "flip"));
    EXPECT_EQ(mean(3, "wrong_ids"), 0.0) << "the reference itself";
  }
  for (const char* file : {"plant-time.svg", "plant-bytes.svg"}) EXPECT_GT(read_bytes(path(file)).size(), 500u) << file;
}

TEST_F(BenchErrorTime, TakesViewsByTheModelsName) {
  const std::string model = plant(1000), stem = fs::path(model).stem().string();
  fs::create_directories(path("views"));
  const std::string view = R"({"eye":[-30,-30,20],"target":[0,0,0],"fovy_deg":60,"near":0.1})";
  write("views/" + stem + "_first.json", view);
  write("views/" + stem + "_second.json", view);
  write("views/other_third.json", view);
  const Json json = run_json("bench", quick({model, "--views", path("views"), "--reference", "64"}));
  ASSERT_EQ(json["rows"].size(), 2u * 3);
  EXPECT_EQ(json["rows"][0]["view"], "first");
  EXPECT_EQ(json["rows"][3]["view"], "second");
}

TEST_F(BenchErrorTime, RefusesWhatMakesNoSense) {
  expect_usage_error("bench", {"error-time", "--only", "line"}, "line");
  expect_usage_error("bench", {"error-time", "--segments", "2"}, "--segments");
  expect_failure("bench", {"error-time", "--size", "100x200"}, "--size", true);
  expect_failure("bench", {"error-time", path("none.rvm")}, "none.rvm", true);
  fs::create_directories(path("empty"));
  expect_failure("bench", quick({plant(1000), "--views", path("empty")}), "has no view", true);
}

}  // namespace
}  // namespace sightline::tests::bench_error_time_test
