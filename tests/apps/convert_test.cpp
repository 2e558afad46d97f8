// sightline-convert: what goes in comes out, and nothing half-written is left.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "sightline/importers/import.h"
#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::convert_test {
namespace {

class Convert : public ToolTest {
 protected:
  static int total(const Json& items) {
    int sum = 0;
    for (const auto& [kind, count] : items.items()) sum += count.get<int>();
    return sum;
  }
};

constexpr const char* kStlText =
    "solid part\nfacet normal 0 0 1\nouter loop\nvertex 1000001000 0 0\nvertex 1000003000 0 0\n"
    "vertex 1000001000 2000 0\nendloop\nendfacet\nendsolid part\n";

TEST_F(Convert, RvmComesBackAsItWas) {
  const std::string model = plant(1000);
  const Json facts = run_json("convert", {model, path("again.RVM")});
  EXPECT_TRUE(read_bytes(model) == read_bytes(path("again.RVM")));
  EXPECT_EQ(facts["inputs"], Json::array({model}));
  EXPECT_EQ(facts["output"], path("again.RVM"));
  EXPECT_EQ(facts["items_in"], facts["items_out"]);
  EXPECT_EQ(total(facts["items_out"]), 1000);
  EXPECT_EQ(facts["left_out"], 0);
  EXPECT_EQ(facts["bytes_in"], read_bytes(model).size());
  EXPECT_EQ(facts["bytes_out"], read_bytes(model).size());
  EXPECT_EQ(facts["tessellation"], nullptr);
  EXPECT_EQ(facts["warnings"], Json::array());
}

TEST_F(Convert, WritesOverNoFileThatItReads) {
  const std::string model = plant(1000), bytes = read_bytes(model);
  Args outputs = {model, path("./") + fs::path(model).filename().string()};
  if (make_link(model, path("link.rvm"))) outputs.push_back(path("link.rvm"));
  for (const std::string& output : outputs)
    expect_usage_error("convert", {model, output, "--translate", "1,0,0"}, "would be lost");
  EXPECT_EQ(read_bytes(model), bytes);
}

/// Nor over one that such a file names.
TEST_F(Convert, KeepsTheMaterialsOfWhatItReads) {
  write("shared.mtl", "newmtl red\nKd 1 0 0\n");
  const std::string model = write("part.obj", "mtllib shared.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  expect_failure("convert", {model, path("shared.obj")}, "would be lost");
  EXPECT_EQ(read_bytes(path("shared.mtl")), "newmtl red\nKd 1 0 0\n");
}

/// Parts have the groups that they are in, and nothing else.
TEST_F(Convert, OnlyWritesParts) {
  const std::string model = plant(1000);
  const auto part = [&](const Args& only) {
    Args args{model, path("part.rvm"), "--translate", "0,0,5"};
    for (const std::string& one : only) args.insert(args.end(), {"--only", one});
    EXPECT_EQ(run("convert", args).code, 0);
    return run_json("info", {path("part.rvm")});
  };
  const Json all = run_json("info", {model}), one = part({"PIPE-2-B1"}), zone = part({"zone-rack"}),
             two = part({"PIPE-2-B1", "PIPE-2-B2"});
  EXPECT_EQ(one["nodes"], 6) << "root, file, site, zone, pipe, branch";
  EXPECT_EQ(two["nodes"], 7);
  EXPECT_GT(total(one["items"]), 0);
  EXPECT_GT(total(two["items"]), total(one["items"]));
  EXPECT_GT(total(zone["items"]), total(two["items"]));
  EXPECT_LT(total(zone["items"]), 1000);
  EXPECT_GE(zone["bounds"]["min"][2].get<double>(), all["bounds"]["min"][2].get<double>() + 5.0 - 1e-3);
  EXPECT_LE(zone["bounds"]["max"][0].get<double>(), all["bounds"]["max"][0].get<double>() + 1e-3);
  ASSERT_EQ(run("convert", {model, path("whole.rvm"), "--only", fs::path(model).filename().string()}).code, 0);
  EXPECT_TRUE(read_bytes(model) == read_bytes(path("whole.rvm")));
  expect_failure("convert", {model, path("none.rvm"), "--only", "NO SUCH PART"}, "no part fits \"NO SUCH PART\"");
  EXPECT_FALSE(fs::exists(path("none.rvm")));
}

/// Two triangles for each name.
std::string objects(const std::vector<std::string>& names) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  for (const std::string& name : names) text += "o " + name + "\nf 1 2 3\nf 1 2 4\n";
  return text;
}

TEST_F(Convert, PartsAreNamedExactlyBeforeTheyAreLookedFor) {
  const std::string model = write(
      "line.obj", objects({"PIPE-21", "PIPE-210", "PIPE-211", "pipe-3", "PUMP 1", "PUMP 2", "W\u00e4rme", "PIPE-4"}));
  const auto kept = [&](const Args& more) {
    Args args{model, path("part.obj"), "--up", "y"};  // no note asks for it
    args.insert(args.end(), more.begin(), more.end());
    const Outcome done = run("convert", args);
    EXPECT_EQ(done.code, 0) << done;
    std::istringstream in(read_bytes(path("part.obj")));
    std::string names;
    for (std::string line; std::getline(in, line);)
      if (line.starts_with("o ")) names += line.substr(2) + ",";
    return names + done.err;
  };
  EXPECT_EQ(kept({"--only", "PIPE-21"}), "PIPE-21,");
  EXPECT_EQ(kept({"--only", "pipe-21"}), "PIPE-21,");
  EXPECT_EQ(kept({"--only", "/line.obj/PIPE-21"}), "PIPE-21,");
  EXPECT_EQ(kept({"--only", "Name=PIPE-21"}), "PIPE-21,");
  EXPECT_EQ(kept({"--only", "w\u00e4rme"}), "W\u00e4rme,");
  EXPECT_EQ(kept({"--only", "PUMP"}),
            "PUMP 1,PUMP 2,note: \"PUMP\": 2 parts by whole words: line.obj/PUMP 1, line.obj/PUMP 2\n");
  EXPECT_EQ(kept({"--only", "PIPE-21?"}),
            "PIPE-210,PIPE-211,note: \"PIPE-21?\": 2 parts by pattern: line.obj/PIPE-210, line.obj/PIPE-211\n");
  EXPECT_EQ(kept({"--only", "re:^PIPE-\\d$", "--except", "pipe-3"}),
            "PIPE-4,note: \"re:^PIPE-\\d$\": 2 parts by pattern: line.obj/pipe-3, line.obj/PIPE-4\n");
  EXPECT_EQ(kept({"--except", "PIPE-21", "--except", "W\u00e4rme"}), "PIPE-210,PIPE-211,pipe-3,PUMP 1,PUMP 2,PIPE-4,");

  const auto refused = [&](const Args& more, const std::string& why) {
    Args args{model, path("none.obj"), "--up", "y"};
    args.insert(args.end(), more.begin(), more.end());
    expect_failure("convert", args, why);
    EXPECT_FALSE(fs::exists(path("none.obj")));
  };
  refused({"--only", "PIPE-2"}, "no part fits \"PIPE-2\"; similar names: PIPE-21, PIPE-210, PIPE-211, PIPE-4, pipe-3");
  refused({"--only", "PIPE-21", "--only", "PIPE-5x"}, "no part fits \"PIPE-5x\"");
  refused({"--only", "PIPE-21", "--except", "PIPE-21"}, "leave no item to write");
  expect_usage_error("convert", {model, path("none.obj"), "--only", ""}, "--only");
  expect_usage_error("convert", {model, path("none.obj"), "--except", "re:("}, "closing parenthesis");
}

/// What --list prints are names that other tools take.
TEST_F(Convert, TakesThePathsThatInfoPrints) {
  const std::string model = plant(2000);
  const Json listed = run_json("info", {model, "--list", "PIPE-2-*"})["found"];
  ASSERT_GT(listed.size(), 2u);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string at = listed[i]["path"].get<std::string>();
    const Json again = run_json("info", {model, "--list", at})["found"];
    ASSERT_EQ(again.size(), 1u) << at;
    EXPECT_EQ(again[0]["path"], at);
    const std::string end = at.substr(at.find('/'));
    EXPECT_EQ(run("convert", {model, path("part.rvm"), "--only", end}).err, "") << end;
  }
  const Outcome search = run("info", {model, "--list", "PIPE-2-", "--json", "-"});  // no word, but the begin of names
  EXPECT_EQ(search.code, 0);
  EXPECT_NE(search.err.find("no part fits \"PIPE-2-\""), std::string::npos) << search.err;
  auto found = json::parse(search.out);
  ASSERT_TRUE(found);
  EXPECT_EQ((*found)["found"], listed);
  expect_failure("info", {model, "--list", "PIPE-2-no"}, "no part fits");
  expect_failure("convert", {model, path("none.rvm"), "--only", "PIPE-2-"}, "no part fits");
}

TEST_F(Convert, SeveralFilesBecomeOne) {
  ASSERT_EQ(run("convert", {plant(1000, 1), plant(1001, 2), path("both.rvm")}).code, 0);
  EXPECT_EQ(total(run_json("info", {path("both.rvm")})["items"]), 2001);
}

TEST_F(Convert, MovesTheModel) {
  const std::string model = plant(1000);
  ASSERT_EQ(run("convert", {"--translate", "100,0,-7", model, path("moved.rvm")}).code, 0);
  const Json here = run_json("info", {model}), there = run_json("info", {path("moved.rvm")});
  EXPECT_NEAR(there["bounds"]["min"][0].get<double>(), here["bounds"]["min"][0].get<double>() + 100.0, 1e-3);
  EXPECT_NEAR(there["bounds"]["max"][2].get<double>(), here["bounds"]["max"][2].get<double>() - 7.0, 1e-3);
}

TEST_F(Convert, TilesAreAFolder) {
  const std::string model = plant(1000);
  const Json facts = run_json("convert", {model, path("tiles"), "--tiles", "--tolerance", "0.0005"});
  EXPECT_EQ(total(facts["items_out"]), 1000);
  EXPECT_EQ(facts["left_out"], 0);
  EXPECT_EQ(facts["tiles"]["tolerance"], 0.0005);
  EXPECT_LE(facts["tiles"]["largest_chord_error"].get<double>(), 0.0005);
  EXPECT_GT(facts["tiles"]["tiles"].get<int>(), 1);
  EXPECT_GT(facts["tiles"]["whole_error"].get<double>(), facts["tiles"]["root_error"].get<double>());
  std::uint64_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(path("tiles")))
    if (entry.is_regular_file()) bytes += entry.file_size();
  EXPECT_EQ(facts["bytes_out"], bytes);
  const Json tileset = json::parse(read_bytes(path("tiles/tileset.json"))).value();
  EXPECT_EQ(tileset["asset"]["version"], "1.1");
  EXPECT_EQ(tileset["asset"]["extras"]["tolerance"], 0.0005);
  // A tileset is replaced, a folder of others is not.
  const Outcome again = run("convert", {model, path("tiles"), "--tiles", "--collections"});
  EXPECT_EQ(again.code, 0) << again;
  EXPECT_NE(again.out.find("1000 of 1000 items"), std::string::npos) << again;
  EXPECT_NE(again.out.find("tiles on"), std::string::npos) << again;
  fs::create_directories(path("mine"));
  write("mine/notes.txt", "mine");
  expect_failure("convert", {model, path("mine"), "--tiles"}, "would be lost");
  EXPECT_EQ(read_bytes(path("mine/notes.txt")), "mine");
}

TEST_F(Convert, TilesRefuseBadUsage) {
  const std::string model = plant(1000);
  expect_usage_error("convert", {model, path("tiles.glb"), "--tiles"}, "folder");
  expect_usage_error("convert", {model, fs::path(model).parent_path().string(), "--tiles"}, "would be lost");
  expect_usage_error("convert", {model, path("a.glb"), "--uncompressed"}, "--tiles");
  expect_usage_error("convert", {model, path("tiles"), "--tiles", "--levels"}, "--levels");
  EXPECT_TRUE(fs::exists(model));
}

TEST_F(Convert, ToleranceDecidesTheTriangles) {
  const std::string model = plant(1000);
  const Json coarse = run_json("convert", {model, path("coarse.obj"), "--tolerance", "0.05"});
  const Json fine = run_json("convert", {model, path("fine.obj"), "--tolerance", "0.0005"});
  EXPECT_EQ(coarse["tessellation"]["tolerance"], 0.05);
  EXPECT_LE(coarse["tessellation"]["largest_chord_error"].get<double>(), 0.05);
  EXPECT_LE(fine["tessellation"]["largest_chord_error"].get<double>(), 0.0005);
  EXPECT_GT(fine["tessellation"]["triangles"].get<int>(), 2 * coarse["tessellation"]["triangles"].get<int>());
  EXPECT_EQ(coarse["bytes_out"], read_bytes(path("coarse.obj")).size() + read_bytes(path("coarse.mtl")).size());
  EXPECT_FALSE(read_bytes(path("coarse.mtl")).empty());
}

TEST_F(Convert, PrimitivesAreRecognised) {
  const std::string model = plant(1000), triangles = path("triangles.obj");
  ASSERT_EQ(run("convert", {model, triangles, "--tolerance", "0.001"}).code, 0);
  const Json without = run_json("convert", {triangles, path("meshes.rvm")});
  EXPECT_EQ(without["recognition"], nullptr);
  EXPECT_EQ(total(without["items_out"]),
            without["items_out"]["facet_group"].get<int>() + without["items_out"]["mesh"].get<int>());
  const Json facts = run_json("convert", {"--recognise", triangles, path("again.rvm")});
  const Json found = facts["recognition"]["items"];
  EXPECT_LE(facts["recognition"]["triangles_after"].get<int>(), 100);  // pavings
  EXPECT_LT(facts["recognition"]["bytes_after"].get<int>(), facts["recognition"]["bytes_before"].get<int>() / 10);
  EXPECT_LE(facts["recognition"]["largest_deviation"].get<double>(), 0.0011);
  const Json wanted = run_json("info", {model})["items"], there = run_json("info", {path("again.rvm")})["items"];
  for (const char* kind : {"cylinder", "circular_torus", "snout", "box", "sphere", "elliptical_dish"}) {
    EXPECT_EQ(found[kind], wanted[kind]) << kind;
    EXPECT_EQ(there[kind], wanted[kind]) << kind;
  }
  const Outcome spoken = run("convert", {"--recognise", triangles, path("again.rvm")});
  EXPECT_NE(spoken.out.find("recognised "), std::string::npos) << spoken;
  const std::string all = std::to_string(total(facts["items_out"]));
  EXPECT_NE(spoken.out.find(": " + all + " of " + all + " items"), std::string::npos) << spoken;
  EXPECT_EQ(facts["items_in"], facts["items_out"]);
  EXPECT_EQ(run_json("info", {"--recognise", triangles})["items"], there) << "items of the scene, not of the file";
  expect_usage_error("convert", {path("in.rvm"), path("out.rvm"), "--recognise-tolerance", "0.1"}, "--recognise");
  expect_usage_error("convert", {path("in.rvm"), path("out.rvm"), "--recognise", "--recognise-tolerance", "0"},
                     "above 0");
}

TEST_F(Convert, UnitsAndAxesAreApplied) {
  const std::string part = write("part.stl", kStlText);
  ASSERT_EQ(run("convert", {part, path("part.obj"), "--units", "mm", "--up", "y"}).code, 0);
  EXPECT_EQ(read_bytes(path("part.obj")), "# metres, z up\no part\nv 1000001 0 0\nv 1000003 0 0\nv 1000001 0 2\nf 1 2 3\n");
}

TEST_F(Convert, SpeaksBesideJson) {
  const Outcome outcome = run("convert", {plant(1000), path("a.obj")});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.out.find("1000 of 1000 items"), std::string::npos) << outcome;
  EXPECT_EQ(outcome.err, "");
}

TEST_F(Convert, RefusesBadUsage) {
  expect_usage_error("convert", {path("only.rvm")}, "required");
  expect_usage_error("convert", {path("in.rvm"), path("out.vtk")}, "out.vtk");
  expect_usage_error("convert", {path("in.rvm"), path("out")}, ".rvm, .obj, .glb, .gltf, .stl, .ply or .slc");
  expect_usage_error("convert", {path("in.rvm"), path("out.obj"), "--collections"}, "--collections");
  for (const char* bad : {"0", "-1", "nan", "inf", "fine"})
    expect_usage_error("convert", {path("in.rvm"), path("out.obj"), "--tolerance", bad}, bad);
}

TEST_F(Convert, RefusesBadFilesAndLeavesNothing) {
  const std::string model = plant(1000);
  fs::create_directories(path("out"));
  expect_failure("convert", {path("missing.rvm"), path("out/a.rvm")}, "missing.rvm");
  expect_failure("convert", {model, write("damaged.stl", std::string(kStlText) + "facet"), path("out/a.obj")},
                 "damaged.stl");
  EXPECT_TRUE(fs::is_empty(path("out")));
  expect_failure("convert", {model, unwritable("a.obj")}, "a.obj");
  expect_failure("convert", {model, unwritable("a.rvm")}, "a.rvm");
  ASSERT_EQ(run("convert", {"--lenient", path("damaged.stl"), path("out/a.obj")}).code, 0);
  EXPECT_EQ(std::distance(fs::directory_iterator(path("out")), fs::directory_iterator()), 1);
}

class ConvertImages : public RenderTest {
 protected:
  /// Depths of a PFM file, lowest row first.
  static std::vector<float> depths(const std::string& file) {
    const std::string bytes = read_bytes(file);
    std::size_t at = 0;
    for (int line = 0; line < 3; ++line) at = bytes.find('\n', at) + 1;
    std::vector<float> values((bytes.size() - at) / sizeof(float));
    std::memcpy(values.data(), bytes.data() + at, values.size() * sizeof(float));
    return values;
  }
  /// Pixels whose depths are further apart than `metres`, or of which one shows the background.
  static std::ptrdiff_t elsewhere(const std::vector<float>& a, const std::vector<float>& b, float metres) {
    EXPECT_EQ(a.size(), b.size());
    std::ptrdiff_t count = 0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
      count += a[i] != b[i] && !(std::abs(a[i] - b[i]) <= metres);
    return count;
  }
};

/// What is read back shows the same items. Collections change their order, so that only the image can be compared.
TEST_F(ConvertImages, GltfShowsWhatRvmShows) {
  const auto known = importers::known_extensions();
  if (std::find(known.begin(), known.end(), ".glb") == known.end()) GTEST_SKIP() << "a build without glTF";
  const std::string model = plant(1000), image = path("before.png"), ids = path("before_ids.png");
  render({model, "--size", "600x400", "--out", image, "--ids", ids, "--depth", path("before.pfm")});
  const auto compared = [&](const Args& extra, const std::string& name) {
    Args args = {model, path(name)};
    args.insert(args.end(), extra.begin(), extra.end());
    const Json facts = run_json("convert", args);
    EXPECT_EQ(facts["left_out"], 0) << name;
    EXPECT_EQ(facts["analytic"], extra.size() == 1 ? 999 : 0) << name;  // all but a rectangular torus
    return run_json("render", {path(name), "--size", "600x400", "--out", path("after.png"), "--ids",
                               path("after_ids.png"), "--depth", path("after.pfm"), "--compare", image, "--compare-ids",
                               ids, "--max", "255", "--mean", "255"});
  };
  for (const char* name : {"plant.glb", "plant.gltf"}) {
    const Json facts = compared({"--tolerance", "0.0005"}, name);
    // Pixels of 240,000: silhouettes are polygons. Four times the tolerance, where surfaces are seen aslant.
    EXPECT_LE(elsewhere(depths(path("before.pfm")), depths(path("after.pfm")), 0.002f), 50);
    // Items that become instances change places with others of their node, so that other items have these ids.
    EXPECT_LE(facts["wrong_ids"], 2400);
    EXPECT_LE(facts["compare"]["flip"]["mean"], 0.002);
  }
  const Json facts = compared({"--collections"}, "parts.glb");
  EXPECT_LE(facts["compare"]["pixels"], 100);
  EXPECT_LE(facts["compare"]["flip"]["mean"], 1e-4);
}

}  // namespace
}  // namespace sightline::tests::convert_test
