// What is drawn over the finished image: ghosts, blended transparency, outlines.
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/gl/external_target.h"
#include "sightline/tests/engine/drawing_modes.h"

namespace sightline::tests::overlays_test {
namespace {

using core::ItemId;
using engine::CullerChoice;
using engine::Engine;
using engine::EngineConfig;
using engine::Transparency;

class OverlaysTest : public DrawnGrid {
 protected:
  static constexpr int kWidth = 192, kHeight = 128;

  void SetUp() override {
    DrawnGrid::SetUp();
    fill(scene, 14);
  }
  EngineConfig configured(void (*set)(EngineConfig&)) {
    EngineConfig c = config(CullerChoice::kCpu, kWidth, kHeight);
    c.drawing.ids = true;
    set(c);
    return c;
  }
  static core::View around(double turn) {
    const core::dvec3 centre(7.0), eye = centre + 15.0 * core::dvec3(std::cos(turn), std::sin(turn), 0.2);
    return *core::View::perspective({eye, centre, {0, 0, 1}}, 0.8, 1.5, 0.1);
  }
  struct Image {
    image::Image colour;
    std::vector<std::uint32_t> ids;
    std::vector<float> depth;
    bool has_ids(ItemId item) const { return std::find(ids.begin(), ids.end(), to_index(item) + 1) != ids.end(); }
  };
  static Image image(Engine& engine, const core::View& view) {
    if (!draw_complete(engine, view)) return {};
    return {*engine.read_colour(), engine.read_ids()->ids, engine.read_depth(view)->metres};
  }
  /// The largest difference of a channel.
  static int difference(const image::Image& a, const image::Image& b) { return image::compare(a, b)->max; }

  core::Scene scene;
};

const auto kModes = drawing_modes({{"budget_splats", [](EngineConfig& c) {
                                      c.losses.budget_ms = 1e5;
                                      c.losses.contribution_mode = engine::ContributionMode::kPoints;
                                    }}});

class OverlaysInAllModes : public OverlaysTest, public testing::WithParamInterface<DrawingMode> {};
INSTANTIATE_TEST_SUITE_P(, OverlaysInAllModes, testing::ValuesIn(kModes), name_of);

/// Ids and depth are those of the image without ghosts, whose colours shine through, however many ghosts there are.
TEST_P(OverlaysInAllModes, GhostsHideNothing) {
  auto engine = Engine::create(scene, configured(GetParam().set)),
       without = Engine::create(scene, configured(GetParam().set)),
       reference = Engine::create(scene, configured([](EngineConfig&) {}));
  ASSERT_TRUE(engine && without && reference);
  std::vector<ItemId> ghosts;
  for (ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (to_index(item) % 14 > 2) ghosts.push_back(item);
  ASSERT_TRUE(engine->set_override(ghosts, {.ghost = true}) && without->hide(ghosts));
  ASSERT_TRUE(reference->set_override(ghosts, {.ghost = true}));
  for (int frame = 0; frame < 6; ++frame) {
    SCOPED_TRACE(frame);
    const core::View view = around(0.2 * (frame / 2));  // each twice: a budget goes on
    const Image with = image(*engine, view), bare = image(*without, view);
    EXPECT_EQ(with.ids, bare.ids);
    EXPECT_EQ(with.depth, bare.depth);
    EXPECT_GT(difference(with.colour, bare.colour), 20);
    EXPECT_LE(difference(with.colour, bare.colour), 128) << "half of the light passes";
    if (GetParam().name != std::string("samples")) {
      EXPECT_EQ(difference(with.colour, image(*reference, view).colour), 0) << "as any other culler's";
    }
  }
  ASSERT_TRUE(engine->clear_overrides() && without->show_all());
  EXPECT_EQ(difference(image(*engine, around(1)).colour, image(*without, around(1)).colour), 0);
}

TEST_P(OverlaysInAllModes, BlendedItemsHideNothing) {
  const auto set = [](EngineConfig& c) { c.drawing.transparency = Transparency::kBlended; };
  EngineConfig c = configured(GetParam().set);
  set(c);
  const core::MaterialId glass = scene.add_material({"", {0.2f, 0.4f, 0.9f}, 0.4f});
  for (ItemId item{0}; to_index(item) < scene.item_slots(); item = ItemId{to_index(item) + 5})
    scene.set_material(item, glass);
  auto engine = Engine::create(scene, c), without = Engine::create(scene, configured(GetParam().set)),
       reference = Engine::create(scene, configured(set));
  ASSERT_TRUE(engine && without && reference);
  std::vector<ItemId> clear, faded;
  for (ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
    if (to_index(item) % 5 == 0) {
      clear.push_back(item);
    } else if (to_index(item) % 5 < 4 && to_index(item) % 14 > 2) {
      clear.push_back(item);
      faded.push_back(item);
    }
  for (Engine* e : {&*engine, &*reference}) ASSERT_TRUE(e->set_override(faded, {.alpha = 0.5f}));
  ASSERT_TRUE(without->hide(clear));
  for (int frame = 0; frame < 4; ++frame) {
    SCOPED_TRACE(frame);
    const core::View view = around(0.2 * (frame / 2));
    const Image with = image(*engine, view), bare = image(*without, view);
    EXPECT_EQ(with.ids, bare.ids);
    EXPECT_EQ(with.depth, bare.depth);
    EXPECT_GT(difference(with.colour, bare.colour), 50);
    if (GetParam().name != std::string("samples")) {  // sums in another order differ in their last bits
      EXPECT_LE(difference(with.colour, image(*reference, view).colour), 1);
    }
  }
  scene.update_material(glass, {"", {0.2f, 0.4f, 0.9f}, 1.0f});
  ASSERT_TRUE(engine->commit() && engine->clear_overrides() && without->commit() && without->show_all());
  const Image opaque = image(*engine, around(1)), wanted = image(*without, around(1));
  EXPECT_EQ(opaque.ids, wanted.ids);
  EXPECT_EQ(difference(opaque.colour, wanted.colour), 0);
}

/// One surface in front of an opaque one is exact but for rounding to 8 bits three times: alpha times its colour over
/// what is behind.
TEST_F(OverlaysTest, OneBlendedSurfaceIsExact) {
  core::Scene two;
  const core::MaterialId front = two.add_material({"", {0.9f, 0.2f, 0.1f}, 0.35f});
  two.add_primitive(two.root(), core::Box{4, 4, 0.1f}, core::translation({7, 7, 7}), front);
  two.add_primitive(two.root(), core::Sphere{3.0f}, core::translation({7, 7, 4}));
  const core::View view = *core::View::perspective({{7, 6, 15}, {7, 7, 7}, {0, 1, 0}}, 0.8, 1.5, 0.1);
  for (const int samples : {1, 4}) {
    EngineConfig c = configured([](EngineConfig& e) { e.drawing.transparency = Transparency::kBlended; });
    c.drawing.samples = samples;
    auto engine = Engine::create(two, c);
    ASSERT_TRUE(engine);
    const Image blended = image(*engine, view);
    const ItemId pane{0};
    ASSERT_TRUE(engine->hide({&pane, 1}));
    const Image behind = image(*engine, view);
    two.update_material(front, {"", {0.9f, 0.2f, 0.1f}, 1.0f});
    ASSERT_TRUE(engine->show_all() && engine->commit());
    const Image opaque = image(*engine, view);
    two.update_material(front, {"", {0.9f, 0.2f, 0.1f}, 0.35f});
    int seen = 0;
    for (std::size_t i = 0; i < blended.ids.size(); ++i) {
      if (samples > 1 && opaque.ids[i] != 1) continue;  // edges: one sample's id
      const bool covered = opaque.ids[i] == 1;
      seen += covered;
      for (std::size_t channel = 3 * i; channel < 3 * i + 3 && samples == 1; ++channel) {
        const double alpha = covered ? 0.35 : 0.0;
        const double wanted = alpha * opaque.colour.pixels[channel] + (1.0 - alpha) * behind.colour.pixels[channel];
        ASSERT_NEAR(blended.colour.pixels[channel], wanted, 1.6) << "pixel " << i;
      }
    }
    EXPECT_GT(seen, 3000);
  }
}

/// Against surfaces that are sorted exactly, each drawn alone.
TEST_F(OverlaysTest, ManyBlendedSurfacesAreNearSortedOnes) {
  const unsigned seed = 3;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const auto unit = [&] { return std::uniform_real_distribution<float>(0.0f, 1.0f)(random); };
  core::Scene panes;
  constexpr int kPanes = 6;
  core::MaterialId looks[kPanes];
  for (int i = 0; i < kPanes; ++i) {
    looks[i] = panes.add_material({"", {unit(), unit(), unit()}, 0.3f});
    panes.add_primitive(panes.root(), core::Sphere{5.0f},
                        core::translation({5.0f + 4.0f * unit(), 5.0f + 4.0f * unit(), 2.0 + 2.0 * i}), looks[i]);
  }
  const core::View view = *core::View::perspective({{7, 6, 22}, {7, 7, 7}, {0, 1, 0}}, 0.6, 1.5, 0.1);
  auto engine =
      Engine::create(panes, configured([](EngineConfig& e) { e.drawing.transparency = Transparency::kBlended; }));
  ASSERT_TRUE(engine);
  const Image blended = image(*engine, view);
  std::vector<Image> alone;
  std::vector<ItemId> all(kPanes);
  for (ItemId i{0}; to_index(i) < kPanes; ++i) all[to_index(i)] = i;
  for (int i = 0; i < kPanes; ++i) {
    auto look = panes.material(looks[i]);
    look.alpha = 1.0f;
    panes.update_material(looks[i], look);
  }
  ASSERT_TRUE(engine->commit());
  for (ItemId i{0}; to_index(i) < kPanes; ++i) {
    ASSERT_TRUE(engine->hide(all) && engine->show({&i, 1}));
    alone.push_back(image(*engine, view));
  }
  const auto background = alone[0].colour.pixels;  // in a corner
  double sum = 0.0, most = 0.0;
  int layered = 0;
  for (std::size_t pixel = 0; pixel < blended.ids.size(); ++pixel) {
    std::vector<std::pair<float, int>> layers;
    for (int i = 0; i < kPanes; ++i)
      if (alone[std::size_t(i)].ids[pixel] != 0) layers.emplace_back(alone[std::size_t(i)].depth[pixel], i);
    std::sort(layers.rbegin(), layers.rend());
    layered += layers.size() > 2;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      double wanted = background[channel];
      for (const auto& [depth, i] : layers)
        wanted += 0.3 * (alone[std::size_t(i)].colour.pixels[3 * pixel + channel] - wanted);
      const double error = std::abs(wanted - blended.colour.pixels[3 * pixel + channel]);
      if (layers.size() < 2) {
        ASSERT_LE(error, 1.6);
      }
      sum += error;
      most = std::max(most, error);
    }
  }
  EXPECT_GT(layered, 3000);
  RecordProperty("mean", std::to_string(sum / double(3 * blended.ids.size())));
  RecordProperty("max", std::to_string(most));
  EXPECT_LE(most, 40.0);
  EXPECT_LE(sum / double(3 * blended.ids.size()), 4.0);
}

/// Two pixels around the item: full where it is in front, fainter where it is hidden.
TEST_F(OverlaysTest, OutlinesSurroundWhatIsSeen) {
  for (const bool ghost : {false, true}) {
    core::Scene few;
    few.add_primitive(few.root(), core::Box{2, 2, 0.2f}, core::translation({7, 7, 7}));
    few.add_primitive(few.root(), core::Box{1.2f, 4, 0.2f}, core::translation({6.2, 7, 8}));
    const core::View view = *core::View::perspective({{7, 6.5, 15}, {7, 7, 7}, {0, 1, 0}}, 0.6, 1.5, 0.1);
    EngineConfig c = configured([](EngineConfig&) {});
    c.drawing.outline_colour = {0.0f, 0.0f, 0.0f};
    auto engine = Engine::create(few, c);
    ASSERT_TRUE(engine);
    const ItemId outlined{0}, before = ItemId{1};
    ASSERT_TRUE(engine->hide({&before, 1}));
    const Image alone = image(*engine, view);
    ASSERT_TRUE(engine->show_all() && engine->set_override({&outlined, 1}, {.ghost = ghost}));
    const Image bare = image(*engine, view);
    ASSERT_TRUE(engine->set_override({&outlined, 1}, {.outline = true, .ghost = ghost}));
    const Image lined = image(*engine, view);
    EXPECT_EQ(lined.ids, bare.ids);
    int full = 0, faint = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        bool near = false, near_open = false;
        for (int v = std::max(0, y - 2); v <= std::min(kHeight - 1, y + 2); ++v)
          for (int u = std::max(0, x - 2); u <= std::min(kWidth - 1, x + 2); ++u) {
            if ((u - x) * (u - x) + (v - y) * (v - y) > 5) continue;
            const std::size_t at = std::size_t(v * kWidth + u);
            near |= alone.ids[at] == 1;
            near_open |= alone.ids[at] == 1 && bare.ids[at] != 2;
          }
        const std::size_t at = std::size_t(y * kWidth + x);
        const bool line = near && alone.ids[at] != 1;
        const double kept = line ? (near_open ? 0.0 : 0.65) : 1.0;
        full += line && near_open;
        faint += line && !near_open;
        for (std::size_t channel = 3 * at; channel < 3 * at + 3; ++channel)
          ASSERT_NEAR(lined.colour.pixels[channel], kept * bare.colour.pixels[channel], 1.0) << x << ' ' << y;
      }
    EXPECT_GT(full, 100);
    EXPECT_GT(faint, 40);
  }
}

/// The application's framebuffer gets overlays over the background, too.
TEST_F(OverlaysTest, AreInExternalTargets) {
  for (const int samples : {1, 4}) {
    EngineConfig c = configured([](EngineConfig& e) { e.drawing.transparency = Transparency::kBlended; });
    c.drawing.samples = samples;
    auto engine = Engine::create(scene, c);
    ASSERT_TRUE(engine);
    std::vector<ItemId> ghosts, faded;
    for (ItemId item{0}; to_index(item) < scene.item_slots(); ++item)
      if (to_index(item) % 14 > 2) (to_index(item) % 2 == 0 ? ghosts : faded).push_back(item);
    ASSERT_TRUE(engine->set_override(ghosts, {.ghost = true}));
    ASSERT_TRUE(engine->set_override(faded, {.alpha = 0.3f}));
    ASSERT_TRUE(engine->set_override({&faded[40], 1}, {.outline = true}));
    auto theirs = render::RenderTarget::create(*context, kWidth, kHeight, {.samples = samples});
    ASSERT_TRUE(theirs);
    gl::ExternalTarget target{theirs->framebuffer().id(), 0, 0, kWidth, kHeight};
    target.clear_colour = target.clear_depth = true;
    const auto report = engine->frame(around(0.5), target);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_LE(difference(theirs->read_colour(), *engine->read_colour()), samples == 1 ? 1 : 2);
  }
}

/// An outline over a copy of the image is the one that a frame with that style has; the image stays.
TEST_P(OverlaysInAllModes, OutlinesCanBeDrawnLater) {
  EngineConfig c = configured(GetParam().set);
  auto engine = Engine::create(scene, c);
  ASSERT_TRUE(engine);
  const std::vector<ItemId> items{ItemId{1700}, ItemId{3}, ItemId{1234}, ItemId{900}, ItemId{2743}};
  const ItemId hidden{900};
  ASSERT_TRUE(engine->hide({&hidden, 1}));
  const core::View view = around(0.5);
  const image::Image bare = image(*engine, view).colour;
  auto theirs = render::RenderTarget::create(*context, kWidth, kHeight, {});
  ASSERT_TRUE(theirs);
  gl::ExternalTarget target{theirs->framebuffer().id(), 0, 0, kWidth, kHeight};
  target.clear_colour = target.clear_depth = true;
  ASSERT_TRUE(engine->frame(view, target));
  const auto drawn = engine->draw_outline(view, items, target);
  ASSERT_TRUE(drawn) << drawn.error().message;
  const image::Image later = theirs->read_colour();
  EXPECT_EQ(difference(*engine->read_colour(), bare), 0);
  EXPECT_EQ(difference(image(*engine, view).colour, bare), 0) << "the next frame";
  ASSERT_TRUE(engine->set_override(items, {.outline = true}));
  const image::Image styled = image(*engine, view).colour;
  EXPECT_LE(difference(later, styled), 1);
  EXPECT_GT(difference(styled, bare), 50) << "there is a line";
}

TEST_F(OverlaysTest, OutlinesRefuseWhatTheyCannotSurround) {
  auto engine = Engine::create(scene, configured([](EngineConfig&) {}));
  ASSERT_TRUE(engine && engine->frame(around(0)));
  auto theirs = render::RenderTarget::create(*context, kWidth, kHeight, {});
  ASSERT_TRUE(theirs);
  const gl::ExternalTarget target{theirs->framebuffer().id(), 0, 0, kWidth, kHeight};
  const ItemId unknown = ItemId(1u << 20), known = ItemId{5};
  const auto missing = engine->draw_outline(around(0), {&unknown, 1}, target);
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("no item 1048576"), std::string::npos) << missing.error().message;
  gl::ExternalTarget other = target;
  other.width = kWidth - 1;
  EXPECT_FALSE(engine->draw_outline(around(0), {&known, 1}, other));
  for (int gl::ExternalTarget::*const corner : {&gl::ExternalTarget::x, &gl::ExternalTarget::y}) {
    other = target;
    other.*corner = std::numeric_limits<int>::max();
    const auto refused = engine->draw_outline(around(0), {&known, 1}, other);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("below 2^31 pixels"), std::string::npos) << refused.error().message;
  }
  other = target;
  other.framebuffer = 4711;
  EXPECT_FALSE(engine->draw_outline(around(0), {&known, 1}, other)) << "no framebuffer";
  EXPECT_TRUE(engine->draw_outline(around(0), {}, target));
  auto culls = Engine::create(scene, {});
  ASSERT_TRUE(culls);
  EXPECT_FALSE(culls->draw_outline(around(0), {&known, 1}, target));
}

/// Programs and targets are made when the first overlay is drawn.
TEST_F(OverlaysTest, CostNothingUnused) {
  auto engine = Engine::create(scene, configured([](EngineConfig&) {}));
  ASSERT_TRUE(engine && engine->frame(around(0)));
  const std::size_t before = engine->memory().gpu;
  const ItemId one{1000};
  ASSERT_TRUE(engine->set_override({&one, 1}, {.colour = core::vec3(1.0f)}) && engine->frame(around(0)));
  EXPECT_LT(engine->memory().gpu, before + 4096);
  ASSERT_TRUE(engine->set_override({&one, 1}, {.ghost = true}) && engine->frame(around(0)));
  EXPECT_GT(engine->memory().gpu, before + kWidth * kHeight * 8 - 1);
}

}  // namespace
}  // namespace sightline::tests::overlays_test
