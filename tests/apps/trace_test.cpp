// sightline-trace: images, ids, depth, and the items that they show.
#include "sightline/tests/apps/tool_test.h"

namespace sightline::tests::trace_test {
namespace {

const char* const kView = R"({"eye":[-30,-12,6],"target":[5,2,3],"up":[0,0,1],"fovy_deg":60,"near":0.1,"far":1000})";

class Trace : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    model = plant(1000);
    view = write("view.json", kView);
  }

  /// Runs on a small image; must succeed. Returns the bytes that it wrote to `option`.
  std::string traced(const std::string& option, const Args& more) const {
    const std::string out = path("traced");
    fs::remove(out);
    Args args = {model, "--view", view, "--size", "160x90", option, out};
    args.insert(args.end(), more.begin(), more.end());
    const Outcome outcome = run("trace", args);
    EXPECT_EQ(outcome.code, 0) << outcome;
    return read_bytes(out);
  }

  std::string model, view;
};

TEST_F(Trace, DoesNotDependOnTheNumberOfThreads) {
  for (const Args& more : {Args{}, {"--samples", "4", "--adaptive", "0.1"}, {"--sun", "1,-1,2", "--shadows"}}) {
    Args one = more, three = more;
    one.insert(one.end(), {"--threads", "1"});
    three.insert(three.end(), {"--threads", "3"});
    for (const char* option : {"--out", "--ids", "--depth", "--visible"}) {
      const std::string bytes = traced(option, one);
      EXPECT_GT(bytes.size(), 100u) << option;
      EXPECT_EQ(bytes, traced(option, three)) << option;
    }
  }
}

TEST_F(Trace, EachOptionChangesTheImage) {
  std::vector<std::string> images;
  for (const Args& more : {Args{},
                           {"--samples", "4"},
                           {"--samples", "4", "--adaptive", "0.2"},
                           {"--sun", "1,-1,2"},
                           {"--sun", "1,-1,2", "--shadows"},
                           {"--sun", "1,-1,2", "--sun", "-1,-1,2"},
                           {"--reflect", "0.5"}})
    images.push_back(traced("--out", more));
  for (std::size_t i = 0; i < images.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(images[i], images[j]) << i << " " << j;
}

TEST_F(Trace, CountsTheSamplesOfVisibleItems) {
  const Json seen = json::parse(traced("--visible", {"--samples", "4"})).value();
  ASSERT_TRUE(seen.is_object());
  EXPECT_EQ(seen["size"], (Json{160, 90}));
  EXPECT_EQ(seen["samples_per_pixel"], 4);
  ASSERT_GT(seen["items"].size(), 20u);
  std::uint64_t samples = 0;
  for (const Json& item : seen["items"]) {
    EXPECT_EQ(keys_of(item), (std::vector<std::string>{"item", "kind", "node", "samples"}));
    EXPECT_EQ(item["node"].get<std::string>().rfind("plant-1000-1.rvm/", 0), 0u) << item;
    EXPECT_GT(item["samples"], 0);
    samples += item["samples"].get<std::uint64_t>();
  }
  EXPECT_LT(samples, 160u * 90u * 4u);
}

TEST_F(Trace, AdaptiveSamplingTakesFewerSamples) {
  const auto samples = [&](const Args& more) {
    return json::parse(traced("--json", more)).value()["samples"].get<std::uint64_t>();
  };
  const std::uint64_t pixels = 160 * 90, adaptive = samples({"--samples", "9", "--adaptive", "0.1"});
  EXPECT_EQ(samples({}), pixels);
  EXPECT_EQ(samples({"--samples", "9"}), 9 * pixels);
  EXPECT_GT(adaptive, pixels);
  EXPECT_LT(adaptive, 8 * pixels);
  EXPECT_EQ(samples({"--samples", "9", "--adaptive", "1"}), pixels);
}

TEST_F(Trace, KeepsStdoutForTheJson) {
  const Outcome outcome = run("trace", {model, "--size", "32x18", "--json", "-"});
  EXPECT_EQ(outcome.code, 0) << outcome;
  const Json results = json::parse(outcome.out).value();
  EXPECT_EQ(keys_of(results),
            (std::vector<std::string>{"build_seconds", "items", "samples", "size", "trace_seconds", "tracer_bytes"}));
}

TEST_F(Trace, TellsWhatAPixelShows) {
  const Json seen = json::parse(traced("--visible", {})).value();
  ASSERT_TRUE(seen.is_object());
  std::uint64_t found = 0;
  for (int x = 4; x < 160; x += 15) {
    const Json picked = json::parse(traced("--json", {"--pick", std::to_string(x) + ".5,45.5"})).value()["pick"];
    if (picked.is_null()) continue;
    ++found;
    EXPECT_TRUE(std::any_of(seen["items"].begin(), seen["items"].end(), [&](const Json& item) {
      return item["item"] == picked["item"] && item["node"] == picked["node"] && item["kind"] == picked["kind"];
    })) << picked;
    EXPECT_EQ(picked.contains("triangle"), picked["face"] == "triangle") << picked;
    EXPECT_EQ(picked["point"].size(), 3u);
  }
  EXPECT_GT(found, 0u);
}

TEST_F(Trace, ExplainsWhatTheTracerTakes) {
  const auto line = [&](const std::string& tool) {
    const std::string text = run(tool, {model, "--size", "32x18", "--explain"}).err;
    const std::size_t at = text.find("ray tracer");
    const std::size_t begin = text.rfind('\n', at) + 1;
    return at == std::string::npos ? text : text.substr(begin, text.find('\n', at) - begin);
  };
  const std::string traced = line("trace");
  EXPECT_EQ(traced.rfind("used", 0), 0u) << traced;
  EXPECT_NE(traced.find(" bytes"), std::string::npos) << traced;
  const std::string info = run("info", {model, "--explain"}).err;
  const std::size_t at = info.find("ray tracer");
  ASSERT_NE(at, std::string::npos) << info;
  EXPECT_EQ(info.rfind("left out", at) > info.rfind('\n', at), true) << info;
}

TEST_F(Trace, RefusesBadOptions) {
  for (const char* bad : {"1", "1,x", "1,2,3"}) expect_usage_error("trace", {"model.rvm", "--pick", bad}, "--pick");
  for (const char* bad : {"0", "-1", "4097", "1.5", "many"})
    expect_usage_error("trace", {"model.rvm", "--samples", bad}, "--samples");
  for (const char* bad : {"-0.1", "1.1", "nan", "x"})
    expect_usage_error("trace", {"model.rvm", "--adaptive", bad}, "--adaptive");
  for (const char* bad : {"1,2", "x", "nan,0,0", "0,0,0"})
    expect_usage_error("trace", {"model.rvm", "--sun", bad}, "--sun");
  expect_usage_error("trace", {"model.rvm", "--shadows"}, "--sun");
  for (const char* bad : {"0x5", "5", "16385x4"}) expect_usage_error("trace", {"model.rvm", "--size", bad}, "--size");
  expect_usage_error("trace", {"model.rvm", "--frame", "1"}, "--path");
  const std::string bad = unwritable("a");
  for (const char* option : {"--out", "--ids", "--depth", "--visible", "--json"})
    expect_failure("trace", {model, "--size", "8x8", option, bad}, bad);
}

}  // namespace
}  // namespace sightline::tests::trace_test
