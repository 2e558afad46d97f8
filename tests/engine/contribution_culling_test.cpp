// Squares in the place of small items: their areas, which items have one, and what images show of them.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "sightline/culling/occlusion/internal/solid_areas.h"
#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/tests/culling/scenes.h"
#include "sightline/tests/support/gl_test.h"
#include "sightline/tests/support/simulated_gpu.h"

namespace sightline::engine::contribution_culling_test {
namespace {

using core::dvec3;
using core::ItemId;

constexpr int kSize = 512, kSide = 64;              // pixels; items along each side of the grid
constexpr double kHeight = 8.0;                     // of the view, metres
constexpr double kPixel = kHeight / double(kSize);  // metres
constexpr float kAll = 5e4f;                        // a contribution that no item here has

/// Diameter of the ball that shows so many pixels.
float diameter_of(double area) {
  return float(kPixel * std::sqrt(4.0 * area / std::numbers::pi));
}

class ContributionCullingTest : public tests::GlTest {
 protected:
  /// Balls on a grid eight pixels wide, up to half a pixel off it, each nearer than the one before.
  void fill(double area) {
    tests::Random random(3);
    for (int i = 0; i < kSide * kSide; ++i) {
      const dvec3 jitter = tests::point(random, 0.5 * kPixel);
      const dvec3 at(kPixel * (8.0 * (i % kSide) - 252.0), -1e-3 * i, kPixel * (8.0 * (i / kSide) - 252.0));
      balls_.push_back(scene_.add_primitive(scene_.root(), core::Sphere{diameter_of(area)},
                                            core::translation(at + jitter), i % 2 == 0 ? red_ : green_));
    }
  }
  core::Expected<Engine> engine(ContributionMode mode, float min_projected_area, int samples = 1,
                                OcclusionChoice occlusion = OcclusionChoice::kAutomatic, double budget_ms = 0.0) {
    EngineConfig config;
    config.draw = config.drawing.ids = true;
    config.culling.culler = CullerChoice::kCpu;
    config.width = config.height = kSize;
    config.drawing.samples = samples;
    config.culling.occlusion = occlusion;
    config.losses.min_projected_area = min_projected_area;
    config.losses.contribution_mode = mode;
    config.losses.budget_ms = budget_ms;
    config.context.application = &*context;
    return Engine::create(scene_, config);
  }
  static core::View view() {
    return *core::View::orthographic({{0, -10, 0}, {0, 0, 0}, {0, 0, 1}}, kHeight, 1.0, 0.0, 20.0);
  }
  /// Number of pixels of each item.
  static std::map<ItemId, int> pixels(Engine& engine) {
    std::map<ItemId, int> counts;
    const image::IdImage ids = *engine.read_ids();
    for (const std::uint32_t id : ids.ids)
      if (id != 0) ++counts[ItemId{id - 1}];
    return counts;
  }

  core::Scene scene_;
  core::MaterialId red_ = scene_.add_material({.name = "red", .colour = {0.9f, 0.1f, 0.1f}});
  core::MaterialId green_ = scene_.add_material({.name = "green", .colour = {0.1f, 0.9f, 0.1f}});
  std::vector<ItemId> balls_;
};

TEST_F(ContributionCullingTest, EachIsASquareOfItsAreaAtItsPlace) {
  fill(9.0);
  auto drawn = engine(ContributionMode::kPoints, kAll);
  ASSERT_TRUE(drawn);
  const auto report = drawn->frame(view());
  ASSERT_TRUE(report);
  EXPECT_EQ(report->below_min_area, kSide * kSide);
  EXPECT_EQ(report->splats, kSide * kSide);
  EXPECT_EQ(report->items_drawn, 0);
  const image::IdImage ids = *drawn->read_ids();
  const image::DepthImage depth = *drawn->read_depth(view());
  const image::Image colours = *drawn->read_colour();
  for (std::size_t i = 0; i < ids.ids.size(); ++i) {
    if (ids.ids[i] == 0) continue;
    const dvec3 centre = scene_.placement(ItemId{ids.ids[i] - 1}).origin;
    const double x = kPixel * (double(i % kSize) + 0.5 - 256.0), z = kPixel * (255.5 - double(i / kSize));
    ASSERT_LT(std::abs(x - centre.x), 1.51 * kPixel);
    ASSERT_LT(std::abs(z - centre.z), 1.51 * kPixel);
    ASSERT_NEAR(depth.metres[i], 10.0 + centre.y, 1e-4);
    ASSERT_EQ(colours.pixels[3 * i] > colours.pixels[3 * i + 1], ids.ids[i] % 2 == 1);
  }
  const std::map<ItemId, int> counts = pixels(*drawn);
  ASSERT_EQ(counts.size(), balls_.size());
  for (const auto& [item, count] : counts) ASSERT_EQ(count, 9) << to_index(item);
}

TEST_F(ContributionCullingTest, SplatsBetweenPixelCentresAreNotDrawn) {
  fill(0.25);
  auto drawn = engine(ContributionMode::kPoints, kAll);
  ASSERT_TRUE(drawn);
  const auto report = drawn->frame(view());
  ASSERT_TRUE(report);
  const auto shown = double(pixels(*drawn).size()), count = double(balls_.size());
  EXPECT_NEAR(shown, 0.25 * count, 4.0 * std::sqrt(0.25 * 0.75 * count));
  EXPECT_NEAR(double(report->splats), shown, 0.05 * count);  // a little more: the test is conservative
}

TEST_F(ContributionCullingTest, AShareOfThemKeepsTheArea) {
  fill(0.5);
  for (const float threshold : {2.0f, 4.0f, 16.0f}) {
    SCOPED_TRACE(threshold);
    auto drawn = engine(ContributionMode::kStochastic, threshold);
    ASSERT_TRUE(drawn && drawn->frame(view()));
    const std::map<ItemId, int> counts = pixels(*drawn);
    const double expected = 0.5 * double(balls_.size()), share = 0.5 / double(threshold);
    const double deviation = double(threshold) * std::sqrt(share * (1.0 - share) * double(balls_.size()));
    double covered = 0.0;
    for (const auto& [item, count] : counts) {
      covered += count;
      ASSERT_TRUE(in_share(item, float(share) * 1.001f)) << to_index(item);
    }
    EXPECT_NEAR(covered, expected, 4.0 * deviation);
  }
}

TEST_F(ContributionCullingTest, WithSeveralSamplesSmallSplatsDoNotGetLost) {
  fill(0.5);
  auto drawn = engine(ContributionMode::kPoints, kAll, 4), reference = engine(ContributionMode::kPoints, kAll);
  ASSERT_TRUE(drawn && reference && reference->frame(view()));
  const auto report = drawn->frame(view());
  ASSERT_TRUE(report);
  EXPECT_EQ(report->splats, kSide * kSide);
  // How far pixels are from the background in blue, in which all balls are the same.
  const auto changes = [](Engine& engine) {
    const image::Image colours = *engine.read_colour();
    std::vector<double> found;
    for (std::size_t i = 2; i < colours.pixels.size(); i += 3)
      found.push_back(std::abs(std::round(255.0 * 0.91) - colours.pixels[i]));
    return found;
  };
  const std::vector<double> covered = changes(*drawn), whole = changes(*reference);
  const double area =
      std::accumulate(covered.begin(), covered.end(), 0.0) / *std::max_element(whole.begin(), whole.end());
  EXPECT_NEAR(area, 0.5 * double(balls_.size()), 0.05 * 0.5 * double(balls_.size()));
}

TEST_F(ContributionCullingTest, SectionsCutThemAtTheirCentres) {
  fill(9.0);
  auto drawn = engine(ContributionMode::kPoints, kAll);
  ASSERT_TRUE(drawn);
  core::View cut = view();
  cut.sections = {{{1, 0, 0.3}, 0.2}};
  ASSERT_TRUE(drawn->frame(cut));
  const std::map<ItemId, int> counts = pixels(*drawn);
  for (const ItemId item : balls_) {
    const dvec3 centre = scene_.placement(item).origin;
    const double inside = centre.x + 0.3 * centre.z + 0.2;
    if (std::abs(inside) > 1e-4) {
      ASSERT_EQ(counts.contains(item), inside > 0.0) << to_index(item);
    }
  }
}

/// Squares that are known to be hidden are not drawn, and the image is that of drawing all.
TEST_F(ContributionCullingTest, HiddenOnesAreLeftOut) {
  fill(9.0);
  scene_.add_primitive(scene_.root(), core::Box{4.0f, 0.5f, 8.0f}, core::translation({-2.0, -2.0, 0.0}));
  auto tested = engine(ContributionMode::kPoints, kAll, 1, OcclusionChoice::kOn);
  auto all = engine(ContributionMode::kPoints, kAll, 1, OcclusionChoice::kOff);
  ASSERT_TRUE(tested && all);
  for (const double aside : {0.0, 1.5}) {
    const core::View from = *core::View::perspective({{aside, -10, 0}, {0, 0, 0}, {0, 0, 1}}, 0.8, 1.0, 0.1);
    for (const core::View& seen : {view(), from}) {
      const auto few = tested->frame(seen), many = all->frame(seen);
      ASSERT_TRUE(few && many);
      EXPECT_LT(few->splats, many->splats * 9 / 10);
      EXPECT_EQ(tested->read_ids()->ids, all->read_ids()->ids);
      EXPECT_EQ(tested->read_colour()->pixels, all->read_colour()->pixels);
    }
  }
}

/// So are those behind other splats. Each pixel shows the nearest splat that holds its centre.
TEST_F(ContributionCullingTest, HideEachOther) {
  constexpr int kCount = 3000, kFirst = 200, kLast = 311;  // pixels to look at
  tests::Random random(11);
  for (int i = 0; i < kCount; ++i) {
    const dvec3 at = tests::point(random, 0.6);
    scene_.add_primitive(scene_.root(), core::Sphere{diameter_of(tests::uniform(random, 1.0, 60.0))},
                         core::translation(at), i % 2 == 0 ? red_ : green_);
  }
  std::vector<std::pair<dvec3, double>> squares;  // centre, half the side
  for (ItemId item{0}; to_index(item) < kCount; ++item) {
    const double diameter = std::get<core::Sphere>(scene_.primitive(item)).diameter;
    squares.emplace_back(scene_.placement(item).origin, 0.5 * std::sqrt(0.25 * std::numbers::pi) * diameter);
  }
  for (const int cuts : {0, 1}) {
    SCOPED_TRACE(cuts);
    auto drawn = engine(ContributionMode::kPoints, kAll);
    ASSERT_TRUE(drawn);
    core::View cut = view();
    if (cuts == 1) cut.sections = {{{0, 1, 0}, 0.0}};  // removes what is nearer, which then hides nothing
    const auto report = drawn->frame(cut);
    ASSERT_TRUE(report);
    EXPECT_LT(report->splats, cuts == 0 ? kCount / 2 : kCount);
    // The item of each pixel, of splats that are nearest by a clear lead.
    const image::IdImage ids = *drawn->read_ids();
    int compared = 0;
    for (int y = kFirst; y <= kLast; ++y)
      for (int x = kFirst; x <= kLast; ++x) {
        const double px = kPixel * (x + 0.5 - 0.5 * kSize), pz = kPixel * (0.5 * kSize - 0.5 - y);
        double nearest = 1e9, second = 1e9;
        ItemId front_item = core::kNoItem;
        bool clear = true;
        for (ItemId item{0}; to_index(item) < kCount; ++item) {
          const auto& [centre, half] = squares[to_index(item)];
          if (cuts == 1 && centre.y < 0.0) continue;
          const double off = std::max(std::abs(px - centre.x), std::abs(pz - centre.z)) - half;
          if (std::abs(off) < 0.02 * kPixel) clear = false;
          if (off >= 0.0) continue;
          second = std::min(second, std::max(centre.y, nearest));
          if (centre.y < nearest) nearest = centre.y, front_item = item;
        }
        if (!clear || (front_item != core::kNoItem && second - nearest < 2e-3)) continue;
        ASSERT_EQ(ids.ids[std::size_t(y * kSize + x)], front_item == core::kNoItem ? 0 : to_index(front_item) + 1)
            << x << ' ' << y;
        ++compared;
      }
    EXPECT_GT(compared, 2000);
  }
}

/// What a budget does not suffice for is a splat each, in a frame of a moving view and while a view at rest is
/// completed. What is drawn in full has none.
TEST_F(ContributionCullingTest, AreDrawnForWhatABudgetDoesNotSufficeFor) {
  const tests::SimulatedGpu gpu(*context, {});  // software rasterisers draw coarser images instead
  fill(9.0);
  for (const ContributionMode mode : {ContributionMode::kPoints, ContributionMode::kStochastic}) {
    SCOPED_TRACE(name_of(mode));
    auto drawn = engine(mode, 0.0f, 1, OcclusionChoice::kAutomatic, 1e-3);
    ASSERT_TRUE(drawn);
    const std::size_t memory = drawn->memory().gpu;
    auto report = drawn->frame(view());
    ASSERT_TRUE(report);
    EXPECT_GT(report->items_drawn, 0);
    EXPECT_GT(report->splats, kSide * kSide / 2);
    EXPECT_EQ(report->items_drawn + report->splats, kSide * kSide);
    EXPECT_EQ(report->pending, report->splats);
    EXPECT_EQ(pixels(*drawn).size(), balls_.size());
    report = drawn->frame(view());
    ASSERT_TRUE(report);
    EXPECT_GE(drawn->memory().gpu, memory + kSize * kSize * 12) << "a second image, for views that stay";
    EXPECT_EQ(report->pending, report->splats);
    EXPECT_EQ(report->items_drawn + report->splats, kSide * kSide);
    for (const auto& [item, count] : pixels(*drawn)) ASSERT_NEAR(count, 9, 4) << to_index(item);
  }
}

TEST_F(ContributionCullingTest, FollowEdits) {
  fill(9.0);
  auto drawn = engine(ContributionMode::kPoints, kAll);
  ASSERT_TRUE(drawn && drawn->frame(view()));
  const ItemId larger = balls_[100], moved = balls_[200], removed = balls_[300];
  core::Affine place = scene_.placement(larger);
  place.linear *= 2.0;
  scene_.set_placement(larger, place);
  place = scene_.placement(moved);
  place.origin.x += 4.0 * kPixel;
  scene_.set_placement(moved, place);
  scene_.remove_item(removed);
  const ItemId added =
      scene_.add_primitive(scene_.root(), core::Sphere{diameter_of(25.0)}, core::translation({0.0, -9.0, 0.0}), red_);
  ASSERT_TRUE(drawn->commit());
  ASSERT_TRUE(drawn->frame(view()));
  std::map<ItemId, int> counts = pixels(*drawn);
  EXPECT_EQ(counts[larger], 36);
  EXPECT_EQ(counts[moved], 9);
  EXPECT_EQ(counts.contains(removed), false);
  EXPECT_EQ(counts[added], 25);
  ASSERT_TRUE(drawn->rebuild());  // another order of the items
  ASSERT_TRUE(drawn->frame(view()));
  EXPECT_EQ(pixels(*drawn)[larger], 36);
}

TEST_F(ContributionCullingTest, CostNothingWhileNoneIsDrawn) {
  fill(9.0);
  auto plain = engine(ContributionMode::kDrop, 1.0f), points = engine(ContributionMode::kPoints, 1.0f);
  ASSERT_TRUE(plain && points);
  ASSERT_TRUE(plain->frame(view()) && points->frame(view()));
  EXPECT_EQ(points->memory().gpu, plain->memory().gpu);
  auto used = engine(ContributionMode::kPoints, kAll);
  ASSERT_TRUE(used && used->frame(view()));
  EXPECT_GT(used->memory().gpu, plain->memory().gpu);
}

// --- without GL ----------------------------------------------------------------------------------------------------

TEST(ContributionCulling, AreaIsAQuarterOfTheSurface) {
  const core::Primitive kinds[] = {core::Cylinder{0.5f, 1.2f},
                                   core::Snout{0.6f, 0.3f, 1, 0, 0, 0, 0, 0, 0},
                                   core::CircularTorus{0.5f, 0.25f, 4},
                                   core::CircularTorus{0.5f, 0.25f, float(core::kFullTurn)},
                                   core::Sphere{1.1f},
                                   core::EllipticalDish{0.6f, 0.2f},
                                   core::SphericalDish{0.6f, 0.3f},
                                   core::RectangularTorus{0.3f, 0.7f, 0.5f, 4},
                                   core::RectangularTorus{0.3f, 0.7f, 0.5f, float(core::kFullTurn)},
                                   core::Pyramid{1, 1.5f, 0.5f, 0.4f, 0.1f, -0.3f, 1},
                                   core::Box{0.9f, 0.8f, 1}};
  core::Affine place = core::translation({3, 4, 5});
  place.linear = 0.5 * core::dmat3(0, 1, 0, -1, 0, 0, 0, 0, 1);
  for (const core::Primitive& primitive : kinds) {
    const core::Mesh mesh = gpuprims::tessellate(primitive, {.fixed_segments = 96});
    double sum = 0.0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
      const auto at = [&](std::size_t k) { return dvec3(mesh.positions[mesh.indices[i + k]]); };
      sum += 0.5 * glm::length(glm::cross(at(1) - at(0), at(2) - at(0)));
    }
    core::Scene scene;
    const ItemId item = scene.add_primitive(scene.root(), primitive, place);
    const ItemId triangles = scene.add_mesh_instance(scene.root(), scene.add_mesh(mesh).value(), place);
    const core::Snapshot snapshot(scene);
    for (const ItemId i : {item, triangles})
      EXPECT_NEAR(culling::mean_projected_area(snapshot, snapshot.slot(i)), 0.25 * 0.25 * sum, 0.015 * 0.0625 * sum)
          << core::name_of(core::kind_of(primitive));
  }
}

TEST(ContributionCulling, SharesAreEvenAndNested) {
  constexpr int kCount = 100'000;
  for (const double share : {0.0, 0.01, 0.3, 0.5, 0.99, 1.0}) {
    int kept = 0;
    for (ItemId item{0}; to_index(item) < kCount; ++item) {
      kept += in_share(item, float(share));
      ASSERT_TRUE(!in_share(item, float(0.5 * share)) || in_share(item, float(share)));
    }
    EXPECT_NEAR(kept, share * kCount, 4.0 * std::sqrt(share * (1.0 - share) * kCount)) << share;
  }
}

}  // namespace
}  // namespace sightline::engine::contribution_culling_test
