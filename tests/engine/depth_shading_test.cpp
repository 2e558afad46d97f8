// EngineConfig::drawing.looks.depth_shading: shading and lines by depth, against the same computed from distances in
// metres.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/tests/engine/drawing_modes.h"

namespace sightline::tests::depth_shading_test {
namespace {

using engine::CullerChoice;
using engine::DepthShading;
using engine::Engine;
using engine::EngineConfig;

constexpr int kWidth = 192, kHeight = 128;
constexpr double kFovy = 0.8, kAspect = 1.5, kNear = 0.1, kFar = 60.0, kOrthoHeight = 14.0;
constexpr DepthShading kDepthShading{0.7f, 0.5f};

core::Pose around(double turn) {
  const core::dvec3 centre(7.0), eye = centre + 15.0 * core::dvec3(std::cos(turn), std::sin(turn), 0.4);
  return {eye, centre, {0, 0, 1}};
}

class DepthShadingTest : public DrawnGrid {
 protected:
  void SetUp() override {
    DrawnGrid::SetUp();
    fill(scene, 14);
  }
  EngineConfig configured(
      const DepthShading& depth_shading, void (*set)(EngineConfig&) = [](EngineConfig&) {}) {
    EngineConfig c = config(CullerChoice::kCpu, kWidth, kHeight);
    c.drawing.ids = true;
    set(c);
    c.drawing.looks.depth_shading = depth_shading;
    return c;
  }
  static image::Image image(Engine& engine, const core::View& view) {
    if (!draw_complete(engine, view)) return {};
    return *engine.read_colour();
  }

  core::Scene scene;
};

/// The rule of depth_shading.frag in the words of its comment, with distances.
class Twin {
 public:
  /// `far`: distance that stands for the sky.
  Twin(const std::vector<float>& metres, const core::View& view, double far, double pixel)
      : metres_(metres), orthographic_(view.orthographic()), far_(far), pixel_(pixel) {}

  double factor(int x, int y, const DepthShading& depth_shading) const {
    static constexpr int kClose[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
    static constexpr int kWide[4][2] = {{5, 2}, {2, 5}, {-2, 5}, {-5, 2}};
    if (!covered(x, y)) return 1.0 - depth_shading.edge_lines * outline(x, y);
    double line = 0.0, dark = 0.0;
    for (const auto& [dx, dy] : kClose) {
      const double reach = std::hypot(dx, dy);
      const double a = steps(x, y, dx, dy) / reach, b = steps(x, y, -dx, -dy) / reach;
      if (std::min(a, b) <= 12.0) dark += hollow(a + b);
      double drawn = 0.0;
      if (std::max(a, b) > 12.0 && std::abs(std::min(a, b)) < 4.0)
        drawn = 1.0;
      else if (std::max(std::abs(a), std::abs(b)) < 4.0)
        drawn = smooth((std::abs(a + b) - 0.7) / 0.7);
      line = std::max(line, drawn * alone(x, y, dx, dy, a + b));
    }
    for (const auto& [dx, dy] : kWide) dark += hollow((steps(x, y, dx, dy) + steps(x, y, -dx, -dy)) / 5.4);
    return (1.0 - depth_shading.strength * dark / 8.0) * (1.0 - depth_shading.edge_lines * line);
  }

 private:
  static double smooth(double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
  }
  /// Fainter beside what is four pixels wide or less.
  double outline(int x, int y) const {
    double drawn = 0.0;
    for (const auto& [dx, dy] : {std::array{1, 0}, {-1, 0}, {0, 1}, {0, -1}})
      if (covered(x + dx, y + dy)) drawn = std::max(drawn, covered(x + 4 * dx, y + 4 * dy) ? 1.0 : 0.2);
    return drawn;
  }
  /// Fainter where slopes change as much two pixels off.
  double alone(int x, int y, int dx, int dy, double change) const {
    double other = 0.0;
    for (const int side : {-2, 2}) {
      const int i = x + side * dx, j = y - side * dy;
      if (outside(i + dx, j - dy) || outside(i - dx, j + dy)) continue;
      const double here = distance(x, y), middle = distance(i, j), a = distance(i + dx, j - dy),
                   b = distance(i - dx, j + dy);
      const double bend = orthographic_ ? 2.0 * middle - a - b : here / a + here / b - 2.0 * here / middle;
      other = std::max(other, std::abs(bend) / pixel_ / std::hypot(dx, dy));
    }
    return 1.0 - 0.8 * smooth((other / std::min(std::abs(change), 24.0) - 0.5) / 0.5);
  }
  static bool outside(int i, int j) { return i < 0 || j < 0 || i >= kWidth || j >= kHeight; }
  static double hollow(double sum) { return std::max(0.0, sum) / (1.0 + std::max(0.0, sum)); }
  float at(int x, int y) const {
    return metres_[std::size_t(std::clamp(y, 0, kHeight - 1) * kWidth + std::clamp(x, 0, kWidth - 1))];
  }
  bool covered(int x, int y) const { return std::isfinite(at(x, y)); }
  double distance(int x, int y) const { return covered(x, y) ? double(at(x, y)) : far_; }
  /// Nearer by so many widths of a pixel.
  double steps(int x, int y, int dx, int dy) const {
    if (outside(x + dx, y - dy) || outside(x - dx, y + dy)) return 0.0;
    const double here = distance(x, y), there = distance(x + dx, y - dy);  // rows run down, in GL up
    return orthographic_ ? (here - there) / pixel_ : (here / there - 1.0) / pixel_;
  }

  const std::vector<float>& metres_;
  bool orthographic_;
  double far_, pixel_;
};

TEST_F(DepthShadingTest, IsWhatDistancesSay) {
  auto plain = Engine::create(scene, configured({})), engine = Engine::create(scene, configured(kDepthShading));
  ASSERT_TRUE(plain && engine);
  const double pixel = 2.0 * std::tan(0.5 * kFovy) / kHeight, infinite = std::numeric_limits<double>::infinity();
  struct Case {
    core::Expected<core::View> view;
    double far, pixel;
  };
  for (const double turn : {0.3, 1.7, 4.0}) {
    const Case cases[] = {
        {core::View::perspective(around(turn), kFovy, kAspect, kNear), infinite, pixel},
        {core::View::perspective(around(turn), kFovy, kAspect, kNear, kFar), kFar, pixel},
        {core::View::orthographic(around(turn), kOrthoHeight, kAspect, kNear, kFar), kFar, kOrthoHeight / kHeight}};
    for (const Case& c : cases) {
      SCOPED_TRACE(testing::Message() << "turn " << turn << ", case " << &c - cases);
      ASSERT_TRUE(c.view);
      const image::Image before = image(*plain, *c.view), after = image(*engine, *c.view);
      const auto depth = engine->read_depth(*c.view);
      ASSERT_TRUE(depth);
      EXPECT_EQ(engine->read_ids()->ids, plain->read_ids()->ids);
      EXPECT_EQ(depth->metres, plain->read_depth(*c.view)->metres);
      const Twin twin(depth->metres, *c.view, c.far, c.pixel);
      int wrong = 0, darker = 0;
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const double factor = twin.factor(x, y, kDepthShading);
          darker += factor < 0.95;
          for (int channel = 0; channel < 3; ++channel) {
            const std::size_t i = 3 * std::size_t(y * kWidth + x) + std::size_t(channel);
            if (std::abs(before.pixels[i] * factor - after.pixels[i]) > 2.0) {
              ++wrong;
              break;
            }
          }
        }
      EXPECT_LE(wrong, kWidth * kHeight / 500);  // steps at a threshold
      EXPECT_GE(darker, kWidth * kHeight / 20);
    }
  }
}

/// However steep they are: parallel views look along the floor at one degree.
TEST_F(DepthShadingTest, LeavesPlanesAsTheyAre) {
  constexpr int kReach = 6;  // pixels around one that change it
  core::Scene floor;
  floor.add_primitive(floor.root(), core::Box{500.0f, 500.0f, 1.0f}, {});
  auto plain = Engine::create(floor, configured({})), engine = Engine::create(floor, configured({1.0f, 1.0f}));
  ASSERT_TRUE(plain && engine);
  for (const double height : {0.5, 1.0, 2.0})
    for (const bool orthographic : {false, true}) {
      SCOPED_TRACE(testing::Message() << height << (orthographic ? ", parallel" : ""));
      const core::dvec3 eye(-20.0, 3.0, 0.5 + height);
      const core::Pose pose{eye, eye + core::dvec3(1.0, 0.2, orthographic ? -0.02 : -0.2), {0, 0, 1}};
      const auto view = orthographic ? core::View::orthographic(pose, 2.0, kAspect, -200.0, 400.0)
                                     : core::View::perspective(pose, 0.6, kAspect, 0.1);
      ASSERT_TRUE(view);
      const image::Image before = image(*plain, *view), after = image(*engine, *view);
      const auto ids = plain->read_ids();
      ASSERT_TRUE(ids);
      int inside = 0;
      for (int y = kReach; y < kHeight - kReach; ++y)
        for (int x = 0; x < kWidth; ++x) {
          const auto all_floor = [&] {
            for (int j = -kReach; j <= kReach; ++j)
              for (int i = -kReach; i <= kReach; ++i)
                if (ids->ids[std::size_t((y + j) * kWidth + std::clamp(x + i, 0, kWidth - 1))] == 0) return false;
            return true;
          };
          if (!all_floor()) continue;
          ++inside;
          for (std::size_t i = 3 * std::size_t(y * kWidth + x), end = i + 3; i < end; ++i)
            ASSERT_NEAR(before.pixels[i], after.pixels[i], 1) << x << ", " << y;
        }
      EXPECT_GT(inside, kWidth * kHeight / 4);
    }
}

const auto kModes = drawing_modes({{"budget_splats", [](EngineConfig& c) {
                                      c.losses.budget_ms = 1e5;
                                      c.losses.contribution_mode = engine::ContributionMode::kPoints;
                                    }}});

class DepthShadingInAllModes : public DepthShadingTest, public testing::WithParamInterface<DrawingMode> {};
INSTANTIATE_TEST_SUITE_P(, DepthShadingInAllModes, testing::ValuesIn(kModes), name_of);

/// Moving, at rest, and with ghosts over it: as in an engine that begins with that frame.
TEST_P(DepthShadingInAllModes, IsTheSameInEachFrame) {
  auto engine = Engine::create(scene, configured(kDepthShading, GetParam().set));
  ASSERT_TRUE(engine);
  for (int frame = 0; frame < 6; ++frame) {
    SCOPED_TRACE(frame);
    if (frame == 4) {
      const std::array<core::ItemId, 3> ghosts{core::ItemId{5}, core::ItemId{700}, core::ItemId{1500}};
      ASSERT_TRUE(engine->set_override(ghosts, {.ghost = true}));
    }
    const auto view = core::View::perspective(around(0.4 * (frame / 2)), kFovy, kAspect, kNear);
    const image::Image seen = image(*engine, *view);
    EngineConfig fresh_config = configured(kDepthShading);
    fresh_config.drawing.samples = engine->config().drawing.samples;
    auto fresh = Engine::create(scene, fresh_config);
    ASSERT_TRUE(fresh);
    if (frame >= 4) {
      const std::array<core::ItemId, 3> ghosts{core::ItemId{5}, core::ItemId{700}, core::ItemId{1500}};
      ASSERT_TRUE(fresh->set_override(ghosts, {.ghost = true}));
    }
    EXPECT_EQ(image::compare(image(*fresh, *view), seen)->max, 0);
  }
}

/// Depth shading comes and goes without a new engine, and whatever else configure() may change.
TEST_P(DepthShadingInAllModes, ConfigureSwitchesIt) {
  auto engine = Engine::create(scene, configured({}, GetParam().set)),
       with = Engine::create(scene, configured(kDepthShading, GetParam().set));
  ASSERT_TRUE(engine && with);
  const auto view = core::View::perspective(around(1.0), kFovy, kAspect, kNear);
  const image::Image plain = image(*engine, *view), depth_shading = image(*with, *view);
  EXPECT_GT(image::compare(plain, depth_shading)->max, 50);
  EngineConfig changed = engine->config();
  changed.drawing.looks.depth_shading = kDepthShading;
  ASSERT_TRUE(engine->configure(changed));
  EXPECT_EQ(image::compare(image(*engine, *view), depth_shading)->max, 0);
  changed.drawing.looks.depth_shading = {};
  ASSERT_TRUE(engine->configure(changed));
  EXPECT_EQ(image::compare(image(*engine, *view), plain)->max, 0);
}

TEST_F(DepthShadingTest, ConfigureChangesWhatItSays) {
  auto engine = Engine::create(scene, configured({}));
  ASSERT_TRUE(engine);
  const auto view = core::View::perspective(around(1.0), kFovy, kAspect, kNear);
  const image::Image full = image(*engine, *view);
  EngineConfig changed = engine->config();
  changed.losses.min_projected_area = 1e9f;
  ASSERT_TRUE(engine->configure(changed));
  auto report = engine->frame(*view);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->items_drawn, 0);
  EXPECT_GT(report->below_min_area, 0);
  changed.losses.min_projected_area = 0.0f;
  changed.losses.budget_ms = 1e5;
  changed.culling.culler = CullerChoice::kLinear;
  ASSERT_TRUE(engine->configure(changed));
  EXPECT_EQ(image::compare(image(*engine, *view), full)->max, 0);
  EXPECT_EQ(engine->plan().culler, CullerChoice::kLinear);

  const EngineConfig good = engine->config();
  const auto refused = [&](auto&& change, const std::string& named) {
    EngineConfig bad = good;
    change(bad);
    const auto done = engine->configure(bad);
    ASSERT_FALSE(done);
    EXPECT_NE(done.error().message.find(named), std::string::npos) << done.error().message;
    EXPECT_EQ(engine->config().culling.culler, good.culling.culler);
    EXPECT_EQ(engine->config().drawing.looks.depth_shading.edge_lines, good.drawing.looks.depth_shading.edge_lines);
  };
  refused([](EngineConfig& c) { c.draw = false; }, "draw");
  refused([](EngineConfig& c) { c.width += 1; }, "size");
  refused([](EngineConfig& c) { c.drawing.samples = 4; }, "samples");
  refused([](EngineConfig& c) { c.context.application = nullptr; }, "context");
  refused([](EngineConfig& c) { c.drawing.looks.depth_shading.edge_lines = 1.5f; }, "edge_lines");
  refused([](EngineConfig& c) { c.drawing.looks.depth_shading.strength = std::nanf(""); }, "depth_shading");
  refused([](EngineConfig& c) { c.culling.culler = CullerChoice::kGpu; }, "culler");  // with a budget
  EXPECT_EQ(image::compare(image(*engine, *view), full)->max, 0);
}

}  // namespace
}  // namespace sightline::tests::depth_shading_test
