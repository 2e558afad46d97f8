// The sentence that a report begins with says what was measured, whatever came out.
#include "sightline/apps/report/answer.h"

#include <gtest/gtest.h>

namespace sightline::apps::answer_test {
namespace {

TEST(Answer, NamesTheTrianglesThatAreAsGoodAndTheCoarseOnes) {
  const AnswerResults results{
      1,
      0,
      0.0,
      0.0,
      {0.0, 34.0, 0.00009},
      {{0.1, 30.0, 0.08}, {0.03, 40.8, 0.021}, {0.001, 90.0, 0.0007}, {0.0001, 631.0, 0.00009}}};
  EXPECT_EQ(answer_sentence(results),
            "Exact surfaces take 34 ms a frame and are drawn within 0.09 mm of the true ones; triangles as good "
            "(tolerance 0.1 mm) take 631 ms, 19 times as long; coarse ones (tolerance 30 mm) take 41 ms, 1.2 times as "
            "long, and are 21 mm off.");
}

/// Finer triangles that come no nearer are not the ones to compare with.
TEST(Answer, SaysWhereNoTrianglesAreAsGood) {
  const AnswerResults results{
      1, 0, 0.0, 0.0, {0.0, 10.0, 1e-5}, {{0.03, 10.5, 0.02}, {0.003, 15.0, 0.00052}, {0.0001, 50.0, 0.0005}}};
  EXPECT_EQ(
      answer_sentence(results),
      "Exact surfaces take 10 ms a frame and are drawn within 0.01 mm of the true ones; no triangles measured come "
      "nearer than 0.52 mm, and these (tolerance 3 mm) take 15 ms, 1.5 times as long; coarse ones (tolerance 30 "
      "mm) take 10 ms, about as long, and are 20 mm off.");
}

TEST(Answer, SaysWhereTrianglesAreFaster) {
  const AnswerResults results{1, 0, 0.0, 0.0, {0.0, 120.0, 1e-5}, {{0.1, 30.0, 1e-5}, {0.03, 40.0, 1e-5}}};
  EXPECT_EQ(answer_sentence(results),
            "Exact surfaces take 120 ms a frame and are drawn within 0.01 mm of the true ones; triangles as good "
            "(tolerance 100 mm) take 30 ms, 4 times as fast.");
}

TEST(Answer, NamesTheFinestWhereNoneIsAsFineAsTheUsualCoarseOnes) {
  const AnswerResults results{1, 0, 0.0, 0.0, {0.0, 10.0, 1e-5}, {{0.1, 20.0, 0.05}}};
  EXPECT_EQ(
      answer_sentence(results),
      "Exact surfaces take 10 ms a frame and are drawn within 0.01 mm of the true ones; no triangles measured come "
      "nearer than 50 mm, and these (tolerance 100 mm) take 20 ms, 2 times as long.");
}

/// What the file states may be neither the primitives nor the triangles that are drawn.
TEST(Answer, SaysHowFarTheModelIsFromItsFile) {
  EXPECT_EQ(answer_sentence({2, 3, 0.019e-3, 1e-9, {0.0, 10.0, 1e-9}, {}}),
            "Exact surfaces of 2 items and triangles of 3 items, which lie up to 0.019 mm off the surfaces of their "
            "file, take 10 ms a frame and are drawn within 0.001 mm of where they are; triangles were not measured.");
  EXPECT_EQ(answer_sentence({2, 1, 0.0, 0.0, {0.0, 10.0, 1e-5}, {}}),
            "Exact surfaces of 2 items and triangles of 1 item take 10 ms a frame and are drawn within 0.01 mm of "
            "where they are; triangles were not measured.");
  EXPECT_EQ(answer_sentence({0, 3, 0.019e-3, 0.0, {0.0, 10.0, 1e-9}, {}}),
            "The model has no solid primitives: its triangles, which lie up to 0.019 mm off the surfaces of their "
            "file, take 10 ms a frame, and are drawn within 0.001 mm of where they are.");
  EXPECT_EQ(answer_sentence({2, 0, 0.0, 2e-3, {0.0, 10.0, 1e-5}, {}}),
            "Exact surfaces take 10 ms a frame and are drawn within 2 mm of the true ones; triangles were not "
            "measured.");
}

TEST(Answer, SaysWhereNothingIsCompared) {
  EXPECT_EQ(answer_sentence({1, 0, 0.0, 0.0, {0.0, 10.0, 1e-9}, {}}),
            "Exact surfaces take 10 ms a frame and are drawn within 0.001 mm of the true ones; triangles were not "
            "measured.");
  EXPECT_EQ(answer_sentence({0, 4, 0.0, 0.0, {0.0, 3.14, 2e-6}, {}}),
            "The model has no solid primitives: its triangles take 3.1 ms a frame, and are drawn within 0.002 mm of "
            "where they are.");
}

}  // namespace
}  // namespace sightline::apps::answer_test
