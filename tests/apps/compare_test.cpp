// sightline-compare against its contract.
#include <algorithm>
#include <map>
#include <set>

#include "sightline/apps/viewpoints/bcf.h"
#include "sightline/core/view.h"
#include "sightline/importers/rvm/rvm_writer.h"
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
  EXPECT_EQ(keys_of(json), (std::vector<std::string>{"after", "before", "counts", "groups", "items", "nodes", "renamed",
                                                     "tolerance", "with_attributes"}));
  EXPECT_EQ(json["counts"]["unchanged"], 1000);
  EXPECT_EQ(json["groups"], Json::array());
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
  EXPECT_NE(outcome.out.find("1 item (mesh) moved by 3.000 m along +x"), std::string::npos) << outcome;
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
  EXPECT_EQ(json["counts"]["changed"], 0);
  EXPECT_EQ(json["with_attributes"], false);
  std::string other = read_bytes(data + ".txt");
  for (std::size_t at = other.find(":= ", other.find("NEW /")); at != std::string::npos; at = other.find(":= ", at + 3))
    other.insert(at + 3, "x");
  const Json changed = run_json("compare", {data + ".rvm", data + ".rvm", "--old-attributes", write("other.txt", other),
                                            "--new-attributes", data + ".txt"});
  EXPECT_EQ(changed["with_attributes"], true);
  EXPECT_GT(changed["counts"]["changed"].get<int>() + int(changed["nodes"].size()), 0);
  const Args both = {data + ".rvm", data + ".rvm",      "--old-attributes",
                     data + ".txt", "--new-attributes", data + ".txt"};
  EXPECT_EQ(run_json("compare", both)["counts"]["changed"], 0);
}

TEST_F(Compare, ListsAsManyAsAsked) {
  const std::string a = plant(1000, 1), b = plant(1000, 2);
  const Outcome none = run("compare", {a, b, "--list", "0"}), some = run("compare", {a, b, "--list", "3"});
  EXPECT_EQ(std::count(none.out.begin(), none.out.end(), '\n'), 7) << none;
  EXPECT_EQ(std::count(some.out.begin(), some.out.end(), '\n'), 12) << some;
  EXPECT_NE(some.out.find(" more: --all or --html FILE\n"), std::string::npos) << some;
  const Json json = run_json("compare", {a, b});
  const Outcome all = run("compare", {a, b, "--all"});
  EXPECT_EQ(std::count(all.out.begin(), all.out.end(), '\n'), 8 + int(json["groups"].size()));
  EXPECT_EQ(all.out.find("--html"), std::string::npos);
  expect_usage_error("compare", {a, b, "--all", "--list", "3"}, "--list");
}

// --- an edited plant -------------------------------------------------------------------------------------------------

/// Three lines of twenty boxes; of the later revision one has moved, one is red, and of the third half is gone. Names
/// hold what CSV and HTML must quote.
class EditedPlant : public Compare {
 protected:
  void SetUp() override {
    Compare::SetUp();
    before = plant_file("old.rvm", false);
    after = plant_file("new.rvm", true);
  }

  std::string plant_file(const std::string& name, bool later) const {
    core::Scene scene;
    const core::NodeId top = scene.add_node(scene.root(), "plant");
    for (int line = 0; line < 3; ++line) {
      const core::NodeId node = scene.add_node(top, line == 0 ? "a \"large\", <b>" : "line-" + std::to_string(line));
      const bool red = later && line == 1;
      scene.set_material(node,
                         scene.add_material({"", core::vec3(red ? 0.8f : 0.5f, 0.5f, 0.5f), 1.0f, red ? 2u : 1u}));
      for (int i = 0; i < (later && line == 2 ? 10 : 20); ++i)
        scene.add_primitive(scene.add_node(node, "part-" + std::to_string(i)), core::Box{1, 2, 3},
                            core::translation({later && line == 0 ? 1.0 : 0.0, 5.0 * i, 20.0 * line}));
    }
    EXPECT_TRUE(importers::write_rvm(scene, top, path(name)));
    return path(name);
  }

  std::string before, after;
};

TEST_F(EditedPlant, IsToldByGroups) {
  const Outcome outcome = run("compare", {before, after});
  const auto at = [&](const std::string& text) { return outcome.out.find("\n" + text); };
  const std::size_t moved = at("new.rvm/a \"large\", <b>: 20 items moved by 1.000 m along +x\n"),
                    red = at("new.rvm/line-1: 20 items changed in material from rvm 1 #"),
                    gone = at("old.rvm/line-2: 10 of 20 items removed\n");
  for (const std::size_t place : {moved, red, gone}) EXPECT_NE(place, std::string::npos) << outcome;
  EXPECT_LT(std::max(moved, red), gone) << outcome;
  const Json json = run_json("compare", {before, after});
  ASSERT_EQ(json["groups"].size(), 3u);
  for (const Json& group : json["groups"]) {
    if (group["state"] != "moved") continue;
    EXPECT_EQ(group["items"], 20);
    EXPECT_EQ(group["of"], 20);
    EXPECT_EQ(group["differs"], "place");
    EXPECT_NEAR(group["offset"][0].get<double>(), 1.0, 1e-6);
    EXPECT_EQ(group["node"], "new.rvm/a \"large\", <b>");
  }
  EXPECT_EQ(json["items"].size(), 50u);
}

/// Rows of fields, read as RFC 4180 says.
std::vector<std::vector<std::string>> csv_rows(const std::string& text) {
  std::vector<std::vector<std::string>> rows{{""}};
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '"' && text[i + 1] == '"')
      rows.back().back() += text[i++];
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && c == ',')
      rows.back().emplace_back();
    else if (!quoted && c == '\r' && text[i + 1] == '\n')
      rows.emplace_back(1, ""), ++i;
    else
      rows.back().back() += c;
  }
  rows.pop_back();
  return rows;
}

TEST_F(EditedPlant, CsvHasARowForEachItem) {
  ASSERT_EQ(run("compare", {before, after, "--csv", path("a.csv")}).code, 0);
  const auto rows = csv_rows(read_bytes(path("a.csv")));
  ASSERT_EQ(rows.size(), 51u);
  EXPECT_EQ(rows[0], (std::vector<std::string>{"state", "path", "kind", "dx_m", "dy_m", "dz_m", "turn_deg", "changed",
                                               "old_path", "old", "new"}));
  std::map<std::string, int> states;
  for (const auto& row : rows) {
    ASSERT_EQ(row.size(), rows[0].size());
    ++states[row[0]];
  }
  EXPECT_EQ(states, (std::map<std::string, int>{{"state", 1}, {"moved", 20}, {"changed", 20}, {"removed", 10}}));
  EXPECT_EQ(rows[1][1], "new.rvm/a \"large\", <b>/part-0");
  EXPECT_EQ(rows[1][3], "1");
  EXPECT_EQ(rows[1][7], "place");
  EXPECT_EQ(rows[21][7], "material");
  EXPECT_EQ(rows[21][9].rfind("material=rvm 1 #", 0), 0u) << rows[21][9];
  EXPECT_EQ(rows[21][10].rfind("material=rvm 2 #", 0), 0u) << rows[21][10];
  const Outcome outcome = run("compare", {before, after, "--csv", "-"});
  EXPECT_EQ(outcome.out, read_bytes(path("a.csv")));
}

TEST_F(EditedPlant, PageHasGroupsAndTheirItems) {
  ASSERT_EQ(run("compare", {before, after, "--html", path("a.html")}).code, 0);
  const std::string page = read_bytes(path("a.html"));
  const auto has = [&](const std::string& text) { return page.find(text) != std::string::npos; };
  EXPECT_TRUE(has("new.rvm/a &quot;large&quot;, &lt;b&gt;: 20 items moved by 1.000 m along +x</summary>"));
  EXPECT_TRUE(has("<th scope=\"row\">part-19</th><td>box</td>"));
  EXPECT_TRUE(has("background: #56b4e9")) << "the viewer's colour of what has moved";
  EXPECT_FALSE(has("<b>")) << "names are escaped";
  EXPECT_FALSE(has("<script"));
#if SIGHTLINE_HAS_GROUP_IMAGES
  EXPECT_TRUE(has("<img alt=\"before\" src=\"data:image/png;base64,"));
  EXPECT_TRUE(has("<img alt=\"after\" src=\"data:image/png;base64,"));
#endif
}

#if SIGHTLINE_HAS_BCF

TEST_F(EditedPlant, BcfHasATopicForEachGroup) {
  ASSERT_EQ(run("compare", {before, after, "--bcf", path("a.bcf")}).code, 0);
  const auto file = apps::parse_bcf(read_bytes(path("a.bcf")), "a.bcf");
  ASSERT_TRUE(file) << file.error().message;
  ASSERT_EQ(file->views.size(), 3u);
  EXPECT_EQ(file->left_out, 0u);
  const auto moved = std::find_if(file->views.begin(), file->views.end(), [](const apps::Viewpoint& view) {
    return view.name == "a \"large\", <b>: 20 items moved by 1.000 m along +x";
  });
  ASSERT_NE(moved, file->views.end());
  EXPECT_TRUE(moved->comment.starts_with("new.rvm/a \"large\", <b>: 20 items moved")) << moved->comment;
  EXPECT_NE(moved->comment.find("part-0 (box)\n"), std::string::npos) << moved->comment;
  EXPECT_NE(moved->comment.find("and 10 more items"), std::string::npos) << moved->comment;
  EXPECT_FALSE(moved->author.empty());
#if SIGHTLINE_HAS_GROUP_IMAGES
  EXPECT_GT(moved->snapshot.size(), 1000u);
#endif
  ASSERT_TRUE(moved->shown);
  ASSERT_EQ(moved->shown->selection.parts.size(), 1u);
  EXPECT_EQ(moved->shown->selection.parts[0].node, "new.rvm/a \"large\", <b>");
  // All of the group lies in the image, and reaches across half of it.
  const auto view = core::View::perspective(moved->pose, moved->fovy, 4.0 / 3.0, 0.1);
  ASSERT_TRUE(view);
  double reach = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const core::dvec4 clip =
        view->clip_from_world() * core::dvec4(corner & 1 ? 1.5 : 0.5, corner & 2 ? 96 : -1, corner & 4 ? 1.5 : -1.5, 1);
    ASSERT_GT(clip.w, 0.0);
    reach = std::max({reach, std::abs(clip.x / clip.w), std::abs(clip.y / clip.w)});
  }
  EXPECT_NEAR(reach, 0.5, 0.1);
  for (const apps::Viewpoint& topic : file->views)
    EXPECT_EQ(topic.shown->selection.empty(), topic.name.find("removed") != std::string::npos) << topic.name;
}

TEST_F(Compare, BcfIsCappedAndSaysSo) {
  const std::string a = plant(2000, 1), b = plant(2000, 2);
  const Outcome outcome = run("compare", {a, b, "--bcf", path("a.bcf")});
  EXPECT_NE(outcome.err.find("has the 100 largest of "), std::string::npos) << outcome;
  const auto file = apps::parse_bcf(read_bytes(path("a.bcf")), "a.bcf");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->views.size(), 100u);
  std::set<std::string> guids;
  for (const apps::Viewpoint& view : file->views) guids.insert(view.guid);
  EXPECT_EQ(guids.size(), 100u);
}

#endif

TEST_F(Compare, RefusesBadInput) {
  const std::string good = plant(1000);
  for (const std::string& file : bad_models()) {
    const std::string name = fs::path(file).filename().string();
    expect_failure("compare", {file, good}, name);
    expect_failure("compare", {good, file}, name);
  }
  for (const char* bad : {"-1", "nan", "inf", "x", ""})
    expect_usage_error("compare", {good, good, "--tolerance", bad}, "--tolerance");
  expect_usage_error("compare", {good}, "NEW");
  expect_usage_error("compare", {good, good, "--list", "-1"}, "--list");
  const std::string unwritable_file = unwritable("a.json");
  for (const char* option : {"--json", "--html", "--csv", "--bcf"})
    expect_failure("compare", {good, good, option, unwritable_file}, unwritable_file);
}

}  // namespace
}  // namespace sightline::tests::compare_test
