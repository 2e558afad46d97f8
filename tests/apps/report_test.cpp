// sightline-report: the page is well-formed and holds all that it shows, for any model and any name.
#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>

#include "sightline/tests/apps/render_test.h"
#include "sightline/tests/support/test_data.h"

namespace sightline::tests::report_test {
namespace {

/// Reads markup that is well-formed XML but for its first line: every tag is closed in order, attributes are quoted,
/// references are known. Collects elements and attributes.
class MarkupReader {
 public:
  explicit MarkupReader(const std::string& text) : text_(text) {
    if (text_.rfind("<!DOCTYPE html>\n", 0) == 0)
      at_ = 16;
    else
      fail("no document type");
    while (!problem_ && at_ < text_.size()) text_[at_] == '<' ? tag() : content();
    if (!problem_ && !open_.empty()) fail("<" + open_.back() + "> is not closed");
  }

  /// None for well-formed text.
  const std::optional<std::string>& problem() const { return problem_; }
  std::size_t count(const std::string& element) const { return elements_.count(element); }
  const std::multimap<std::string, std::string>& attributes() const { return attributes_; }

 private:
  void fail(const std::string& what) { problem_ = what + " at byte " + std::to_string(at_); }
  bool take(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  std::string name() {
    std::string out;
    while (at_ < text_.size() && (std::isalnum(std::uint8_t(text_[at_])) || text_[at_] == '-')) out += text_[at_++];
    return out;
  }

  void content() {
    if (text_[at_] == '&') {
      const std::size_t end = text_.find(';', at_);
      static const std::set<std::string> known = {"&lt", "&gt", "&amp", "&quot", "&#39"};
      if (end == std::string::npos || !known.count(text_.substr(at_, end - at_))) return fail("an unknown reference");
    }
    if (open_.empty() && !std::isspace(std::uint8_t(text_[at_]))) return fail("text outside of the document");
    if (std::uint8_t(text_[at_]) < 0x20 && !std::isspace(std::uint8_t(text_[at_]))) return fail("a control character");
    ++at_;
  }

  void tag() {
    ++at_;
    if (take('/')) {
      const std::string closed = name();
      if (open_.empty() || open_.back() != closed || !take('>')) return fail("</" + closed + "> closes nothing");
      open_.pop_back();
      return;
    }
    const std::string element = name();
    if (element.empty()) return fail("a stray <");
    elements_.insert(element);
    while (take(' ') || take('\n')) {
      const std::string attribute = name();
      if (!take('=') || !take('"')) return fail("attribute \"" + attribute + "\" has no value");
      const std::size_t end = text_.find_first_of("\"<", at_);
      if (attribute.empty() || end == std::string::npos || text_[end] != '"') return fail("a bad attribute");
      attributes_.emplace(attribute, text_.substr(at_, end - at_));
      at_ = end + 1;
    }
    const bool closed = take('/');
    if (!take('>')) return fail("<" + element + "> does not end");
    if (!closed) open_.push_back(element);
  }

  const std::string& text_;
  std::size_t at_ = 0;
  std::optional<std::string> problem_;
  std::vector<std::string> open_;
  std::multiset<std::string> elements_;
  std::multimap<std::string, std::string> attributes_;
};

/// Without what needs ray tracing where it is not built.
std::vector<std::string> of_this_build(std::vector<std::string> names) {
  if (!is_built("trace"))
    std::erase_if(names, [](const auto& name) { return name == "error" || name == "visibility"; });
  return names;
}

class ReportPage : public RenderTest {
 protected:
  struct Page {
    std::string text;
    Json results;
  };

  /// Makes a small page, which must be well-formed and load nothing.
  Page report(Args args) const {
    const std::string out = path("report.html"), json = path("report.json");
    args.insert(args.end(), {"--out", out, "--json", json, "--frames", "8"});
    if (std::find(args.begin(), args.end(), "--size") == args.end()) args.insert(args.end(), {"--size", "96x64"});
    const Outcome outcome = run("report", args);
    EXPECT_EQ(outcome.code, 0) << outcome;
    EXPECT_EQ(outcome.out, "");
    Page page{read_bytes(out), json::parse(read_bytes(json)).value()};
    check(page.text);
    return page;
  }

  static void check(const std::string& text) {
    const MarkupReader markup(text);
    EXPECT_EQ(markup.problem().value_or(""), "");
    for (const char* element : {"script", "link", "iframe", "object", "embed", "base", "form"})
      EXPECT_EQ(markup.count(element), 0u) << element;
    for (const auto& [name, value] : markup.attributes()) {
      EXPECT_NE(name.rfind("on", 0), 0u) << "a handler: " << name;
      EXPECT_TRUE(name != "src" || value.rfind("data:image/png;base64,", 0) == 0) << value.substr(0, 100);
      EXPECT_TRUE(name != "href" || value.rfind('#', 0) == 0) << value;
      EXPECT_EQ(value.find("url("), std::string::npos) << value;
    }
    EXPECT_EQ(text.find("@import"), std::string::npos);
    EXPECT_EQ(text.find("url("), std::string::npos);
    for (const char* bad : {">nan", ">inf", ">-nan", ">-inf"}) EXPECT_EQ(text.find(bad), std::string::npos) << bad;
  }

  /// Sections that were made, sorted; and those left out.
  static std::vector<std::string> sections(const Page& page, bool left_out) {
    std::vector<std::string> names;
    for (const auto& [name, results] : page.results["sections"].items())
      if (results.contains("left_out") == left_out) names.push_back(name);
    std::sort(names.begin(), names.end());
    return of_this_build(std::move(names));
  }
};

/// In ascending order.
std::vector<std::string> all() {
  return of_this_build({"culling", "error", "frames", "glance", "images", "model", "plan", "stability", "visibility"});
}

std::vector<std::string> all_but(const std::string& name) {
  std::vector<std::string> names = all();
  std::erase(names, name);
  return names;
}

TEST_F(ReportPage, OfPrimitives) {
  const Page page = report({data_path("small_plant.rvm").string()});
  EXPECT_EQ(sections(page, false), all());
  EXPECT_EQ(sections(page, true), std::vector<std::string>());
  EXPECT_NE(page.text.find("sightline-info"), std::string::npos) << "commands give the figures again";
  EXPECT_NE(page.text.find(page.results["machine"]["renderer"].get<std::string>()), std::string::npos);
  const Json info = run_json("info", {data_path("small_plant.rvm").string()});
  EXPECT_EQ(page.results["sections"]["model"]["items"], info["items"]);
}

/// Each step keeps what the step after it keeps, down to the items that are visible in the id image.
TEST_F(ReportPage, CountsWhatEachStepKeeps) {
  const Json culling = report({plant(2000), "--sections", "culling"}).results["sections"]["culling"];
  const auto mean = [&](const char* step) { return culling[step]["mean"].get<double>(); };
  EXPECT_GT(mean("visible_in_ids"), 0.0);
  EXPECT_GE(mean("items_drawn"), mean("visible_in_ids"));
  EXPECT_GE(mean("sampled"), mean("items_drawn"));
  EXPECT_GE(mean("visible"), mean("sampled"));
  EXPECT_EQ(culling["visible_in_ids"]["false_positives"], 0.0);
  EXPECT_GE(culling["occluded_found"], 0.0);
  EXPECT_LE(culling["occluded_found"], 1.0);
}

/// No culler loses what rays see, and each test that is added leaves out more of the rest.
TEST_F(ReportPage, ComparesCullersWithExactVisibility) {
  if (!is_built("trace")) GTEST_SKIP() << "this build has no ray tracing";
  const Json page = report({plant(3000), "--sections", "visibility"}).results["sections"]["visibility"];
  ASSERT_EQ(page["variants"].size(), 7u);
  std::map<std::string, double> drawn;
  for (const Json& way : page["variants"]) {
    EXPECT_EQ(way["lost"], 0) << way;
    EXPECT_GE(way["per_exact"], 1.0) << way;
    drawn[way["label"].string()] = way["drawn"].get<double>();
  }
  EXPECT_GT(page["exact"], 10.0);
  EXPECT_LT(page["unlike_raster"], 0.01 * page["exact"].get<double>() * page["frames"].get<double>());
  EXPECT_EQ(drawn["cpu"], drawn["linear"]);
  for (const std::string culler : {"cpu", "gpu"}) {
    EXPECT_LT(drawn[culler + ", sample test"], drawn[culler]);
    EXPECT_LE(drawn[culler + ", occlusion test"], drawn[culler + ", sample test"]);
  }
  EXPECT_GE(drawn["cpu, occlusion test"], page["exact"].get<double>());
}

TEST_F(ReportPage, NothingIsLostByLeavingOut) {
  const Json frames = report({plant(2000), "--sections", "frames"}).results["sections"]["frames"];
  ASSERT_EQ(frames["tests"].size(), 4u);
  for (const Json& test : frames["tests"]) EXPECT_EQ(test["wrong_ids"], 0) << test;
  EXPECT_EQ(frames["pixels"], 8 * 96 * 64);
  EXPECT_EQ(frames["tests"][3]["frame_ms"], frames["cpu"]["frame_ms"]) << "one time for one thing";
}

/// A sentence and a plot come before all else, and are made of the figures of the section on errors.
/// The first page answers; all else is closed until a click.
TEST_F(ReportPage, BeginsWithWhatTheModelIsAndCosts) {
  const Page page = report({plant(1000)});
  const Json& glance = page.results["sections"]["glance"];
  EXPECT_EQ(glance["model"].string().find("1,000 items in "), 0u) << glance["model"];
  EXPECT_GT(glance["frame_ms"]["median"].get<double>(), 0.0);
  ASSERT_EQ(glance["heavy_parts"].size(), 5u);
  for (std::size_t i = 1; i < 5; ++i)
    EXPECT_GE(glance["heavy_parts"][i - 1]["weight"].get<double>(), glance["heavy_parts"][i]["weight"].get<double>());
  std::vector<std::size_t> places;
  for (const std::string& text :
       {std::string("</h1>"), std::string("<img"), std::string("Lost"), std::string("What it costs to fly through it"),
        std::string("What is approximate"), std::string("The heaviest parts"), std::string("<details")})
    places.push_back(page.text.find(text, places.empty() ? 0 : places.back()));
  EXPECT_TRUE(std::is_sorted(places.begin(), places.end()));
  EXPECT_LT(places.back(), page.text.size());
  if (!is_built("trace")) return;
  const std::string answer = page.results["sections"]["error"]["answer"].string();
  EXPECT_NE(answer.find("triangles"), std::string::npos) << answer;
  EXPECT_LT(page.text.find("<p>" + answer), places.back());
}

TEST_F(ReportPage, ColoursItsFirstImage) {
  const Page page = report({plant(1000), "--sections", "glance", "--colour-by", "@kind", "--size", "160x90"});
  const Json& colours = page.results["sections"]["glance"]["colours"];
  EXPECT_EQ(colours["key"], "@kind");
  EXPECT_NE(page.text.find(" --colour-by "), std::string::npos);
  for (const Json& group : colours["groups"]) {
    EXPECT_NE(page.text.find(group["colour"].get<std::string>()), std::string::npos);
    EXPECT_NE(page.text.find(" " + group["label"].get<std::string>() + "</th>"), std::string::npos) << group;
  }
}

/// Exact surfaces are as near as depths of an image are, triangles within their tolerances.
TEST_F(ReportPage, SurfacesAreJudgedByRaysInDoublePrecision) {
  if (!is_built("trace")) GTEST_SKIP() << "this build has no ray tracing";
  const Json error = report({plant(1000), "--sections", "error"}).results["sections"]["error"];
  const Json& surfaces = error["surfaces"];
  ASSERT_EQ(surfaces.size(), 8u) << "exact, and seven tolerances";
  const auto off = [&](std::size_t i) { return surfaces[i]["error_m"]["p99"].get<double>(); };
  EXPECT_GT(off(0), 0.0) << "the reference is not the image itself";
  EXPECT_LT(off(0), 1e-4);
  EXPECT_EQ(surfaces[1]["tolerance_m"], 0.1);
  EXPECT_EQ(surfaces[7]["tolerance_m"], 0.0001);
  for (std::size_t i = 1; i < 8; ++i) {
    EXPECT_GT(off(i), off(0)) << surfaces[i];
    if (i > 1) {
      EXPECT_GT(surfaces[i]["triangles"], surfaces[i - 1]["triangles"]);
    }
    if (i > 4) continue;  // finer ones are rounded by rasterisers
    EXPECT_LT(off(i), surfaces[i]["tolerance_m"]);
    if (i > 1) {
      EXPECT_LT(off(i), off(i - 1)) << surfaces[i];
    }
  }
  EXPECT_LT(surfaces[0]["wrong_pixels"], 1e-3);
  for (const char* key : {"samples", "contribution"})
    EXPECT_EQ(error[key][0]["ms"], surfaces[0]["ms"]) << "one time for one thing";
}

TEST_F(ReportPage, TheTourCanBeFlownAgain) {
  const std::string tour = path("tour.json");
  const Page page = report({plant(1000), "--sections", "images", "--save-path", tour});
  const Json flown = run_json("replay", {plant(1000), "--path", tour, "--frames", "8", "--no-render"});
  EXPECT_EQ(flown["frames"].size(), 8u);
  for (const Json& frame : flown["frames"]) EXPECT_GT(frame["visible"], 0);
  if (is_built("trace")) {
    EXPECT_GT(page.results["sections"]["images"]["tour"]["covered"]["least"], 0.0);
  }
}

/// More samples come closer to 16 rays than half the resolution does.
TEST_F(ReportPage, ErrorsFallWithEffort) {
  if (!is_built("trace")) GTEST_SKIP() << "this build has no ray tracing";
  const Json error = report({plant(1000), "--sections", "error", "--size", "320x180"}).results["sections"]["error"];
  const auto flip = [](const Json& variant) { return variant["flip"]["mean"].get<double>(); };
  const Json& samples = error["samples"];
  ASSERT_GE(samples.size(), 2u);
  EXPECT_LT(flip(samples[0]), flip(samples[1])) << "half the resolution";
  EXPECT_LT(samples[0]["wrong_ids"], samples[1]["wrong_ids"]) << samples;
  EXPECT_LT(samples[0]["wrong_ids"], 1e-4) << "the reference has seen the pixels' centres, too";
  const Json& contribution = error["contribution"];
  ASSERT_EQ(contribution.size(), 5u);
  EXPECT_LT(contribution[0]["wrong_ids"], 1e-4) << "all items";
  EXPECT_GT(contribution[4]["wrong_ids"], contribution[0]["wrong_ids"]) << contribution;
  EXPECT_GT(flip(contribution[4]), flip(contribution[0])) << contribution;
  for (const char* key : {"samples", "contribution"})
    EXPECT_TRUE(std::any_of(error[key].begin(), error[key].end(), [](const Json& v) { return v["on_front"] == true; }));
}

/// A model of meshes is drawn by levels of detail, too.
TEST_F(ReportPage, LevelsOfDetailAreComparedWhereThereAreManyTriangles) {
  if (!is_built("trace")) GTEST_SKIP() << "this build has no ray tracing";
  const std::string meshes = path("meshes.obj");
  ASSERT_EQ(run("convert", {plant(1000), meshes, "--tolerance", "0.0005"}).code, 0);
  const Json error = report({meshes, "--sections", "error", "--size", "160x90"}).results["sections"]["error"];
  const Json& levels = error["levels"];
  ASSERT_EQ(levels.size(), 6u);
  EXPECT_LT(levels[0]["wrong_ids"], 1e-4) << "in full";
  EXPECT_GT(levels[5]["flip"]["mean"], levels[0]["flip"]["mean"]) << levels;
  const Json none = report({plant(1000), "--sections", "error"}).results["sections"]["error"];
  EXPECT_FALSE(none.contains("levels"));
}

TEST_F(ReportPage, DepthsAreThoseOfDoublePrecision) {
  const Json stability = report({plant(2000), "--sections", "stability"}).results["sections"]["stability"];
  const Json& all = stability["depth"]["all"];
  EXPECT_GT(all["pixels"], 1000);
  EXPECT_LT(all["median"], 1e-6);
  EXPECT_LT(all["p99"], 1e-5);
  EXPECT_LT(all["misses"].get<double>(), 0.001 * all["pixels"].get<double>());
  for (const auto& [name, range] : stability["ranges"].items()) EXPECT_EQ(range["within"], true) << name;
}

TEST_F(ReportPage, OfMeshesAlone) {
  const std::string model = write("tetra.stl", stl_text({{{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}}},
                                                         {{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}},
                                                         {{{0, 0, 0}, {0, 0, 1}, {0, 1, 0}}},
                                                         {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}}));
  const Page page = report({model});
  EXPECT_EQ(sections(page, false), all_but("stability"));
  EXPECT_EQ(sections(page, true), std::vector<std::string>{"stability"});
  EXPECT_EQ(page.results["sections"]["model"]["triangles"]["items"], 4);
}

std::string decoded(const std::string& base64) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0, count = 0;
  for (const char digit : base64.substr(0, base64.find('='))) {
    bits = bits << 6 | std::uint32_t(kDigits.find(digit)), count += 6;
    if (count >= 8) count -= 8, bytes += char(bits >> count & 255u);
  }
  return bytes;
}

/// The command beside an image gives that image, pixel by pixel: of a thin model, whose view of the whole is nearer
/// than its bounding sphere's, and whatever the options.
TEST_F(ReportPage, CommandsGiveTheImagesAgain) {
  std::string rods = "v 0 0 0\nv 30 0 0\nv 30 0.5 0\nv 0 0.5 4\nv 3 3 3\nf 1 2 3\nf 1 3 4\nf 1 4 5\nf 3 4 5\n";
  for (const Args& model : {Args{write("rods.obj", rods)}, Args{plant(1000), "--translate", "100,0,0"},
                            Args{write("flat.obj", rods), "--crease-angle", "0"}}) {
    Args args = model;
    args.insert(args.end(), {"--sections", "images", "--size", "160x120", "--save-path", path("tour.json")});
    const Page page = report(args);
    std::size_t at = 0;
    for (const Json& view : page.results["sections"]["images"]["views"]) {
      constexpr std::string_view kImage = "src=\"data:image/png;base64,", kCommand = "sightline-render ";
      at = page.text.find(kImage, at) + kImage.size();
      const std::string drawn = write("drawn.png", decoded(page.text.substr(at, page.text.find('"', at) - at)));
      const std::size_t begin = page.text.find(kCommand, at);
      ASSERT_NE(begin, std::string::npos);
      std::string words =
          page.text.substr(begin + kCommand.size(), page.text.find('<', begin) - begin - kCommand.size());
      Args command;
      for (std::istringstream in(words); in >> words;)
        command.push_back(words == "image.png" || words == "items.png" || words == "tour.json" ? path(words) : words);
      command.insert(command.end(), {"--compare", drawn});
      const Outcome outcome = run("render", command);
      EXPECT_EQ(outcome.code, 0) << view << '\n' << outcome;
      at = begin;
    }
  }
}

/// Bodies of STEP that are triangles are no exact surfaces.
TEST_F(ReportPage, SaysHowFarTrianglesLieOffTheirFile) {
  const std::string model = data_path("machined.stp").string();
  if (run("info", {model}).code != 0) GTEST_SKIP() << "built without STEP";
  const Page page = report({model, "--sections", "model,error"});
  const Json& sections = page.results["sections"];
  EXPECT_EQ(sections["model"]["surfaces"]["meshed_bodies"], 1);
  EXPECT_GT(sections["model"]["surfaces"]["deviation"], 1e-6);
  EXPECT_NE(page.text.find("Exact surfaces: 1 parts in 2 places"), std::string::npos);
  if (!is_built("trace")) return;
  const std::string answer = sections["error"]["answer"].string();
  EXPECT_EQ(answer.find("Exact surfaces"), std::string::npos) << answer;
  EXPECT_NE(answer.find(" mm off the surfaces of their file"), std::string::npos) << answer;
  EXPECT_EQ(sections["error"]["surfaces"][0]["label"], "meshes, as by default");
}

TEST_F(ReportPage, OfNothing) {
  const Page page = report({write("nothing.obj", "v 0 0 0\n")});
  EXPECT_EQ(sections(page, false), (std::vector<std::string>{"glance", "model", "plan"}));
  EXPECT_EQ(sections(page, true), of_this_build({"culling", "error", "frames", "images", "stability", "visibility"}));
  EXPECT_NE(page.text.find("left out: "), std::string::npos);
  EXPECT_EQ(page.text.find("<img"), std::string::npos);
}

TEST_F(ReportPage, EscapesNames) {
  if (names_ignore_case()) GTEST_SKIP() << "no such names here";
  const std::string evil = "<script>alert(1)<!--\"'&amp;\x01\xff";
  const std::string model =
      write(evil + ".obj", "mtllib " + evil + ".mtl\nusemtl " + evil + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Page page = report({model});
  EXPECT_EQ(page.text.find("<script"), std::string::npos);
  EXPECT_NE(page.text.find("&lt;script&gt;alert(1)&lt;!--&quot;&#39;&amp;amp;"), std::string::npos);
  EXPECT_FALSE(page.results["sections"]["model"]["warnings"].empty()) << "the page shows text from the file, too";
}

TEST_F(ReportPage, HoldsTheChosenSectionsAlone) {
  const Page page = report({data_path("small_plant.rvm").string(), "--sections", "plan,model"});
  EXPECT_EQ(sections(page, false), (std::vector<std::string>{"model", "plan"}));
  EXPECT_EQ(page.text.find("id=\"images\""), std::string::npos);
}

TEST_F(ReportPage, IsQuietOnRequest) {
  const std::string model = write("a.obj", "mtllib missing.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Args args = {model, "--out", path("a.html"), "--sections", "plan"};
  EXPECT_NE(run("report", args).err.find("missing.mtl"), std::string::npos);
  Args quiet = args;
  quiet.push_back("--quiet");
  const Outcome outcome = run("report", quiet);
  EXPECT_EQ(outcome.code, 0) << outcome;
  EXPECT_EQ(outcome.err.find("warning"), std::string::npos) << outcome;
}

TEST_F(ReportPage, RefusesBadArguments) {
  const std::string model = data_path("small_plant.rvm").string();
  expect_usage_error("report", {model}, "--out");
  for (const char* bad : {"0x5", "63x36", "64x35", "16385x100", "large", ""})
    expect_usage_error("report", {model, "--out", "r.html", "--size", bad}, "--size");
  for (const char* bad : {"3", "-1", "many", "100001"})
    expect_usage_error("report", {model, "--out", "r.html", "--frames", bad}, "--frames");
  expect_usage_error("report", {model, "--out", "r.html", "--sections", "model,magic"}, "--sections");
  const std::string bad = unwritable("r.html");
  expect_failure("report", {model, "--out", bad}, bad);
  expect_failure("report", {model, "--out", path("r.html"), "--json", bad}, bad);
  expect_failure("report", {model, "--out", path("r.html"), "--save-path", bad}, bad);
  EXPECT_FALSE(fs::exists(path("r.html")));
}

}  // namespace
}  // namespace sightline::tests::report_test
