// sightline-compare against its contract.
#include "sightline/tests/apps/tool_test.h"
#include "sightline/tests/support/places.h"

namespace sightline::tests::compare_test {
namespace {

using Compare = ToolTest;

/// Two triangles, the second one moved along x.
std::string triangles(int x) {
  return stl_text({{{{x, 0, 0}, {x + 2, 0, 0}, {x, 1, 0}}}, {{{x, 0, 3}, {x + 1, 0, 4}, {x, 5, 3}}}});
}

TEST_F(Compare, FindsAModelLikeItself) {
  const std::string model = plant(1000);
  const Json json = run_json("compare", {model, model});
  EXPECT_EQ(keys_of(json),
            (std::vector<std::string>{"after", "before", "counts", "items", "nodes", "renamed", "tolerance"}));
  EXPECT_EQ(json["counts"]["unchanged"], 1000);
  EXPECT_EQ(json["items"], Json::array());
  EXPECT_EQ(json["nodes"], Json::array());
  EXPECT_EQ(run("compare", {model, model, "--fail-on-changes"}).code, 0);
}

TEST_F(Compare, TellsWhatMovedAndByHowMuch) {
  const std::string before = write("old.stl", triangles(0)), after = write("new.stl", triangles(3));
  const Json json = run_json("compare", {before, after});
  EXPECT_EQ(json["counts"]["moved"], 1);
  ASSERT_EQ(json["items"].size(), 1u);
  EXPECT_EQ(json["items"][0]["state"], "moved");
  EXPECT_EQ(json["items"][0]["differs"], Json::array({"place"}));
  EXPECT_NEAR(json["items"][0]["offset"][0].get<double>(), 3.0, 1e-6);
  EXPECT_NEAR(json["items"][0]["turn_deg"].get<double>(), 0.0, 1e-6);
  EXPECT_EQ(run_json("compare", {before, after, "--tolerance", "4"})["counts"]["unchanged"], 1);
  const Outcome outcome = run("compare", {before, after, "--fail-on-changes"});
  EXPECT_EQ(outcome.code, 1) << outcome;
  EXPECT_NE(outcome.out.find("by 3.0000 m"), std::string::npos) << outcome;
}

TEST_F(Compare, CountsWhatCameAndWent) {
  const Json json = run_json("compare", {plant(1000, 1), plant(1100, 2)});
  const Json& counts = json["counts"];
  const auto of = [&](const char* state) { return counts[state].get<int>(); };
  EXPECT_EQ(of("unchanged") + of("moved") + of("changed") + of("removed"), 1000);
  EXPECT_EQ(of("unchanged") + of("moved") + of("changed") + of("added"), 1100);
  EXPECT_GT(of("moved") + of("changed"), 0);
}

TEST_F(Compare, ReadsAttributeFiles) {
  const std::string data = in_checkout("tests/data/small_plant").string();
  const Json json = run_json("compare", {data + ".rvm", data + ".rvm", "--new-attributes", data + ".txt"});
  EXPECT_GT(json["counts"]["changed"].get<int>() + int(json["nodes"].size()), 0);
  const Args both = {data + ".rvm", data + ".rvm",      "--old-attributes",
                     data + ".txt", "--new-attributes", data + ".txt"};
  EXPECT_EQ(run_json("compare", both)["counts"]["changed"], 0);
}

TEST_F(Compare, ListsAsManyAsAsked) {
  const std::string a = plant(1000, 1), b = plant(1000, 2);
  const Outcome none = run("compare", {a, b, "--list", "0"}), some = run("compare", {a, b, "--list", "3"});
  EXPECT_EQ(std::count(none.out.begin(), none.out.end(), '\n'), 7) << none;
  EXPECT_EQ(std::count(some.out.begin(), some.out.end(), '\n'), 11) << some;
  EXPECT_NE(some.out.find("more (--list N)"), std::string::npos) << some;
}

TEST_F(Compare, RefusesBadInput) {
  const std::string good = plant(1000);
  for (const std::string& file : bad_models()) {
    const std::string name = fs::path(file).filename();
    expect_failure("compare", {file, good}, name);
    expect_failure("compare", {good, file}, name);
  }
  for (const char* bad : {"-1", "nan", "inf", "x", ""})
    expect_usage_error("compare", {good, good, "--tolerance", bad}, "--tolerance");
  expect_usage_error("compare", {good}, "NEW");
  expect_usage_error("compare", {good, good, "--list", "-1"}, "--list");
  const std::string unwritable_file = unwritable("a.json");
  expect_failure("compare", {good, good, "--json", unwritable_file}, unwritable_file);
}

}  // namespace
}  // namespace sightline::tests::compare_test
