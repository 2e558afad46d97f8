// sightline-generate: the same bytes for the same seed, exactly as many items as asked for.
#include "sightline/tests/apps/tool_test.h"

namespace sightline::tests::generate_test {
namespace {

using Generate = ToolTest;

TEST_F(Generate, TheSeedDecidesEveryByte) {
  const std::string first = read_bytes(plant(1000, 7)), other = read_bytes(plant(1000, 8));
  const std::string again = read_bytes(plant(1000, 7));
  ASSERT_FALSE(first.empty());
  EXPECT_TRUE(first == again);
  EXPECT_FALSE(first == other);
}

TEST_F(Generate, WritesExactlySoManyItems) {
  for (const int items : {1000, 1001, 4321}) {
    const Json info = run_json("info", {plant(items)});
    int total = 0;
    for (const auto& [kind, count] : info["items"].items()) total += count.get<int>();
    EXPECT_EQ(total, items);
    EXPECT_EQ(info["warnings"], Json::array());
  }
}

TEST_F(Generate, ReportsAsJson) {
  const Json facts = run_json("generate", {path("a.rvm"), "--items", "1000", "--seed", "18446744073709551615"});
  EXPECT_EQ(facts["file"], path("a.rvm"));
  EXPECT_EQ(facts["items"], 1000);
  EXPECT_EQ(facts["seed"], 18446744073709551615u);
}

TEST_F(Generate, LeavesNothingElseBehind) {
  fs::create_directories(path("out"));
  ASSERT_EQ(run("generate", {path("out/a.rvm"), "--items", "1000"}).code, 0);
  ASSERT_EQ(run("generate", {path("out/a.rvm"), "--items", "1000"}).code, 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(path("out")), fs::directory_iterator()), 1);
}

}  // namespace
}  // namespace sightline::tests::generate_test
