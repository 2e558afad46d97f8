// sightline-bench cull on boxes and views made here, against a plain test of the six clip planes.
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "sightline/tests/apps/tool_test.h"

namespace sightline::tests::bench_cull_test {
namespace {

using Box = std::array<float, 6>;       // min x y z, max x y z
using Matrix = std::array<double, 16>;  // column-major

constexpr unsigned kSeed = 20240611;

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t col = 0; col < 4; ++col)
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t k = 0; k < 4; ++k) c[4 * col + row] += a[4 * k + row] * b[4 * col + k];
  return c;
}

/// Perspective with depth -1 … 1, looking along -z, after a turn about z and a move.
Matrix camera(double angle, double x, double y, double z, double fovy) {
  const double f = 1.0 / std::tan(0.5 * fovy), near = 0.5, far = 300.0, s = std::sin(angle), c = std::cos(angle);
  const Matrix clip = {
      f / 1.5, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0};
  const Matrix up_is_z = {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1};
  const Matrix turn = {c, -s, 0, 0, s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  const Matrix move = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1};
  return product(clip, product(up_is_z, product(turn, move)));
}

/// The least, over the clip planes, of how far the box reaches inside. Visible from 0 on.
double reach_inside(const Box& box, const Matrix& m) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t row = 0; row < 3; ++row)
    for (const double sign : {1.0, -1.0}) {
      double reach = m[12 + 3] + sign * m[12 + row];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double n = m[4 * axis + 3] + sign * m[4 * axis + row];
        reach += n * double(box[n >= 0.0 ? axis + 3 : axis]);
      }
      least = std::min(least, reach);
    }
  return least;
}

class BenchCull : public ToolTest {
 protected:
  void SetUp() override {
    ToolTest::SetUp();
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<float> place(-100.0f, 100.0f), size(0.0f, 3.0f);
    for (int i = 0; i < 5000; ++i) {
      Box box{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box[axis] = place(random);
        box[axis + 3] = box[axis] + (i % 10 == 0 ? 0.0f : size(random));  // every tenth is a point
      }
      boxes.push_back(box);
    }
    std::uniform_real_distribution<double> angle(-3.2, 3.2), where(-120.0, 120.0), fovy(0.1, 2.5);
    for (int i = 0; i < 20; ++i)
      views.push_back(camera(angle(random), where(random), where(random), where(random), fovy(random)));
    views.push_back(camera(0.0, 0.0, -5000.0, 0.0, 1.0));  // all beyond the far plane
    box_file = write("boxes.f32", bytes_of(boxes));
    view_file = write("views.f64", bytes_of(views));
  }

  Json bench(const Args& more) const {
    Args args = {"cull", "--boxes", box_file, "--views", view_file};
    args.insert(args.end(), more.begin(), more.end());
    return run_json("bench", args);
  }

  std::vector<std::uint32_t> ids(const std::string& folder, std::size_t frame) const {
    char name[32];
    std::snprintf(name, sizeof name, "frame_%05zu.bin", frame);
    const std::string bytes = read_bytes(fs::path(folder) / name);
    EXPECT_TRUE(fs::exists(fs::path(folder) / name)) << name;
    EXPECT_EQ(bytes.size() % 4, 0u);
    std::vector<std::uint32_t> out(bytes.size() / 4);
    if (!out.empty()) std::memcpy(out.data(), bytes.data(), 4 * out.size());
    return out;
  }

  void expect_bad(const std::string& boxes_at, const std::string& views_at, const std::string& named) const {
    expect_failure("bench", {"cull", "--boxes", boxes_at, "--views", views_at, "--json", "-"}, named);
  }

  std::vector<Box> boxes;
  std::vector<Matrix> views;
  std::string box_file, view_file;
};

TEST_F(BenchCull, WritesTheKeysOfTheContract) {
  const Json out = bench({});
  EXPECT_EQ(out["items"], boxes.size());
  EXPECT_GE(out["build_ms"], 0.0);
  EXPECT_GE(out["bytes_per_item"], 24.0);
  ASSERT_EQ(out["frames"].size(), views.size());
  for (const Json& frame : out["frames"])
    EXPECT_TRUE(frame["cull_ms"].is_number() && frame["visible"].is_number_unsigned()) << frame;
  for (const char* statistic : {"mean", "median", "p99", "max"})
    EXPECT_TRUE(out["summary"][statistic].is_number()) << statistic;
}

TEST_F(BenchCull, FindsWhatThePlanesSay) {
  SCOPED_TRACE(kSeed);
  for (const char* culler : {"linear", "cpu"}) {
    SCOPED_TRACE(culler);
    const std::string folder = path(std::string("ids-") + culler);
    const Json out = bench({"--culler", culler, "--ids-out", folder});
    std::size_t total = 0, seeing = 0;
    for (std::size_t frame = 0; frame < views.size(); ++frame) {
      SCOPED_TRACE(frame);
      const auto found = ids(folder, frame);
      total += found.size();
      seeing += !found.empty();
      EXPECT_EQ(out["frames"][frame]["visible"], found.size());
      EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
      EXPECT_TRUE(std::adjacent_find(found.begin(), found.end()) == found.end()) << "an id twice";
      std::vector<bool> visible(boxes.size());
      for (const std::uint32_t id : found) {
        ASSERT_LT(id, boxes.size());
        visible[id] = true;
      }
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        const double reach = reach_inside(boxes[i], views[frame]);
        if (reach >= 0.0) {
          EXPECT_TRUE(visible[i]) << "box " << i << " is lost";
        } else if (reach < -1e-3) {  // nearer, float rounding may keep it
          EXPECT_FALSE(visible[i]) << "box " << i << " is far outside";
        }
      }
    }
    EXPECT_GT(total, 1000u);
    EXPECT_GE(seeing, 10u) << "frames that see anything";
    EXPECT_EQ(ids(folder, views.size() - 1).size(), 0u);
    EXPECT_EQ(std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator())), views.size());
  }
}

TEST_F(BenchCull, CullersAndOutputsAgree) {
  const auto counts = [](const Json& out) {
    std::vector<std::uint64_t> list;
    for (const Json& frame : out["frames"]) list.push_back(frame["visible"].get<std::uint64_t>());
    return list;
  };
  const auto linear = counts(bench({"--culler", "linear"}));
  for (const Args& more : {Args{"--culler", "cpu"}, Args{"--culler", "cpu", "--output", "ids"},
                           Args{"--culler", "cpu", "--output", "ranges", "--threads", "2"},
                           Args{"--culler", "linear", "--output", "ids"}, Args{"--culler", "cpu", "--verify"}})
    EXPECT_EQ(counts(bench(more)), linear) << more.back();
}

TEST_F(BenchCull, TakesNoBoxesAndNoViews) {
  const std::string empty = write("empty", "");
  const Json no_boxes = run_json("bench", {"cull", "--boxes", empty, "--views", view_file});
  EXPECT_EQ(no_boxes["items"], 0);
  EXPECT_EQ(no_boxes["frames"].size(), views.size());
  EXPECT_EQ(run_json("bench", {"cull", "--boxes", box_file, "--views", empty})["frames"].size(), 0u);
}

TEST_F(BenchCull, RefusesDamagedFiles) {
  const std::string box_bytes = bytes_of(boxes), view_bytes = bytes_of(views);
  for (const std::size_t lost : {1, 4, 23}) {
    expect_bad(write("bad", box_bytes.substr(lost)), view_file, path("bad"));
    expect_bad(box_file, write("bad", view_bytes.substr(lost)), path("bad"));
  }
  for (const float wrong : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    auto changed = boxes;
    changed[123][4] = wrong;
    expect_bad(write("bad", bytes_of(changed)), view_file, "box 123");
    auto moved = views;
    moved[7][12] = double(wrong);
    expect_bad(box_file, write("bad", bytes_of(moved)), "view 7");
  }
}

TEST_F(BenchCull, RefusesWhatItCannotReadOrWrite) {
  fs::create_directories(path("folder"));
  for (const std::string& bad : {path("missing"), path("folder"), unwritable("below")}) {
    expect_bad(bad, view_file, bad);
    expect_bad(box_file, bad, bad);
  }
  const std::string bad = unwritable("out");
  expect_failure("bench", {"cull", "--boxes", box_file, "--views", view_file, "--json", bad}, bad);
  expect_failure("bench", {"cull", "--boxes", box_file, "--views", view_file, "--ids-out", bad}, bad);
}

TEST_F(BenchCull, RefusesBadOptions) {
  const Args files = {"cull", "--boxes", box_file, "--views", view_file};
  for (const auto& [option, value] : std::vector<std::pair<std::string, std::string>>{
           {"--culler", "magic"}, {"--output", "both"}, {"--threads", "0"}, {"--threads", "x"}}) {
    Args args = files;
    args.insert(args.end(), {option, value});
    expect_usage_error("bench", args, option);
  }
  expect_usage_error("bench", {"cull", "--boxes", box_file}, "--views");
}

}  // namespace
}  // namespace sightline::tests::bench_cull_test
