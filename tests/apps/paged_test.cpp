// --memory: tools that draw more than fits, within a limit that the kernel holds them to.
#include <cmath>

#include "sightline/tests/apps/render_test.h"

namespace sightline::tests {
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

  /// Little more than what is asked for at least, MiB.
  int least_limit(const std::string& model) const {
    const Outcome refused = run("render", {model, "--size", "320x180", "--memory", "1M"});
    EXPECT_EQ(refused.code, 1) << refused;
    const std::size_t at = refused.err.find("expected ");
    EXPECT_NE(at, std::string::npos) << refused;
    return at == std::string::npos ? 0 : std::atoi(refused.err.c_str() + at + 9) + 24;
  }

  /// Runs a tool with so many MiB. The kernel gives it no more but for stacks, of which threads touch next to nothing.
  Json run_limited(const std::string& tool, Args args, int megabytes) const {
    args.insert(args.end(), {"--memory", std::to_string(megabytes) + "M", "--json", path("figures.json")});
    // Of the heap, and of anonymous and private writable mappings.
    constexpr int kStacks = 128;
    const std::string limit = kSanitized ? "" : "ulimit -d " + std::to_string((megabytes + kStacks) * 1024) + " && ";
    Args all = {"-c", limit + "exec \"$0\" \"$@\"", program_of(tool)};
    all.insert(all.end(), args.begin(), args.end());
    const Outcome outcome = run_program("bash", all);
    EXPECT_EQ(outcome.code, 0) << outcome;
    Json figures = Json::parse(read_bytes(path("figures.json")), nullptr, false);
    EXPECT_TRUE(figures.is_object()) << outcome;
    if (!kSanitized && figures.is_object()) {
      EXPECT_LE(figures["memory"]["peak"].get<double>(), std::ldexp(double(megabytes), 20));
    }
    return figures;
  }
};

TEST_F(Paged, TheLimitHoldsAndThePictureIsTheSame) {
  const std::string model = parts(240'000, 3);
  const Args picture = {model, "--size", "320x180", "--out"};
  Args tight = picture, loose = picture;
  tight.push_back(path("tight.png"));
  loose.insert(loose.end(), {path("loose.png"), "--memory", "8G"});
  render(loose);
  const Json figures = run_limited("render", tight, least_limit(model));
  EXPECT_EQ(figures["items"], 240'000);
  EXPECT_GT(figures["evicted"], 0);
  EXPECT_TRUE(read_bytes(path("tight.png")) == read_bytes(path("loose.png")));
}

TEST_F(Paged, APictureIsThatOfTheWholeInMemory) {
  ASSERT_EQ(run("generate", {path("plant.slc"), "--items", "120000"}).code, 0);
  for (const std::string& view : {std::string(R"({"eye":[-30,-12,6],"target":[5,2,3],"fovy_deg":60,"near":0.1})"),
                                  std::string(R"({"eye":[0,0,150],"target":[1,0,0],"fovy_deg":45,"near":1})")}) {
    const Args args = {path("plant.slc"), "--size", "320x180", "--view", write("view.json", view)};
    const auto with = [&](const Args& more) {
      Args all = args;
      all.insert(all.end(), more.begin(), more.end());
      return all;
    };
    render(with({"--out", path("whole.png"), "--depth", path("whole.pfm")}));
    const Outcome paged = render(with({"--memory", "4G", "--out", path("paged.png"), "--depth", path("paged.pfm"),
                                       "--compare", path("whole.png"), "--max", "0"}));
    EXPECT_NE(paged.out.find(" ok"), std::string::npos) << paged;
    EXPECT_TRUE(read_bytes(path("paged.pfm")) == read_bytes(path("whole.pfm")));
  }
}

TEST_F(Paged, AFlightStaysBelowTheLimitAndComesToRest) {
  const std::string model = parts(200'000, 2);
  const Json figures = run_limited("replay",
                                   {model, "--size", "320x180", "--frames", "24", "--images", path("images"), "--every",
                                    "24", "--save-path", path("path.json")},
                                   least_limit(model));
  ASSERT_EQ(figures["frames"].size(), 24u);
  EXPECT_GT(figures["frames"][0]["stand_ins"], 0);
  EXPECT_GT(figures["loaded"], 0);
  // At rest the last view is what it is without a flight before.
  const Outcome rest = render({model, "--size", "320x180", "--memory", "4G", "--path", path("path.json"), "--frame",
                               "23", "--frames", "24", "--compare", path("images/frame_00024.png"), "--max", "0"});
  EXPECT_NE(rest.out.find(" ok"), std::string::npos) << rest;
  const Json settled = run_json("replay", {model, "--size", "320x180", "--frames", "3", "--settle", "--memory", "4G"});
  EXPECT_EQ(settled["complete_frames"], 3);
}

TEST_F(Paged, BadInputIsRefused) {
  const std::string rvm = plant(1000);
  expect_failure("render", {rvm, "--memory", "2G"}, "expected one scene cache", true);
  expect_failure("render", {path("none.slc"), "--memory", "2G"}, "none.slc", true);
  fs::create_directories(path("empty"));
  expect_failure("render", {path("empty"), "--memory", "2G"}, "expected .slc files", true);
  expect_usage_error("render", {rvm, "--memory", "much"}, "expected bytes such as 800M or 2G");
  expect_usage_error("render", {rvm, "--memory", "-1G"}, "expected bytes");
  expect_usage_error("render", {rvm, "--memory", "2G", "--samples", "4"}, "--samples");
  expect_usage_error("replay", {rvm, "--settle"}, "--memory");
  ASSERT_EQ(run("generate", {path("plant.slc"), "--items", "40000"}).code, 0);
  std::fstream damage(path("plant.slc"), std::ios::in | std::ios::out | std::ios::binary);
  damage.seekp(std::streamoff(fs::file_size(path("plant.slc")) / 3));
  damage.write("damage", 6);
  damage.close();
  expect_failure("render", {path("plant.slc"), "--size", "64x36", "--memory", "4G"}, "does not match its checksum",
                 true);
}

TEST_F(Paged, PartsAreTheSameForTheSameSeed) {
  const std::string a = parts(5000, 3, "a"), b = parts(5000, 3, "b");
  int files = 0;
  for (const auto& entry : fs::directory_iterator(a)) {
    EXPECT_TRUE(read_bytes(entry.path()) == read_bytes(fs::path(b) / entry.path().filename()));
    ++files;
  }
  EXPECT_EQ(files, 3);
  expect_usage_error("generate", {path("few"), "--items", "1999", "--parts", "2"}, "--items");
  expect_usage_error("generate", {path("many"), "--items", "20000001", "--parts", "2"}, "--items");
  expect_failure("generate", {unwritable("parts"), "--items", "5000", "--parts", "2"}, "parts");
}

}  // namespace
}  // namespace sightline::tests
