// What every subcommand of sightline-study about a part of the library promises on its command line, and quick runs of
// those that need no GL.
#include "sightline/study/parts/parts.h"

#include "sightline/study/tests/study_program.h"

namespace sightline::tests::parts_test {
namespace {

class Parts : public StudyTest {
 protected:
  static std::vector<std::string> parts() {
    std::vector<std::string> names;
    for (const bench::Subcommand& part : bench::parts()) names.emplace_back(part.name);
    return names;
  }

  /// One view from outside a made-up plant.
  std::string view_file() const {
    const std::array<double, 16> clip_from_world = {0.01, 0, 0, 0, 0, 0.01, 0, 0, 0, 0, -0.01, 0, -1, -1, 0, 1};
    return write("views.f64", std::string(reinterpret_cast<const char*>(clip_from_world.data()), 128));
  }
};

TEST_F(Parts, EachHasHelpWithExamples) {
  for (const std::string& name : parts()) {
    const Outcome outcome = run("study", {name, "--help"});
    EXPECT_EQ(outcome.code, 0) << outcome;
    EXPECT_EQ(outcome.err, "");
    const std::size_t examples = outcome.out.find("Examples:");
    ASSERT_NE(examples, std::string::npos) << outcome;
    EXPECT_NE(outcome.out.find("sightline-study " + name, examples), std::string::npos) << outcome;
    EXPECT_NE(outcome.out.find("--json"), std::string::npos) << outcome;
    expect_usage_error("study", {name, "--json"}, "--json");
  }
}

TEST_F(Parts, MeasuresRecognition) {
  const Json json = run_json("study", {"recognise", "--items", "1000", "--passes", "1", "--segments", "12", "--chords",
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
  expect_failure("study", {"recognise", write("triangle.stl", stl_text({{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}}))},
                 "has no primitives");
  expect_usage_error("study", {"recognise", "--tolerances", "-1"}, "--tolerances");
}

TEST_F(Parts, MeasuresTheController) {
  const Json json = run_json("study", {"controller", "--seeds", "1", "--plot", path("regret.svg")});
  ASSERT_GT(json["traces"].size(), 5u);
  for (const Json& trace : json["traces"]) EXPECT_GE(trace["controller"]["chosen_to_oracle"], 1.0) << trace;
  EXPECT_GT(read_bytes(path("regret.svg")).size(), 500u);
  const std::string views = view_file(), recorded = path("recorded.csv");
  EXPECT_EQ(run("study", {"controller", "--record", recorded, "--items", "2000", "--views", views}).code, 0);
  EXPECT_EQ(run("study", {"controller", recorded, "--seeds", "1"}).code, 0);
}

}  // namespace
}  // namespace sightline::tests::parts_test
