// The lines that show a frozen camera's culling, against points thrown into the view volume and against the boxes.
#include "sightline/apps/view/culling_boxes.h"

#include <cmath>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "sightline/engine/engine.h"

namespace sightline::tests::culling_boxes_test {
namespace {

using apps::CullingBoxes;
using apps::CullingLine;
using apps::CullingSwitches;
using apps::FrozenCamera;
using apps::WorldLine;
using core::dvec3;
using culling::CullState;
using Part = WorldLine::Part;

constexpr int kWidth = 200, kHeight = 100;

image::DepthImage depth_of(float metres) {
  return {kWidth, kHeight, std::vector<float>(std::size_t(kWidth) * kHeight, metres)};
}

double margin(const core::Plane& plane, const dvec3& p) {
  return core::evaluate(plane, p) / glm::length(plane.normal);
}

/// A grid of boxes, and a camera that looks along y.
class CullingBoxesTest : public testing::Test {
 protected:
  CullingBoxesTest() {
    for (int i = 0; i < 20 * 20 * 20; ++i)
      scene_.add_primitive(scene_.root(), core::Box{0.4f, 0.4f, 0.4f},
                           core::translation({i % 20, i / 20 % 20, i / 400}));
    engine_ = std::make_unique<engine::Engine>(std::move(*engine::Engine::create(scene_)));
    reach_ = engine_->snapshot().bounds().world_bounds();
  }
  core::dvec3 origin() const { return engine_->snapshot().bounds().origin; }
  FrozenCamera frozen(const core::View& view) {
    FrozenCamera camera(view);
    EXPECT_TRUE(camera.follow(*engine_, view.sections, 0));
    return camera;
  }
  static core::View view(const dvec3& eye, const dvec3& target) {
    return *core::View::perspective({eye, target, {0, 0, 1}}, 0.6, double(kWidth) / kHeight, 0.1);
  }

  core::Scene scene_;
  std::unique_ptr<engine::Engine> engine_;
  core::AabbD reach_;
};

/// Every line of the outline lies on the volume's border, in what the sections keep or cut away as it says.
TEST_F(CullingBoxesTest, OutlinesLieOnTheBorder) {
  std::mt19937_64 random(5);
  const auto any = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  int cut = 0, sections = 0;
  for (int round = 0; round < 300; ++round) {
    SCOPED_TRACE(round);
    const core::Pose pose{{any(-30, 40), any(-30, 40), any(-30, 40)}, {any(0, 20), any(0, 20), any(0, 20)}, {0, 0, 1}};
    auto view = round % 3 == 0   ? core::View::orthographic(pose, any(1, 40), 2.0, any(-20, 0), any(1, 60))
                : round % 3 == 1 ? core::View::perspective(pose, any(0.2, 2.0), 2.0, 0.1, any(1, 100))
                                 : core::View::perspective(pose, any(0.2, 2.0), 2.0, 0.1);
    ASSERT_TRUE(view);
    for (int i = round % 4; i > 0; --i) {
      const dvec3 normal(any(-1, 1), any(-1, 1), any(-1, 1));
      view->sections.push_back({normal, -glm::dot(normal, dvec3(any(0, 20), any(0, 20), any(0, 20)))});
    }
    const auto lines = apps::outline(*view, reach_);
    ASSERT_GE(lines.size(), 12u);
    const auto planes = core::frustum_planes(view->clip_from_world(), view->clip_depth());
    for (const WorldLine& line : lines) {
      ASSERT_TRUE(std::isfinite(glm::length(line.from)) && std::isfinite(glm::length(line.to)));
      const dvec3 middle = 0.5 * (line.from + line.to);
      const double doubt = 1e-6 * (glm::length(line.from) + glm::length(line.to) + 1.0);
      int on_sides = 0, on_sections = 0;
      bool outside = false;
      for (int i = 0; i < core::kFrustumPlaneCount; ++i) {
        if (planes[std::size_t(i)].normal == dvec3(0.0)) continue;
        const double m = margin(planes[std::size_t(i)], middle);
        EXPECT_GE(m, -doubt);
        on_sides += std::abs(m) <= doubt;
      }
      for (const core::Plane& section : view->sections) {
        outside |= margin(section, middle) < -doubt;
        on_sections += std::abs(margin(section, middle)) <= doubt;
      }
      if (line.part == Part::kKept) {
        EXPECT_FALSE(outside);
      }
      if (line.part == Part::kCut) {
        EXPECT_TRUE(outside || on_sections > 0 || glm::length(line.from - line.to) < 1e-3);
        ++cut;
      }
      if (line.part == Part::kSection) {
        EXPECT_FALSE(outside);
        EXPECT_GE(on_sections, 1);
        ++sections;
      } else {
        EXPECT_GE(on_sides, 1) << "the far end may lie before the far plane";
      }
    }
  }
  EXPECT_GT(cut, 100);
  EXPECT_GT(sections, 100);
}

/// What is kept of the edges is as long as what points along them say.
TEST_F(CullingBoxesTest, EdgesAreKeptWhereAllSectionsKeepThem) {
  std::mt19937_64 random(6);
  const auto any = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  for (int round = 0; round < 100; ++round) {
    core::View cut = view({10, -20, 10}, {10, 10, 10});
    const auto edges = apps::outline(cut, reach_);
    ASSERT_EQ(edges.size(), 12u);
    for (int i = 0; i < 3; ++i) {
      const dvec3 normal(any(-1, 1), any(-1, 1), any(-1, 1));
      cut.sections.push_back({normal, -glm::dot(normal, dvec3(any(0, 20), any(-20, 20), any(0, 20)))});
    }
    double expected = 0.0, kept = 0.0, all = 0.0;
    for (const WorldLine& edge : edges) {
      constexpr int kPoints = 2000;
      const double length = glm::length(edge.to - edge.from);
      all += length;
      for (int i = 0; i < kPoints; ++i) {
        const dvec3 p = edge.from + (edge.to - edge.from) * ((i + 0.5) / kPoints);
        bool inside = true;
        for (const core::Plane& section : cut.sections) inside &= core::evaluate(section, p) >= 0.0;
        expected += inside ? length / kPoints : 0.0;
      }
    }
    double of_all = 0.0;
    for (const WorldLine& line : apps::outline(cut, reach_)) {
      if (line.part == Part::kKept) kept += glm::length(line.to - line.from);
      if (line.part != Part::kSection) of_all += glm::length(line.to - line.from);
    }
    EXPECT_NEAR(kept, expected, 0.01 * all) << "round " << round;
    EXPECT_NEAR(of_all, all, 1e-6 * all);
  }
}

TEST_F(CullingBoxesTest, DrawsTheBoxesOfStatesThatAreOn) {
  const FrozenCamera camera = frozen(view({10, -5, 10}, {10, 10, 10}));
  const core::View aside = view({-40, -20, 30}, {10, 10, 10});
  for (const bool orthographic : {false, true}) {
    const core::View seen =
        orthographic ? *core::View::orthographic({{-40, -20, 30}, {10, 10, 10}, {0, 0, 1}}, 60.0, 2.0, 0.1, 200.0)
                     : aside;
    for (int state = 0; state < culling::kCullStateCount; ++state) {
      CullingSwitches switches;
      switches.states = {};
      switches.states[std::size_t(state)] = true;
      CullingBoxes boxes;
      boxes.update(seen, depth_of(1e9f), camera, origin(), reach_, switches);
      std::size_t expected = 0;
      for (const culling::CullBox& box : camera.states()->boxes) expected += box.state == CullState(state);
      EXPECT_EQ(boxes.wanted(), expected) << "all are in the image";
      EXPECT_EQ(boxes.drawn(), std::min(expected, CullingBoxes::kMost));
      for (const CullingLine& line : boxes.lines()) {
        EXPECT_TRUE(line.ink == state || line.ink >= CullingLine::kVolume);
        EXPECT_FALSE(line.behind);
        for (const core::dvec2& at : {line.from, line.to}) {
          EXPECT_TRUE(at.x >= -1e-6 && at.x <= kWidth + 1e-6 && at.y >= -1e-6 && at.y <= kHeight + 1e-6)
              << at.x << " " << at.y;
        }
      }
      EXPECT_EQ(expected > 0, std::any_of(boxes.lines().begin(), boxes.lines().end(),
                                          [&](const CullingLine& line) { return line.ink == state; }));
    }
  }
  CullingBoxes boxes;
  boxes.update(aside, depth_of(1e9f), camera, origin(), reach_, {.boxes = false});
  EXPECT_TRUE(boxes.lines().empty());
}

/// The largest of many boxes are drawn, and how many there are is told.
TEST_F(CullingBoxesTest, DrawsTheLargestOfMany) {
  const FrozenCamera camera = frozen(view({10, -5, 10}, {10, 10, 10}));
  CullingSwitches switches;
  switches.states.fill(true);
  CullingBoxes boxes;
  boxes.update(view({-30, -30, 40}, {10, 10, 10}), depth_of(1e9f), camera, origin(), reach_, switches);
  ASSERT_GT(camera.states()->boxes.size(), CullingBoxes::kMost);
  EXPECT_EQ(boxes.wanted(), camera.states()->boxes.size());
  EXPECT_EQ(boxes.drawn(), CullingBoxes::kMost);
  // From within, most boxes are behind the eye.
  boxes.update(view({10, 10, 19}, {10, 10, 40}), depth_of(1e9f), camera, origin(), reach_, switches);
  EXPECT_LT(boxes.wanted(), camera.states()->boxes.size() / 2);
}

/// A wall at a distance: what is nearer is drawn in front of it, what is farther behind.
TEST_F(CullingBoxesTest, KnowsWhatTheImageHides) {
  const FrozenCamera camera = frozen(view({10, -200, 10}, {10, 10, 10}));
  const core::View aside = view({10, -30, 10}, {10, 10, 10});
  CullingBoxes boxes;
  double in_front[3], behind[3];
  int i = 0;
  for (const float wall : {1.0f, 40.0f, 1000.0f}) {
    boxes.update(aside, depth_of(wall), camera, origin(), reach_, {});
    in_front[i] = behind[i] = 0.0;
    for (const CullingLine& line : boxes.lines())
      (line.behind ? behind : in_front)[i] += glm::length(line.to - line.from);
    ++i;
  }
  EXPECT_LT(in_front[0], 0.02 * behind[0]) << "but for the view volume's lines that pass the eye";
  EXPECT_GT(in_front[1], 0.1 * behind[1]);
  EXPECT_GT(behind[1], 0.1 * in_front[1]);
  EXPECT_EQ(behind[2], 0.0);
  EXPECT_NEAR(in_front[0] + behind[0], in_front[2], 1e-3 * in_front[2]);
  EXPECT_NEAR(in_front[1] + behind[1], in_front[2], 1e-3 * in_front[2]);
}

/// It asks the engine again where something that matters has changed, and only then.
TEST_F(CullingBoxesTest, AFrozenCameraFollowsSectionsAndWhatIsShown) {
  FrozenCamera camera(view({10, -20, 10}, {10, 10, 10}));
  EXPECT_EQ(camera.states(), nullptr);
  EXPECT_EQ(camera.version(), 0u);
  std::set<std::uint64_t> versions{0};
  const auto is_new = [&] { return versions.insert(camera.version()).second; };
  ASSERT_TRUE(camera.follow(*engine_, {}, 0));
  EXPECT_TRUE(is_new());
  ASSERT_TRUE(camera.follow(*engine_, {}, 0));
  EXPECT_FALSE(is_new());
  const auto outside = [&] { return camera.states()->items[std::size_t(CullState::kOutside)]; };
  const std::int64_t before = outside();
  ASSERT_TRUE(camera.follow(*engine_, {{{0, 0, 1}, -10.0}}, 0));
  EXPECT_TRUE(is_new());
  EXPECT_GT(outside(), before + 3000);
  EXPECT_EQ(camera.view().sections.size(), 1u);
  const std::vector<core::ItemId> some{core::ItemId{0}, core::ItemId{1}, core::ItemId{2}};
  ASSERT_TRUE(engine_->hide(some));
  ASSERT_TRUE(camera.follow(*engine_, {}, 1));
  EXPECT_TRUE(is_new());
  std::int64_t all = 0;
  for (const std::int64_t of_state : camera.states()->items) all += of_state;
  EXPECT_EQ(all, 8000 - 3);
  camera.forget();
  ASSERT_TRUE(camera.follow(*engine_, {}, 1));
  EXPECT_TRUE(is_new());
}

}  // namespace
}  // namespace sightline::tests::culling_boxes_test
