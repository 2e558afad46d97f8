// --memory: tools that draw more than fits, within a limit that the kernel holds them to.
#include <cmath>
#include <thread>

#include "sightline/tests/apps/render_test.h"

namespace sightline::tests::paged_test {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // whose shadow memory no limit foresees
#else
constexpr bool kSanitized = false;
#endif

class Paged : public RenderTest {
 protected:
  /// A folder of scene caches.
  std::string parts(int items, int count, const std::string& name = "parts") const {
    const Outcome made =
        run("generate", {path(name), "--items", std::to_string(items), "--parts", std::to_string(count)});
    EXPECT_EQ(made.code, 0) << made;
    return path(name);
  }

  /// Runs a tool with so many MiB. The kernel gives it no more but for stacks, of which threads touch next to nothing.
  Outcome run_with(int megabytes, const std::string& tool, Args args) const {
    args.insert(args.end(), {"--memory", std::to_string(megabytes) + "M", "--json", path("figures.json")});
    if (names_ignore_case()) return run(tool, args);  // shells of Windows set no limits
    // RLIMIT_DATA counts the heap, and anonymous and private writable mappings. The rasteriser, OpenMP and those who
    // check files each have a thread per processor, with 8 MiB for its stack.
    const int stacks = 80 + 3 * 8 * int(std::max(1u, std::thread::hardware_concurrency()));
    const std::string limit = kSanitized ? "" : "ulimit -d " + std::to_string((megabytes + stacks) * 1024) + " && ";
    Args all = {"-c", limit + "exec \"$0\" \"$@\"", program_of(tool)};
    all.insert(all.end(), args.begin(), args.end());
    return run_program("bash", all);
  }

  /// Runs a tool with little more than it asks for at least. What drivers have in use changes from run to run, and so
  /// does what is asked for.
  Json run_limited(const std::string& tool, const Args& args) const {
    int megabytes = 0;
    Args refused = args;
    refused.insert(refused.end(), {"--memory", "1M"});
    Outcome outcome = run(tool, refused);
    EXPECT_EQ(outcome.code, 1) << outcome;
    for (int tries = 0; tries < 5 && outcome.code == 1; ++tries) {
      const std::size_t at = outcome.err.find("expected ");
      if (outcome.err.find("is too low") == std::string::npos || at == std::string::npos) break;
      megabytes = std::atoi(outcome.err.c_str() + at + 9) + 24;
      outcome = run_with(megabytes, tool, args);
    }
    EXPECT_EQ(outcome.code, 0) << outcome;
    Json results = json::parse(read_bytes(path("figures.json"))).value();
    EXPECT_TRUE(results.is_object()) << outcome;
    if (!results.is_object()) return Json::object();
    if (!kSanitized) {
      EXPECT_LE(results["memory"]["peak"].get<double>(), std::ldexp(double(megabytes), 20));
    }
    return results;
  }
};

TEST_F(Paged, TheLimitHoldsAndTheImageIsTheSame) {
  const std::string model = parts(240'000, 3);
  const Args image = {model, "--size", "320x180", "--out"};
  Args tight = image, loose = image;
  tight.push_back(path("tight.png"));
  loose.insert(loose.end(), {path("loose.png"), "--memory", "8G"});
  render(loose);
  const Json results = run_limited("render", tight);
  EXPECT_EQ(results["items"], 240'000);
  EXPECT_GT(results["evicted"], 0);
  EXPECT_TRUE(read_bytes(path("tight.png")) == read_bytes(path("loose.png")));
}

/// Memory that grows with the image counts: of squares that stand in, of drivers, and of images that are read.
TEST_F(Paged, TheLimitHoldsForLargeImages) {
  const std::string model = parts(40'000, 2);
  const Args image = {model, "--size", "2400x1500"};
  Args first = image, second = image;
  first.insert(first.end(), {"--out", path("first.png")});
  second.insert(second.end(), {"--out", path("second.png"), "--ids", path("ids.png"), "--depth", path("depth.pfm")});
  run_limited("render", first);
  run_limited("render", second);
  EXPECT_TRUE(read_bytes(path("first.png")) == read_bytes(path("second.png")));
}

/// A folder stands for the same files whether it is drawn page by page or not, and none is missing in silence.
TEST_F(Paged, AFolderIsAllOfItsParts) {
  const std::string model = parts(3000, 3);
  fs::rename(path("parts/part-00002.slc"), path("parts/b.SLC"));
  fs::create_directory(path("parts/folder.slc"));
  const auto items = [&](const std::string& of, const Args& more) {
    Args args = {of, "--size", "64x36"};
    args.insert(args.end(), more.begin(), more.end());
    return run_json("render", args)["items"];
  };
  EXPECT_EQ(items(model, {}), 3000);
  EXPECT_EQ(items(model, {"--memory", "4G"}), 3000);
  EXPECT_EQ(items(path("parts/b.SLC"), {"--memory", "4G"}), 1000);
  if (!make_link(path("gone"), path("parts/c.slc"))) GTEST_SKIP() << "no links here";
  expect_failure("render", {"--out", path("unused.png"), model, "--size", "64x36"}, "c.slc", true);
  expect_failure("render", {"--out", path("unused.png"), model, "--size", "64x36", "--memory", "4G"}, "c.slc", true);
}

/// Each part is an open file, and shells allow 1024 of them unless told otherwise.
TEST_F(Paged, AFolderMayHaveMorePartsThanAShellAllowsFiles) {
  if (names_ignore_case()) GTEST_SKIP() << "shells of Windows set no limits";
  const std::string model = parts(2000, 2);
  for (int i = 3; i < 120; ++i)
    fs::create_hard_link(path("parts/part-00001.slc"), path("parts/" + std::to_string(i) + ".slc"));
  const Outcome drawn = run_program("bash", {"-c", "ulimit -S -n 64 && exec \"$0\" \"$@\"", program_of("render"), model,
                                             "--size", "64x36", "--memory", "4G", "--out", path("many.png")});
  EXPECT_EQ(drawn.code, 0) << drawn;
}

TEST_F(Paged, AnImageIsThatOfTheWholeInMemory) {
  ASSERT_EQ(run("generate", {path("plant.slc"), "--items", "120000"}).code, 0);
  for (const std::string& view : {std::string(R"({"eye":[-30,-12,6],"target":[5,2,3],"fovy_deg":60,"near":0.1})"),
                                  std::string(R"({"eye":[0,0,150],"target":[1,0,0],"fovy_deg":45,"near":1})")}) {
    const Args args = {path("plant.slc"), "--size", "320x180", "--view", write("view.json", view)};
    const auto with = [&](const Args& more) {
      Args all = args;
      all.insert(all.end(), more.begin(), more.end());
      return all;
    };
    render(with({"--samples", "1", "--out", path("whole.png"), "--depth", path("whole.pfm")}));
    const Outcome paged = render(with({"--memory", "4G", "--out", path("paged.png"), "--depth", path("paged.pfm"),
                                       "--compare", path("whole.png"), "--max", "0"}));
    EXPECT_NE(paged.out.find(" ok"), std::string::npos) << paged;
    EXPECT_TRUE(read_bytes(path("paged.pfm")) == read_bytes(path("whole.pfm")));
  }
}

TEST_F(Paged, AFlightStaysBelowTheLimitAndComesToRest) {
  const std::string model = parts(200'000, 2);
  const Json results = run_limited("replay", {model, "--size", "320x180", "--frames", "24", "--images", path("images"),
                                              "--every", "24", "--save-path", path("path.json")});
  ASSERT_EQ(results["frames"].size(), 24u);
  EXPECT_GT(results["frames"][0]["placeholders"], 0);
  EXPECT_GT(results["loaded"], 0);
  // At rest the last view is what it is without a flight before.
  const Outcome rest =
      render({model, "--plain", "--size", "320x180", "--memory", "4G", "--path", path("path.json"), "--frame", "23",
              "--frames", "24", "--compare", path("images/frame_00024.png"), "--max", "0"});
  EXPECT_NE(rest.out.find(" ok"), std::string::npos) << rest;
  const Json settled = run_json("replay", {model, "--size", "320x180", "--frames", "3", "--settle", "--memory", "4G"});
  EXPECT_EQ(settled["complete_frames"], 3);
}

TEST_F(Paged, BadInputIsRefused) {
  const std::string rvm = plant(1000);
  expect_failure("render", {"--out", path("unused.png"), rvm, "--memory", "2G"}, "expected one scene cache", true);
  expect_failure("render", {"--out", path("unused.png"), path("none.slc"), "--memory", "2G"}, "none.slc", true);
  fs::create_directories(path("empty"));
  expect_failure("render", {"--out", path("unused.png"), path("empty"), "--memory", "2G"}, "expected .slc files", true);
  expect_usage_error("render", {rvm, "--memory", "much"}, "expected bytes such as 800M or 2G");
  expect_usage_error("render", {rvm, "--memory", "-1G"}, "expected bytes");
  expect_usage_error("render", {rvm, "--memory", "2G", "--samples", "4"}, "--samples");
  expect_usage_error("render", {rvm, "--memory", "2G", "--recognise"}, "--recognise");
  expect_usage_error("replay", {rvm, "--memory", "2G", "--rendering", "off"}, "--rendering");
  expect_usage_error("replay", {rvm, "--settle"}, "--memory");
  ASSERT_EQ(run("generate", {path("plant.slc"), "--items", "40000"}).code, 0);
  std::fstream damage(path("plant.slc"), std::ios::in | std::ios::out | std::ios::binary);
  damage.seekp(std::streamoff(fs::file_size(path("plant.slc")) / 3));
  damage.write("damage", 6);
  damage.close();
  expect_failure("render", {"--out", path("unused.png"), path("plant.slc"), "--size", "64x36", "--memory", "4G"},
                 "does not match its checksum", true);
}

TEST_F(Paged, PartsAreTheSameForTheSameSeed) {
  const std::string a = parts(5000, 3, "a"), b = parts(5000, 3, "b");
  int files = 0;
  for (const auto& entry : fs::directory_iterator(a)) {
    EXPECT_TRUE(read_bytes(entry.path()) == read_bytes(fs::path(b) / entry.path().filename()));
    ++files;
  }
  EXPECT_EQ(files, 3);
  // Again into the same folder, but not beside parts of another model.
  EXPECT_EQ(run("generate", {a, "--items", "5000", "--parts", "3"}).code, 0);
  expect_failure("generate", {a, "--items", "4000", "--parts", "2"}, "part-00003.slc");
  EXPECT_TRUE(read_bytes(fs::path(a) / "part-00001.slc") == read_bytes(fs::path(b) / "part-00001.slc"));
  expect_usage_error("generate", {path("few"), "--items", "1999", "--parts", "2"}, "--items");
  expect_usage_error("generate", {path("many"), "--items", "20000001", "--parts", "2"}, "--items");
  expect_failure("generate", {unwritable("parts"), "--items", "5000", "--parts", "2"}, "parts");
}

}  // namespace
}  // namespace sightline::tests::paged_test
