// sightline-render: images, ids, depth, and the comparison that makes it a regression test.
#include "sightline/tests/apps/render_test.h"

#include <cmath>
#include <cstring>
#include <set>

#include <fmt/format.h>
#include <png.h>

namespace sightline::tests::render_test {
namespace {

constexpr int kWidth = 480, kHeight = 270;
constexpr std::uint64_t kThousandth = kWidth * kHeight / 1000;  // pixels

/// A look along the pipe racks, and one from above.
const char* const kNearView =
    R"({"eye":[-30,-12,6],"target":[5,2,3],"up":[0,0,1],"fovy_deg":60,"near":0.1,"far":1000})";
const char* const kOrthoView =
    R"({"eye":[-40,-60,50],"target":[0,0,4],"up":[0,0,1],"ortho_height":30,"near":0.1,"far":1000})";

/// 8-bit RGB, rows top to bottom.
struct Image {
  std::size_t width = 0, height = 0;
  std::vector<std::uint8_t> rgb;

  std::uint32_t number(std::size_t pixel) const {
    return std::uint32_t(rgb[3 * pixel]) | std::uint32_t(rgb[3 * pixel + 1]) << 8 |
           std::uint32_t(rgb[3 * pixel + 2]) << 16;
  }
  std::size_t colours() const {
    std::set<std::uint32_t> seen;
    for (std::size_t i = 0; i < width * height; ++i) seen.insert(number(i));
    return seen.size();
  }
};

Image read_image(const std::string& file) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&header, file.c_str())) << file << ": " << header.message;
  header.format = PNG_FORMAT_RGB;
  Image image{header.width, header.height, std::vector<std::uint8_t>(PNG_IMAGE_SIZE(header))};
  EXPECT_TRUE(png_image_finish_read(&header, nullptr, image.rgb.data(), 0, nullptr)) << file << ": " << header.message;
  return image;
}

class Render : public RenderTest {
 protected:
  void SetUp() override {
    RenderTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    model = plant(3000);
    view = write("view.json", kNearView);
  }

  Args with(const Args& more) const {
    Args args = {model, "--plain", "--size", std::to_string(kWidth) + "x" + std::to_string(kHeight)};
    args.insert(args.end(), more.begin(), more.end());
    return args;
  }

  /// Pixels that differ at all from a reference.
  std::uint64_t differing(Args args, const std::string& reference) const {
    args.insert(args.end(), {"--compare", reference, "--max", "255", "--mean", "255", "--json", "-"});
    const Outcome outcome = render(with(args));
    const Json results = json::parse(outcome.out).value();
    EXPECT_TRUE(results.is_object()) << outcome;
    return results.is_object() ? results["compare"]["pixels"].get<std::uint64_t>() : ~0ull;
  }

  std::string model, view;
};

TEST_F(Render, WritesAnImage) {
  const std::string out = path("out.png");
  const Outcome outcome = render(with({"--view", view, "--out", out}));
  EXPECT_EQ(outcome.out, "");
  const Image image = read_image(out);
  EXPECT_EQ(image.width, std::size_t(kWidth));
  EXPECT_EQ(image.height, std::size_t(kHeight));
  EXPECT_GT(image.colours(), 100u) << "hardly anything is drawn";
}

/// Without --plain: another light behind another background, and edges of more shades.
TEST_F(Render, MakesImagesForPeople) {
  const std::string plain = path("plain.png"), people = path("people.png"), ids = path("ids.png");
  render(with({"--view", view, "--out", plain, "--ids", ids}));
  const Args args = {model, "--size", std::to_string(kWidth) + "x" + std::to_string(kHeight), "--view", view};
  const auto more = [&](Args added) {
    added.insert(added.begin(), args.begin(), args.end());
    return added;
  };
  render(more({"--out", people, "--compare-ids", ids}));
  const Image a = read_image(plain), b = read_image(people);
  const auto sky = [](const Image& image, std::size_t row) { return image.number(row * kWidth + kWidth / 2); };
  EXPECT_EQ(sky(a, 0), sky(a, 20));
  EXPECT_NE(sky(b, 0), sky(b, 20));
  EXPECT_GT(b.colours(), 2 * a.colours());
  // Ids are those of pixel centres, whatever the samples.
  const Json results = json::parse(render(more({"--compare-ids", ids, "--json", "-"})).out).value();
  EXPECT_EQ(results["wrong_ids"], 0);
  // Eight samples, which no driver here has as such, differ little from four; one differs more.
  const auto mean = [&](const char* samples) {
    return json::parse(render(more({"--samples", samples, "--compare", people, "--max", "255", "--json", "-"})).out)
        .value()["compare"]["mean"]
        .get<double>();
  };
  EXPECT_GT(mean("1"), 2.0 * mean("8"));
}

/// What an image of ids shows: how many pixels, and the largest part of its width or height that they span.
struct Filled {
  std::size_t pixels = 0;
  double span = 0.0;
};

Filled filled_by(const Image& ids) {
  Filled filled;
  std::size_t low[2] = {ids.width, ids.height}, high[2] = {0, 0};
  for (std::size_t y = 0; y < ids.height; ++y)
    for (std::size_t x = 0; x < ids.width; ++x) {
      if (ids.number(y * ids.width + x) == 0) continue;
      ++filled.pixels;
      low[0] = std::min(low[0], x), high[0] = std::max(high[0], x + 1);
      low[1] = std::min(low[1], y), high[1] = std::max(high[1], y + 1);
    }
  if (filled.pixels > 0)
    filled.span = std::max(double(high[0] - low[0]) / double(ids.width), double(high[1] - low[1]) / double(ids.height));
  return filled;
}

TEST_F(Render, FitsTheModelByDefault) {
  const std::string fit = path("fit.png"), ids = path("ids.png");
  const Outcome outcome = render(with({"--fit", "--out", fit}));
  EXPECT_EQ(outcome.err.find("warning"), std::string::npos) << outcome;
  render(with({"--compare", fit, "--ids", ids}));
  const Filled filled = filled_by(read_image(ids));
  EXPECT_GT(filled.pixels, std::size_t(kWidth * kHeight / 10));
  EXPECT_GT(filled.span, 0.7);
}

/// A box from the origin to a corner.
std::string slab_text(double x = 4.0, double y = 2.0, double z = 1.0) {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 8; ++i) text += fmt::format("{} {} {}\n", i & 1 ? x : 0.0, i & 2 ? y : 0.0, i & 4 ? z : 0.0);
  return text + "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";
}

TEST_F(Render, StandardViewsAreParallelAndFillTheImage) {
  const std::string slab = write("slab.ply", slab_text());
  struct Case {
    const char* from;
    double wide, high;
  };
  // Sides of the rectangle that the view shows.
  for (const Case& c :
       {Case{"front", 4, 1}, {"back", 4, 1}, {"left", 2, 1}, {"right", 2, 1}, {"top", 4, 2}, {"bottom", 4, 2}}) {
    const std::string ids = path(std::string(c.from) + ".png");
    render({slab, "--from", c.from, "--ortho", "--size", "400x400", "--ids", ids});
    const Filled filled = filled_by(read_image(ids));
    EXPECT_NEAR(filled.span, 0.9, 0.01) << c.from;
    EXPECT_NEAR(double(filled.pixels), 360.0 * 360.0 * c.high / c.wide, 1000.0) << c.from;
  }
}

TEST_F(Render, SectionsKeepTheSideThatTheyName) {
  const std::string slab = write("slab.ply", slab_text());
  const std::string top = write("top.json", R"({"eye":[2,1,9],"target":[2,1,0],"up":[0,1,0],"ortho_height":4,)"
                                            R"("near":1,"far":20})");
  const auto pixels = [&](const std::vector<std::string>& sections) {
    const std::string ids = path("cut.png");
    Args args = {slab, "--view", top, "--size", "400x400", "--ids", ids};
    for (const std::string& section : sections) args.insert(args.end(), {"--section", section});
    render(args);
    return double(filled_by(read_image(ids)).pixels);
  };
  const double whole = 400.0 * 200.0;
  EXPECT_NEAR(pixels({}), whole, 700.0);
  EXPECT_NEAR(pixels({"x<1"}), whole / 4, 500.0);
  EXPECT_NEAR(pixels({"x > 100cm"}), whole * 3 / 4, 700.0);
  EXPECT_NEAR(pixels({"x<3000mm", "y>1"}), whole * 3 / 8, 600.0);
  expect_failure("render", {slab, "--view", top, "--out", path("none.png"), "--section", "z>2"}, "leave nothing");

  // The rest is fitted, not the box around what was cut away.
  const std::string ids = path("rest.png"), tower = write("tower.ply", slab_text(0.1, 0.1, 30.0));
  render({slab, tower, "--section", "z<1.5", "--from", "front", "--ortho", "--size", "400x400", "--ids", ids});
  EXPECT_NEAR(filled_by(read_image(ids)).span, 0.9, 0.01);
}

TEST_F(Render, FitsWithoutWhatLiesFarOff) {
  const std::string far = write("far.ply",
                                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                                "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                                "9000 0 0\n9001 0 0\n9000 0 1\n3 0 1 2\n");
  const std::string alone = path("alone.png"), together = path("together.png");
  render(with({"--ids", alone}));
  const Outcome outcome = render(with({far, "--ids", together}));
  EXPECT_NE(outcome.err.find("warning: 1 item lies too far from all others"), std::string::npos) << outcome;
  // Not equal: boxes are floats relative to the middle of all items, which the far one moves.
  const double expected = double(filled_by(read_image(alone)).pixels);
  EXPECT_NEAR(double(filled_by(read_image(together)).pixels), expected, 0.02 * expected);
}

TEST_F(Render, WritesResultsAsJson) {
  const Json results = run_json("render", with({"--view", view}));
  for (const char* key : {"renderer", "size", "items", "visible", "tested", "culler"})
    EXPECT_TRUE(results.contains(key)) << key;
  EXPECT_EQ(results["items"], 3000);
  EXPECT_EQ(results["size"], Json::array({kWidth, kHeight}));
  EXPECT_GT(results["visible"], 0);
  EXPECT_LE(results["visible"], 3000);
}

TEST_F(Render, ComparesWithItself) {
  const std::string out = path("out.png");
  render(with({"--view", view, "--out", out}));
  const Outcome outcome = render(with({"--view", view, "--compare", out, "--max", "0", "--mean", "0"}));
  EXPECT_NE(outcome.out.find("max 0"), std::string::npos) << outcome;
  EXPECT_NE(outcome.out.find("differing pixels 0"), std::string::npos) << outcome;
}

TEST_F(Render, ComparisonSaysWhatTheEyeSees) {
  const std::string out = path("out.png"), ids = path("ids.png"), other = write("other.json", kOrthoView);
  render(with({"--view", view, "--out", out, "--ids", ids}));
  const Args limits = {"--compare", out, "--compare-ids", ids, "--max", "255", "--mean", "255"};
  const auto results = [&](const std::string& seen) {
    Args args = with({"--view", seen});
    args.insert(args.end(), limits.begin(), limits.end());
    return run_json("render", args);
  };
  const Json same = results(view), changed = results(other);
  EXPECT_TRUE(same["compare"]["psnr"].is_null()) << "infinite";
  EXPECT_NEAR(same["compare"]["ssim"].get<double>(), 1.0, 1e-6);
  EXPECT_EQ(same["compare"]["flip"]["mean"], 0.0);
  EXPECT_EQ(same["wrong_ids"], 0);
  EXPECT_LT(changed["compare"]["ssim"], 0.9);
  EXPECT_GT(changed["compare"]["flip"]["mean"], 0.02);
  EXPECT_GT(changed["compare"]["flip"]["p99"], changed["compare"]["flip"]["mean"]);
  EXPECT_GT(changed["wrong_ids"], 100);
}

TEST_F(Render, ComparisonFailsOnAnotherImage) {
  const std::string out = path("out.png"), diff = path("diff.png");
  const std::string other = write("other.json", kOrthoView);
  render(with({"--view", view, "--out", out}));
  const Args compare = with({"--view", other, "--compare", out, "--diff", diff});
  const Outcome outcome = run("render", compare);
  EXPECT_EQ(outcome.code, 1) << outcome;
  EXPECT_NE(outcome.out.find("DIFFERS"), std::string::npos) << outcome;
  EXPECT_GT(read_image(diff).colours(), 10u);
  const auto verdict = [&](const Args& limits) {
    Args args = compare;
    args.insert(args.end(), limits.begin(), limits.end());
    return run("render", args).code;
  };
  EXPECT_EQ(verdict({"--max", "255", "--mean", "255"}), 0);
  EXPECT_EQ(verdict({"--max", "255", "--mean", "0.01"}), 1);
  EXPECT_EQ(verdict({"--max", "3", "--mean", "255"}), 1);
  EXPECT_EQ(verdict({"--max", "255"}), 0);  // a limit alone is the only one
  EXPECT_EQ(verdict({"--mean", "255"}), 0);
  EXPECT_EQ(verdict({"--mean", "0.01"}), 1);
}

TEST_F(Render, ComparisonNeedsAnImageOfTheSameSize) {
  const std::string out = path("out.png"), diff = path("diff.png");
  render({model, "--size", "64x64", "--out", out});
  expect_failure("render", with({"--compare", out, "--max", "255", "--mean", "255", "--diff", diff}), out, true);
  EXPECT_FALSE(fs::exists(diff));
  for (const std::string& bad : {path("missing.png"), write("text.png", "no image"), write("empty.png", ""),
                                 write("cut.png", read_bytes(out).substr(0, 200))})
    expect_failure("render", {model, "--size", "64x64", "--compare", bad}, bad, true);
}

TEST_F(Render, IdsNameItems) {
  for (const char* text : {kNearView, kOrthoView}) {
    SCOPED_TRACE(text);
    const std::string ids = path("ids.png"), names = path("ids.json"), looked = write("looked.json", text);
    render(with({"--view", looked, "--ids", ids, "--ids-json", names}));
    const Image image = read_image(ids);
    ASSERT_EQ(image.width * image.height, std::size_t(kWidth * kHeight));
    std::set<std::string> seen;
    for (std::size_t i = 0; i < image.width * image.height; ++i)
      if (const std::uint32_t number = image.number(i)) {
        ASSERT_LE(number, 3000u);
        seen.insert(std::to_string(number - 1));
      }
    EXPECT_GT(seen.size(), 50u);
    const Json named = json::parse(read_bytes(names)).value();
    ASSERT_TRUE(named.is_object());
    std::set<std::string> keys;
    const Json kinds = run_json("info", {model})["items"];
    for (const auto& [key, entry] : named.items()) {
      keys.insert(key);
      EXPECT_EQ(entry["node"].get<std::string>().rfind("plant-3000-1.rvm/", 0), 0u) << entry;
      ASSERT_TRUE(kinds.contains(entry["kind"].get<std::string>())) << entry;
      EXPECT_GT(kinds[entry["kind"].get<std::string>()], 0) << entry;
    }
    EXPECT_EQ(keys, seen);
  }
}

TEST_F(Render, DepthAgreesWithIds) {
  for (const char* text : {kNearView, kOrthoView}) {
    SCOPED_TRACE(text);
    const std::string ids = path("ids.png"), depth = path("depth.pfm"), looked = write("looked.json", text);
    render(with({"--view", looked, "--ids", ids, "--depth", depth}));
    const std::string bytes = read_bytes(depth), header = "Pf\n480 270\n-1.0\n";
    ASSERT_EQ(bytes.rfind(header, 0), 0u) << bytes.substr(0, 40);
    ASSERT_EQ(bytes.size(), header.size() + 4 * std::size_t(kWidth * kHeight));
    std::vector<float> metres(std::size_t(kWidth * kHeight));
    std::memcpy(metres.data(), bytes.data() + header.size(), 4 * metres.size());
    const Image image = read_image(ids);
    std::size_t hits = 0;
    for (std::size_t y = 0; y < image.height; ++y)
      for (std::size_t x = 0; x < image.width; ++x) {
        const float z = metres[(image.height - 1 - y) * image.width + x];  // PFM begins at the bottom
        const bool hit = image.number(y * image.width + x) != 0;
        hits += hit;
        ASSERT_EQ(std::isfinite(z), hit) << x << " " << y;
        if (hit) {
          ASSERT_TRUE(z >= 0.1f && z <= 1000.0f) << z;
        } else {
          ASSERT_TRUE(std::isinf(z) && z > 0.0f) << z;
        }
      }
    EXPECT_GT(hits, metres.size() / 20);
    EXPECT_LT(hits, metres.size());
  }
}

TEST_F(Render, ComparesIdsAndDepth) {
  const std::string ids = path("ids.png"), depth = path("depth.pfm");
  render(with({"--view", view, "--ids", ids, "--depth", depth}));
  const auto results = [&](const Args& more) {
    Args args = with({"--compare-ids", ids, "--compare-depth", depth});
    args.insert(args.end(), more.begin(), more.end());
    return run_json("render", args);
  };
  const Json same = results({"--view", view}), on_gpu = results({"--view", view, "--culler", "gpu"});
  for (const Json& json : {same, on_gpu}) {
    EXPECT_EQ(json["wrong_ids"], 0);
    EXPECT_GT(json["compare_depth"]["pixels"], 1000);
    EXPECT_EQ(json["compare_depth"]["max"], 0.0);
    EXPECT_EQ(json["compare_depth"]["beyond"], 0);
    EXPECT_EQ(json["compare_depth"]["ties"], 0);
  }
  const std::string nearer = write("nearer.json", R"({"eye":[-29.99,-12,6],"target":[5,2,3],"up":[0,0,1],)"
                                                  R"("fovy_deg":60,"near":0.1,"far":1000})");
  const Json other = results({"--view", nearer});
  EXPECT_LT(other["wrong_ids_elsewhere"], other["wrong_ids"]) << "most of the difference lies at silhouettes";
  EXPECT_GT(other["compare_depth"]["beyond"], 1000);
  expect_usage_error("render", with({"--compare-depth", depth}), "--compare-ids");
  expect_failure("render", with({"--compare-ids", ids, "--compare-depth", ids}), "ids.png", true);
}

TEST_F(Render, ATranslatedModelLooksTheSame) {
  for (const char* text : {kNearView, kOrthoView}) {
    SCOPED_TRACE(text);
    const std::string here = path("here.png"), looked = write("looked.json", text);
    render(with({"--view", looked, "--out", here}));
    EXPECT_LE(differing({"--view", looked, "--translate", "3e6,7e6,1e3"}, here), kThousandth);
    // The comparison sees a move that the view does not follow.
    const std::string moved = write("moved.json", std::string(text).replace(std::string(text).find("[-"), 2, "[-1"));
    EXPECT_GT(differing({"--view", moved}, here), 10 * kThousandth);
  }
}

TEST_F(Render, CullersDrawTheSame) {
  const std::string linear = path("linear.png");
  render(with({"--view", view, "--culler", "linear", "--out", linear}));
  EXPECT_EQ(differing({"--view", view, "--culler", "cpu"}, linear), 0u);
  for (const char* pass : {"geometry", "compute"})  // equal depths in another order
    EXPECT_LE(differing({"--view", view, "--culler", "gpu", "--gpu-variant", pass}, linear), kThousandth) << pass;
}

TEST_F(Render, SectionsCutAway) {
  const std::string whole = path("whole.png"), cut_json = path("cut.json");
  std::string cut(kNearView);
  cut.insert(cut.size() - 1, R"(,"sections":[{"n":[0,1,0],"d":0}])");
  write("cut.json", cut);
  render(with({"--view", view, "--out", whole}));
  EXPECT_GT(differing({"--view", cut_json}, whole), 10 * kThousandth);
  const std::string here = path("here.png");
  render(with({"--view", cut_json, "--out", here}));
  EXPECT_LE(differing({"--view", cut_json, "--translate", "3e6,7e6,1e3"}, here), kThousandth);
}

TEST_F(Render, ShowsNodesOtherwise) {
  const std::string plain = path("plain.png");
  render(with({"--view", view, "--out", plain}));
  for (const Args& change :
       {Args{"--hide", "PIPE"}, Args{"--isolate", "PIPE"}, Args{"--ghost", "PIPE"}, Args{"--ghost-others", "PIPE"},
        Args{"--highlight", "PIPE"}, Args{"--fade", "PIPE"}, Args{"--fade", "PIPE", "--transparency", "blended"},
        Args{"--colour-by", "@kind"}, Args{"--isolate", "@kind=cylinder & @size>0.1"}}) {
    Args args{"--view", view};
    args.insert(args.end(), change.begin(), change.end());
    EXPECT_GT(differing(args, plain), 5 * kThousandth) << change[0];
  }
  EXPECT_EQ(differing({"--view", view, "--transparency", "blended"}, plain), 0u) << "nothing is transparent";
  const Outcome unknown = run("render", with({"--hide", "NO SUCH NODE", "--out", path("none.png")}));
  EXPECT_EQ(unknown.code, 1) << unknown;
  EXPECT_NE(unknown.err.find("no part fits \"NO SUCH NODE\""), std::string::npos) << unknown;
}

TEST_F(Render, SaysWhatColoursMean) {
  const Outcome drawn =
      render(with({"--view", view, "--colour-by", "@KIND", "--out", path("kinds.png"), "--json", "-"}));
  const Json colours = json::parse(drawn.out).value()["colours"];
  ASSERT_TRUE(colours.is_object()) << drawn;
  EXPECT_EQ(colours["key"], "@kind");
  EXPECT_EQ(colours["groups"][0]["colour"], "#332288");
  EXPECT_NE(drawn.err.find("  #332288  " + colours["groups"][0]["label"].get<std::string>()), std::string::npos)
      << drawn;
  EXPECT_GT(differing({"--view", view, "--colour-by", "@kind", "--fade", "PIPE"}, path("kinds.png")), 5 * kThousandth);
  const Outcome unknown = run("render", with({"--colour-by", "NO SUCH KEY", "--out", path("none.png")}));
  EXPECT_EQ(unknown.code, 1) << unknown;
  EXPECT_NE(unknown.err.find("no item has a value for \"NO SUCH KEY\""), std::string::npos) << unknown;
}

TEST_F(Render, ExplainsWhatWasLeftOut) {
  const auto line_with = [](const std::string& text, const std::string& feature) {
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);)
      if (line.find(feature) != std::string::npos) return line;
    return std::string();
  };
  const std::string plan = render(with({"--explain"})).err;
  EXPECT_EQ(line_with(plan, "snout program").rfind("used", 0), 0u) << plan;
  const std::string triangle = write("triangle.stl", tests::stl_text({{{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}}}));
  const std::string small = render({triangle, "--size", "32x32", "--explain"}).err;
  for (const char* program : {"cylinder program", "snout program", "circular torus program"})
    EXPECT_EQ(line_with(small, program).rfind("left out", 0), 0u) << small;
  EXPECT_NE(line_with(small, "snout program").find("none in the scene"), std::string::npos) << small;
  EXPECT_EQ(line_with(small, "mesh program").rfind("used", 0), 0u) << small;
}

TEST_F(Render, RefusesToDrawForNobody) {
  const Args small = {write("triangle.stl", tests::stl_text({{{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}}})), "--size", "64x48"};
  expect_usage_error("render", small, "--out");
  for (const char* option : {"--out", "--ids", "--depth", "--json"}) {
    Args args = small;
    args.insert(args.end(), {option, path("written")});
    EXPECT_EQ(render(args).err, "") << option;
  }
}

TEST_F(Render, SaysWhenNoPixelShowsWhatIsVisible) {
  const auto look = [&](const char* eye, const char* target) {
    return write("look.json", std::string(R"({"eye":[)") + eye + R"(],"target":[)" + target +
                                  R"(],"up":[0,0,1],"fovy_deg":60,"near":0.1,"far":1000})");
  };
  const std::string triangle = write("triangle.stl", tests::stl_text({{{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}}}));
  const auto stderr_of = [&](const std::string& from, const Args& more) {
    Args args = {triangle, "--size", "64x48", "--view", from, "--out", path("look.png")};
    args.insert(args.end(), more.begin(), more.end());
    return render(args).err;
  };
  for (const Args& more : {Args{}, {"--samples", "4"}, {"--culler", "gpu"}, {"--ids", path("ids.png")}}) {
    SCOPED_TRACE(more.empty() ? "" : more[0]);
    const std::string edge_on = stderr_of(look("-3,0,0.5", "0,0,0.5"), more);
    EXPECT_NE(edge_on.find("no pixel shows any of the 1 visible items"), std::string::npos) << edge_on;
    EXPECT_EQ(stderr_of(look("-3,-2,0.5", "0,0,0.5"), more).find("no pixel"), std::string::npos);
    EXPECT_EQ(stderr_of(look("-3,0,0.5", "-6,0,0.5"), more).find("no pixel"), std::string::npos)
        << "nothing is visible";
  }
  const std::string flight =
      write("flight.json", R"({"keys":[{"t":0,"eye":[-3,0,0.5],"target":[0,0,0.5],"up":[0,0,1],"fovy_deg":60},)"
                           R"({"t":1,"eye":[-3,-2,0.5],"target":[0,0,0.5],"up":[0,0,1]}],"near":0.1})");
  const Outcome replay = run("replay", {triangle, "--size", "64x48", "--path", flight, "--frames", "2", "--images",
                                        path("frames"), "--every", "1"});
  EXPECT_EQ(replay.code, 0) << replay;
  EXPECT_NE(replay.err.find("frame_00000.png: no pixel shows any"), std::string::npos) << replay;
  EXPECT_EQ(replay.err.find("frame_00001.png"), std::string::npos) << replay;
}

TEST_F(Render, ReplayWritesTheFramesThatRenderDraws) {
  const std::string folder = path("frames"), tour = path("tour.json");
  const Outcome replay = run("replay", {model, "--size", "480x270", "--frames", "11", "--images", folder, "--every",
                                        "5", "--save-path", tour, "--json", path("out.json")});
  ASSERT_EQ(replay.code, 0) << replay;
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  EXPECT_EQ(names, (std::set<std::string>{"frame_00000.png", "frame_00005.png", "frame_00010.png"}));
  const Json flight = json::parse(read_bytes(path("out.json"))).value();
  EXPECT_NE(flight["renderer"], "none");
  EXPECT_GT(flight["memory"]["gpu"], 0);
  for (const char* frame : {"0", "5", "10"}) {
    const std::string image = folder + "/frame_000" + (frame[1] ? "" : "0") + frame + ".png";
    EXPECT_LE(differing({"--path", tour, "--frames", "11", "--frame", frame}, image), kThousandth) << frame;
  }
  const Outcome coloured = run("replay", {model, "--size", "480x270", "--frames", "1", "--images", folder, "--path",
                                          tour, "--colour-by", "@kind"});
  EXPECT_NE(coloured.out.find("colours: @kind\n  #332288  "), std::string::npos) << coloured;
  const Args first{"--path", tour, "--frames", "11", "--frame", "0", "--colour-by", "@kind"};
  EXPECT_LE(differing(first, folder + "/frame_00000.png"), kThousandth);
}

/// By tiles of several sizes the same image comes out, its ids, names and depths too.
TEST_F(Render, TilesMakeTheSameImage) {
  const auto files = [&](const std::string& name) {
    return Args{"--out",   path(name + ".png"), "--ids",      path(name + "-ids.png"),
                "--depth", path(name + ".pfm"), "--ids-json", path(name + ".json")};
  };
  for (const char* text : {kNearView, kOrthoView}) {
    const std::string looked = write("looked.json", text);
    const Args scene = {"--view", looked, "--depth-shading", "0.6", "--edge-lines", "0.4", "--highlight", "PIPE"};
    const auto draw = [&](const std::string& name, Args more) {
      Args args = with(scene);
      for (const Args& part : {files(name), more, Args{"--json", "-"}})
        args.insert(args.end(), part.begin(), part.end());
      return json::parse(render(args).out).value();
    };
    const Json whole = draw("whole", {});
    EXPECT_EQ(whole["tiles"], 1);
    EXPECT_GT(whole["visible"], 0);
    for (const char* tile : {"130", "200", "300"}) {
      SCOPED_TRACE(tile);
      const Json results = draw("tiles", {"--tile", tile, "--compare", path("whole.png"), "--max", "255", "--mean",
                                          "0.01", "--compare-ids", path("whole-ids.png")});
      EXPECT_GE(results["tiles"], 2);
      EXPECT_FALSE(results.contains("visible")) << "items in several tiles would count more than once";
      EXPECT_LT(results["compare"]["pixels"], kThousandth);
      EXPECT_LT(results["wrong_ids"], kThousandth);
      EXPECT_EQ(read_bytes(path("tiles.pfm")).size(), read_bytes(path("whole.pfm")).size());
      const Json names = json::parse(read_bytes(path("whole.json"))).value(),
                 in_tiles = json::parse(read_bytes(path("tiles.json"))).value();
      std::size_t same = 0;
      for (const auto& [item, name] : names.items()) same += in_tiles.contains(item) && in_tiles[item] == name;
      EXPECT_GT(10 * same, 9 * names.size());
    }
  }
}

TEST_F(Render, ImagesLargerThanWhatIsDrawnAtOnce) {
  const std::string out = path("large.png");
  const Json results = run_json("render", {model, "--size", "16384x40", "--out", out});
  EXPECT_EQ(results["tiles"], 17);
  const Image image = read_image(out);
  EXPECT_EQ(image.width, 16384u);
  EXPECT_EQ(image.height, 40u);
  EXPECT_GT(image.colours(), 20u);
  for (const char* size : {"0x0", "20000x20000", "16385x16384", "-5x5", "1e9x1"})
    expect_usage_error("render", {model, "--size", size, "--out", out}, "between 1 and 16384");
  expect_usage_error("render", {model, "--tile", "5", "--out", out}, "--tile");
  expect_failure("render", {model, "--size", "300x200", "--out", path("no/such/folder.png")}, "folder.png", true);
}

/// Each frame is the image of the path's camera at its time.
TEST_F(Render, WritesThePathAsFrames) {
  const std::string flight =
      write("flight.json", R"({"keys":[{"t":2,"eye":[-30,-12,6],"target":[5,2,3],"up":[0,0,1],"fovy_deg":60},)"
                           R"({"t":3.5,"eye":[-20,-18,9],"target":[5,2,3],"up":[0,0,1],"fovy_deg":50}],"near":0.1})");
  const Args frames = {model, "--size", "200x120", "--path", flight};
  const auto also = [&](const Args& more) {
    Args args = frames;
    args.insert(args.end(), more.begin(), more.end());
    return args;
  };
  const std::string folder = path("frames"), tiled = path("tiled");
  EXPECT_EQ(run_json("render", also({"--write-frames", folder, "--fps", "2"}))["frames"], 4);
  render(also({"--write-frames", tiled, "--fps", "2", "--tile", "130"}));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 4);
  for (int i = 0; i < 4; ++i) {
    const std::string name = "/frame-00000" + std::to_string(i + 1) + ".png";
    for (const std::string& in : {folder, tiled})
      render(also(
          {"--frame", std::to_string(i), "--frames", "4", "--compare", in + name, "--max", "255", "--mean", "0.01"}));
  }
  expect_failure("render", also({"--write-frames", folder}), "is not empty", true);
  expect_failure("render", also({"--write-frames", flight}), "flight.json", true);
  for (const char* fps : {"0", "-25", "nan", "1e9"})
    expect_usage_error("render", also({"--write-frames", path("other"), "--fps", fps}), "--fps");
  expect_usage_error("render", {model, "--write-frames", folder}, "--path");
  expect_usage_error("render", also({"--write-frames", folder, "--out", path("a.png")}), "--out");
}

}  // namespace
}  // namespace sightline::tests::render_test
