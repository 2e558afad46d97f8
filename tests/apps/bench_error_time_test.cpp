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
  const Json json = run_json("bench", quick({"--only", "cylinder,box", "--images", "1", "--samples", "2", "--csv",
                                             path("kinds.csv"), "--plot", path("kinds")}));
  ASSERT_EQ(json["kinds"].size(), 4u);  // two sizes each
  for (const Json& kind : json["kinds"]) {
    SCOPED_TRACE(kind["primitive"].get<std::string>() + " " + kind["pixels"].dump());
    const Json& forms = kind["forms"];
    ASSERT_EQ(forms.size(), kind["primitive"] == "box" ? 3u : 4u);
    for (const Json& form : forms) EXPECT_GT(form["ms"], 0.0);
    const Json &glsl = forms[forms.size() - 2], &reference = forms.back();
    EXPECT_EQ(glsl["form"], "GLSL");
    EXPECT_LT(glsl["bytes_per_item"], 120.0);
    EXPECT_EQ(reference["form"], "C++ double");
    EXPECT_EQ(reference["false_hits"], 0);
    EXPECT_EQ(reference["depth"]["max"], 0.0);
    if (kind["primitive"] != "cylinder") continue;
    EXPECT_GT(kind["samples_hit"], 5000);
    for (const char* error : {"depth", "normal_deg", "silhouette_px"}) {
      SCOPED_TRACE(error);
      const auto coarse = forms[0][error]["mean"].get<double>(), fine = forms[1][error]["mean"].get<double>(),
                 cast = glsl[error]["mean"].get<double>();
      EXPECT_GT(coarse, 5.0 * fine);
      EXPECT_GT(fine, 10.0 * cast);
    }
  }
  for (const char* file : {"kinds.csv", "kinds-silhouette.svg", "kinds-depth.svg", "kinds-normal.svg"})
    EXPECT_GT(read_bytes(path(file)).size(), 500u) << file;
}

TEST_F(BenchErrorTime, MeasuresModels) {
  const Json json =
      run_json("bench", quick({plant(1000), "--reference", "64", "--csv", path("plant.csv"), "--plot", path("plant")}));
  ASSERT_EQ(json["models"].size(), 1u);
  ASSERT_EQ(json["models"][0]["views"].size(), 3u);
  for (const Json& view : json["models"][0]["views"]) {
    SCOPED_TRACE(view["view"].get<std::string>());
    const Json& forms = view["forms"];
    ASSERT_EQ(forms.size(), 4u);  // GLSL, two, the reference
    EXPECT_LT(forms[0]["gpu_bytes"], forms[2]["gpu_bytes"]);
    EXPECT_GT(forms[1]["to_triangles"]["flip"]["mean"], forms[2]["to_triangles"]["flip"]["mean"]);
    EXPECT_GT(forms[1]["to_triangles"]["flip"]["mean"], forms[0]["to_triangles"]["flip"]["mean"]);
    EXPECT_EQ(forms[0]["to_ray_cast"]["wrong_ids"], 0);
    EXPECT_EQ(forms[3]["to_triangles"]["wrong_ids"], 0);
  }
  for (const char* file : {"plant.csv", "plant-time.svg", "plant-bytes.svg"})
    EXPECT_GT(read_bytes(path(file)).size(), 500u) << file;
}

TEST_F(BenchErrorTime, TakesViewsByTheModelsName) {
  const std::string model = plant(1000), stem = fs::path(model).stem().string();
  fs::create_directories(path("views"));
  const std::string view = R"({"eye":[-30,-30,20],"target":[0,0,0],"fovy_deg":60,"near":0.1})";
  write("views/" + stem + "_first.json", view);
  write("views/" + stem + "_second.json", view);
  write("views/other_third.json", view);
  const Json json = run_json("bench", quick({model, "--views", path("views"), "--reference", "64"}));
  ASSERT_EQ(json["models"][0]["views"].size(), 2u);
  EXPECT_EQ(json["models"][0]["views"][0]["view"], "first");
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
