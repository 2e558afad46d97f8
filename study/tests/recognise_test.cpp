// sightline-study recognise --images as a user runs it. All else of it is tested without GL (parts_test.cpp).
#include "sightline/study/tests/study_program_gl.h"

namespace sightline::tests::recognise_test {
namespace {

class Recognise : public StudyGlTest {};

TEST_F(Recognise, WhatIsRecognisedLooksLikeTheOriginal) {
  const Json json = run_json("study", {"recognise", "--items", "1000", "--passes", "1", "--segments", "8,64",
                                       "--roundings", "0", "--tolerances", "0", "--images", "3"});
  ASSERT_EQ(json["rows"].size(), 2u);
  for (const Json& row : json["rows"]) {
    SCOPED_TRACE(row.dump());
    const Json &triangles = row["images"]["triangles"], &recognised = row["images"]["recognised"];
    EXPECT_GT(triangles["flip"], 0.0);
    EXPECT_GT(triangles["wrong_ids"], 0.0);
    EXPECT_LT(triangles["flip"], 0.5);  // the same plant from the same places
    EXPECT_LT(recognised["flip"].get<double>(), 0.1 * triangles["flip"].get<double>());
    EXPECT_LT(recognised["wrong_ids"].get<double>(), 0.1 * triangles["wrong_ids"].get<double>());
  }
  const Json &coarse = json["rows"][0]["images"], &fine = json["rows"][1]["images"];
  EXPECT_GT(coarse["triangles"]["flip"], fine["triangles"]["flip"]);
  EXPECT_GT(coarse["triangles"]["wrong_ids"], fine["triangles"]["wrong_ids"]);
}

TEST_F(Recognise, ImagesAreOnlyTakenWhenAskedFor) {
  const std::vector<std::string> arguments = {"recognise", "--items",     "1000", "--passes",     "1", "--segments",
                                              "8",         "--roundings", "0",    "--tolerances", "0"};
  EXPECT_FALSE(run_json("study", arguments)["rows"][0].contains("images"));
  expect_usage_error("study", {"recognise", "--images", "-1"}, "--images");
  expect_usage_error("study", {"recognise", "--images", "many"}, "--images");
}

}  // namespace
}  // namespace sightline::tests::recognise_test
