// sightline-replay: counts, reports, paths; without drawing but for the hybrid.
#include <cmath>

#include "sightline/tests/apps/tool_test.h"
#include "sightline/tests/support/no_gl.h"

namespace sightline::tests::replay_test {
namespace {

class Replay : public ToolTest {
 protected:
  Json fly(const Args& more) const {
    Args args = {"--no-render", "--frames", "50"};
    args.insert(args.end(), more.begin(), more.end());
    return run_json("replay", args);
  }
};

std::vector<std::uint64_t> visible(const Json& flight) {
  std::vector<std::uint64_t> counts;
  for (const Json& frame : flight["frames"]) counts.push_back(frame["visible"].get<std::uint64_t>());
  return counts;
}

TEST_F(Replay, WritesTheKeysOfTheContract) {
  const std::string model = plant(3000);
  const Json flight = fly({model});
  for (const char* key : {"model", "items", "renderer", "culler", "size", "plan", "frames", "summary", "memory"})
    EXPECT_TRUE(flight.contains(key)) << key;
  EXPECT_EQ(flight["model"], Json::array({model}));
  EXPECT_EQ(flight["items"], 3000);
  EXPECT_EQ(flight["renderer"], "none");
  EXPECT_EQ(flight["size"], Json::array({1280, 720}));
  ASSERT_FALSE(flight["plan"].empty());
  for (const Json& entry : flight["plan"])
    EXPECT_EQ(keys_of(entry), (std::vector<std::string>{"feature", "used", "why"}));
  for (const char* key : {"cull_ms", "frame_ms"})
    for (const char* statistic : {"mean", "median", "p99", "max"})
      EXPECT_TRUE(flight["summary"][key][statistic].is_number()) << key << " " << statistic;
  EXPECT_EQ(flight["summary"]["switches"], 0);
  for (const char* part : {"snapshot", "bvh", "gpu"}) EXPECT_TRUE(flight["memory"][part].is_number_unsigned()) << part;
  EXPECT_GT(flight["memory"]["bvh"], 0);
  EXPECT_EQ(flight["memory"]["gpu"], 0);
}

TEST_F(Replay, FliesAsManyFramesAsAskedFor) {
  const std::string model = plant(3000);
  for (const int frames : {1, 2, 50}) {
    const Json flight = run_json("replay", {model, "--no-render", "--frames", std::to_string(frames)});
    ASSERT_EQ(flight["frames"].size(), std::size_t(frames));
    double last = -1.0;
    for (const Json& frame : flight["frames"]) {
      for (const char* key : {"t", "path", "state", "cull_ms", "draw_ms", "frame_ms", "visible", "tested"})
        EXPECT_TRUE(frame.contains(key)) << key;
      EXPECT_EQ(frame["path"], flight["culler"]);
      EXPECT_GT(frame["t"].get<double>(), last);
      EXPECT_LE(frame["visible"], 3000);
      last = frame["t"].get<double>();
    }
  }
}

TEST_F(Replay, SummariesFollowFromTheFrames) {
  const Json flight = fly({plant(3000)});
  double sum = 0.0, most = 0.0;
  for (const Json& frame : flight["frames"]) {
    sum += frame["visible"].get<double>();
    most = std::max(most, frame["visible"].get<double>());
  }
  EXPECT_NEAR(flight["summary"]["visible"]["mean"].get<double>(), sum / 50.0, 1e-9 * sum);
  EXPECT_EQ(flight["summary"]["visible"]["max"].get<double>(), most);
  EXPECT_EQ(flight["summary"]["visible"]["p99"].get<double>(), most);  // of 50 frames
}

TEST_F(Replay, CullersSeeTheSameItems) {
  const std::string model = plant(3000);
  const Json linear = fly({model, "--culler", "linear"}), cpu = fly({model, "--culler", "cpu"});
  EXPECT_EQ(linear["culler"], "linear");
  EXPECT_EQ(cpu["culler"], "cpu");
  EXPECT_EQ(visible(linear), visible(cpu));
  const auto counts = visible(cpu);
  EXPECT_LT(*std::min_element(counts.begin(), counts.end()), 1500u) << "the tour never comes near";
  EXPECT_EQ(*std::max_element(counts.begin(), counts.end()), 3000u) << "no overview";
}

TEST_F(Replay, ATranslatedModelCullsTheSameItems) {
  const std::string model = plant(3000);
  for (const char* culler : {"linear", "cpu"})
    EXPECT_EQ(visible(fly({model, "--culler", culler})),
              visible(fly({model, "--culler", culler, "--translate", "3e6,7e6,1e3"})));
}

TEST_F(Replay, ASavedPathFliesTheSame) {
  const std::string model = plant(3000), saved = path("tour.json"), again = path("again.json");
  const Json tour = fly({model, "--save-path", saved});
  const Json path_json = json::parse(read_bytes(saved)).value();
  ASSERT_TRUE(path_json.is_object());
  EXPECT_GE(path_json["keys"].size(), 4u);
  const Json replayed = fly({model, "--path", saved, "--save-path", again});
  EXPECT_EQ(visible(replayed), visible(tour));
  EXPECT_EQ(json::parse(read_bytes(again)).value(), path_json);
  // A path is in the model's own frame, so it moves along.
  EXPECT_EQ(visible(fly({model, "--path", saved, "--translate", "3e6,7e6,1e3"})), visible(tour));
}

TEST_F(Replay, WritesOneCsvLinePerFrame) {
  const std::string csv = path("frames.csv");
  const Json flight = fly({plant(3000), "--csv", csv});
  std::istringstream in(read_bytes(csv));
  std::string line;
  ASSERT_TRUE(std::getline(in, line));
  EXPECT_EQ(line, "frame,t,path,state,cull_ms,gpu_cull_ms,draw_ms,frame_ms,visible,tested");
  std::size_t rows = 0;
  for (; std::getline(in, line); ++rows) {
    ASSERT_LT(rows, 50u);
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), 9) << line;
    EXPECT_EQ(line.rfind(std::to_string(rows) + ",", 0), 0u) << line;
    const Json& frame = flight["frames"][rows];
    const std::string tail = "," + frame["visible"].dump() + "," + frame["tested"].dump();
    EXPECT_EQ(line.substr(line.size() - tail.size()), tail);
  }
  EXPECT_EQ(rows, 50u);
}

/// Opening and closing tags match, and nothing stands outside the one root element. Enough for what the tool writes.
bool well_formed(const std::string& xml) {
  std::vector<std::string> open;
  std::size_t roots = 0;
  for (std::size_t i = xml.find('<'); i != std::string::npos; i = xml.find('<', i + 1)) {
    const std::size_t end = xml.find('>', i);
    if (end == std::string::npos || xml.find('<', i + 1) < end) return false;
    const std::string tag = xml.substr(i + 1, end - i - 1);
    const std::string name = tag.substr(tag[0] == '/', tag.find_first_of(" \n/", 1) - (tag[0] == '/'));
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0) return false;
    if (tag[0] == '/') {
      if (open.empty() || open.back() != tag.substr(1)) return false;
      open.pop_back();
    } else {
      if (open.empty() && ++roots > 1) return false;
      if (tag.back() != '/') open.push_back(name);
    }
  }
  for (std::size_t i = xml.find('&'); i != std::string::npos; i = xml.find('&', i + 1))
    if (xml.compare(i, 5, "&amp;") != 0 && xml.compare(i, 4, "&lt;") != 0 && xml.compare(i, 4, "&gt;") != 0)
      return false;
  return open.empty() && roots == 1;
}

TEST_F(Replay, PlotsAsSvg) {
  EXPECT_FALSE(well_formed("<a><b></a>"));
  EXPECT_FALSE(well_formed("<a>x & y</a>"));
  EXPECT_TRUE(well_formed("<a><b c=\"1\"/>x &amp; y</a>\n"));
  const std::string model = path(names_ignore_case() ? "a & b.rvm" : "a<b & c.rvm"), svg = path("plot.svg");
  fs::rename(plant(3000), model);
  fly({model, "--plot", svg});
  const std::string text = read_bytes(svg);
  EXPECT_EQ(text.rfind("<svg ", 0), 0u);
  EXPECT_EQ(text.substr(text.size() - 7), "</svg>\n");
  EXPECT_TRUE(well_formed(text)) << text.substr(0, 2000);
  std::size_t lines = 0;
  for (std::size_t i = text.find("<polyline"); i != std::string::npos; i = text.find("<polyline", i + 1)) {
    ++lines;
    const std::size_t begin = text.find("points=\"", i) + 8;
    const std::string points = text.substr(begin, text.find('"', begin) - begin);
    EXPECT_EQ(std::count(points.begin(), points.end(), ','), 50);
    EXPECT_EQ(points.find("nan"), std::string::npos);
    EXPECT_EQ(points.find("inf"), std::string::npos);
  }
  EXPECT_EQ(lines, 2u);
}

/// The numbers of an attribute, of all elements that begin with `tag` and hold `having`.
std::vector<double> numbers(const std::string& xml, const std::string& tag, const std::string& having,
                            const std::string& attribute) {
  std::vector<double> found;
  for (std::size_t i = xml.find(tag); i != std::string::npos; i = xml.find(tag, i + 1)) {
    const std::string element = xml.substr(i, xml.find('>', i) - i);
    if (element.find(having) == std::string::npos) continue;
    const std::size_t value = element.find(" " + attribute + "=\"") + attribute.size() + 3;
    found.push_back(std::stod(element.substr(value)));
  }
  return found;
}

/// Frames that a plot shades and ticks, against those of the frames' own paths and states.
TEST_F(Replay, PlotsMarkThePathsOfTheHybrid) {
  const std::string svg = path("plot.svg"), json = path("flight.json");
  constexpr int kFrames = 60;
  const Outcome outcome = run("replay", {plant(12000), "--culler", "hybrid", "--size", "16x16", "--frames",
                                         std::to_string(kFrames), "--plot", svg, "--json", json});
  if (!SIGHTLINE_HAS_GL) {
    EXPECT_EQ(outcome.code, 1) << outcome;
    EXPECT_NE(outcome.err.find("this build was made without it"), std::string::npos) << outcome;
    return;
  }
  if (may_skip(outcome.err)) GTEST_SKIP() << outcome.err;
  ASSERT_EQ(outcome.code, 0) << outcome;
  std::vector<bool> shaded, ticked;
  const Json flight = json::parse(read_bytes(json)).value();
  for (const Json& frame : flight["frames"]) {
    ticked.push_back(frame["state"] == "probe");
    const bool before = !shaded.empty() && shaded.back();
    shaded.push_back(ticked.back() ? before : frame["path"] == "gpu");
  }
  ASSERT_EQ(shaded.size(), std::size_t(kFrames));

  const std::string text = read_bytes(svg);
  EXPECT_TRUE(well_formed(text)) << text.substr(0, 2000);
  // The plot's area lies between the ends of its horizontal lines.
  const double left = numbers(text, "<line", "#ddd", "x1").at(0), right = numbers(text, "<line", "#ddd", "x2").at(0);
  const auto frame_at = [&](double x) { return (x - left) / (right - left) * (kFrames - 1); };
  std::vector<bool> shaded_there(kFrames), ticked_there(kFrames);
  const auto x = numbers(text, "<rect", "#e3f1df", "x"), width = numbers(text, "<rect", "#e3f1df", "width"),
             height = numbers(text, "<rect", "#e3f1df", "height");
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int frame = 0; frame < kFrames; ++frame)
      if (height[i] > 100.0 && frame_at(x[i]) < frame + 0.25 && frame - 0.25 < frame_at(x[i] + width[i]))
        shaded_there[std::size_t(frame)] = true;
  const auto tick = numbers(text, "<line", "#3d8a2f", "x1");
  const bool any = std::count(ticked.begin(), ticked.end(), true) > 0;
  for (std::size_t i = 0; i + (any ? 1 : 0) < tick.size(); ++i)  // the last one is the legend's
    ticked_there[std::size_t(std::lround(frame_at(tick[i])))] = true;
  EXPECT_EQ(shaded_there, shaded);
  EXPECT_EQ(ticked_there, ticked);
  EXPECT_TRUE(any) << "the hybrid never looked at the GPU";
  EXPECT_NE(text.find("probe"), std::string::npos);
  const bool on_gpu = std::count(shaded.begin(), shaded.end(), true) > 0;
  EXPECT_EQ(text.find("culled on the GPU") != std::string::npos, on_gpu);
}

TEST_F(Replay, OneFrameAndNoItemsAreFine) {
  const std::string points = write("nothing.stl", tests::stl_text({})), svg = path("plot.svg");
  const Json flight = run_json("replay", {points, "--no-render", "--frames", "1", "--plot", svg});
  EXPECT_EQ(flight["items"], 0);
  EXPECT_EQ(visible(flight), std::vector<std::uint64_t>{0});
  EXPECT_TRUE(well_formed(read_bytes(svg)));
  EXPECT_EQ(read_bytes(svg).find("nan"), std::string::npos);
}

TEST_F(Replay, FileNamesMayHoldAnyBytes) {
  const std::string model = path("plant\xff.rvm");
  if (names_ignore_case()) GTEST_SKIP() << "names are Unicode here";
  fs::rename(plant(1000), model);
  EXPECT_EQ(run_json("replay", {model, "--no-render", "--frames", "2"})["items"], 1000);
}

TEST_F(Replay, PrintsATable) {
  const Outcome outcome = run("replay", {plant(3000), "--no-render", "--frames", "5", "--explain"});
  EXPECT_EQ(outcome.code, 0) << outcome;
  for (const char* text : {"5 frames", "3000 items", "cull ms", "median", "p99", "max", "visible items", "boxes tested",
                           "items/s", "memory"})
    EXPECT_NE(outcome.out.find(text), std::string::npos) << text << "\n" << outcome;
  EXPECT_NE(outcome.err.find("left out"), std::string::npos) << outcome;
}

/// A trace of so many frames in which the CPU costs `cpu` and the GPU 1, culling and in all.
std::string controller_trace(int frames, const std::string& cpu) {
  std::string csv = "frame,visible,cpu_cull_ms,cpu_frame_ms,gpu_cull_ms,gpu_frame_ms\n";
  for (int i = 0; i < frames; ++i) csv += std::to_string(i) + ",1000," + cpu + "," + cpu + ",1,1\n";
  return csv;
}

TEST_F(Replay, RunsAControllerAlone) {
  const std::string trace = write("trace.csv", controller_trace(600, "2"));
  const Json json = run_json("replay", {"--controller-only", trace});
  EXPECT_EQ(keys_of(json), (std::vector<std::string>{"best_fixed_ms", "choice", "chosen_ms", "frames", "oracle_ms",
                                                     "probes", "switches"}));
  EXPECT_EQ(json["frames"], 600);
  EXPECT_EQ(json["oracle_ms"], 600.0);
  EXPECT_EQ(json["best_fixed_ms"], 600.0);
  EXPECT_EQ(json["switches"], 1);
  EXPECT_LT(json["chosen_ms"].get<double>(), 610.0);
  EXPECT_EQ(json["choice"].get<std::string>().size(), 600u);
}

TEST_F(Replay, RefusesBadTracesAndUsage) {
  const std::string good = write("good.csv", controller_trace(3, "2"));
  expect_failure("replay", {"--controller-only", path("missing.csv")}, "missing.csv");
  expect_failure("replay", {"--controller-only", write("empty.csv", "")}, "empty.csv");
  expect_failure("replay", {"--controller-only", write("bad.csv", controller_trace(3, "x"))}, "bad.csv:2: cpu_cull_ms");
  expect_failure("replay", {"--controller-only", good, "--json", unwritable("a.json")}, "a.json");
  expect_usage_error("replay", {"--controller-only", good, "--rendering", "maybe"}, "--rendering");
  expect_usage_error("replay", {"--controller-only", good, plant(1000)}, "MODEL");
  expect_usage_error("replay", {}, "MODEL");
}

}  // namespace
}  // namespace sightline::tests::replay_test
