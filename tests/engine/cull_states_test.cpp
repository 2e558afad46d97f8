// What an engine says of every item of a view, and of what an image loses: against images of everything.
#include <cstdio>
#include <random>

#include <gtest/gtest.h>

#include "sightline/tests/culling/scenes.h"
#include "sightline/tests/engine/drawn_grid.h"
#include "sightline/tests/support/simulated_gpu.h"

namespace sightline::tests::cull_states_test {
namespace {

using culling::CullState;
using culling::CullStates;
using engine::CullerChoice;
using engine::Engine;
using engine::EngineConfig;

class CullStatesTest : public DrawnGrid {
 protected:
  EngineConfig config(CullerChoice culler = CullerChoice::kCpu) {
    EngineConfig c = DrawnGrid::config(culler);
    c.drawing.ids = true;
    c.culling.occlusion = engine::OcclusionChoice::kOn;
    return c;
  }
  /// Draws everything in the view volume.
  Engine everything(core::Scene& scene) {
    EngineConfig c = config(CullerChoice::kLinear);
    c.culling.sample_test = false;
    c.culling.occlusion = engine::OcclusionChoice::kOff;
    auto engine = Engine::create(scene, c);
    EXPECT_TRUE(engine);
    return std::move(*engine);
  }
  static std::vector<bool> seen_in(Engine& engine, const core::View& view, std::size_t items) {
    EXPECT_TRUE(engine.frame(view));
    const auto ids = engine.read_ids();
    EXPECT_TRUE(ids);
    std::vector<bool> seen(items);
    for (const std::uint32_t id : ids->ids)
      if (id != 0) seen[id - 1] = true;
    return seen;
  }
  static CullState state_of(const Engine& engine, const CullStates& states, core::ItemId item) {
    return states.of_slot[engine.snapshot().slot(item)];
  }
  /// Among the items, within one of them, from outside, in parallel, cut, past all of them.
  static core::View some_view(Random& random) {
    core::View view = random_view(random, core::dvec3(11.0), 14.0);
    if (chance(random, 0.3)) view = DrawnGrid::view(uniform(random, 0.0, 6.0));
    if (chance(random, 0.3)) add_sections(random, core::dvec3(11.0), 11.0, view);
    view.section_mode = core::SectionMode::kIntersection;
    return view;
  }
};

TEST_F(CullStatesTest, WhatIsLeftOutShowsInNoImage) {
  core::Scene scene;
  fill(scene, 22);
  const std::size_t items = scene.item_count();
  Engine full = everything(scene);
  auto engine = Engine::create(scene, config());
  ASSERT_TRUE(engine) << engine.error().message;
  std::array<std::int64_t, culling::kCullStateCount> sums{};
  std::int64_t not_seen = 0, left_out = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const core::View view = some_view(random);
    const auto states = engine->cull_states(view);
    ASSERT_TRUE(states) << states.error().message;
    const auto report = engine->frame(view);
    ASSERT_TRUE(report);
    const std::vector<bool> seen = seen_in(full, view, items);
    std::int64_t in_view = 0, sum = 0;
    for (core::ItemId item{0}; to_index(item) < items; ++item) {
      const CullState state = state_of(*engine, *states, item);
      const bool shown = state == CullState::kInside || state == CullState::kIntersecting;
      if (seen[to_index(item)]) {
        ASSERT_TRUE(shown) << "item " << to_index(item) << " is seen, and " << name_of(state);
      }
      in_view += state != CullState::kOutside;
      not_seen += state != CullState::kOutside && !seen[to_index(item)];
      left_out += state != CullState::kOutside && !shown;
    }
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += states->items[i], sum += states->items[i];
    EXPECT_EQ(in_view, report->visible);
    EXPECT_EQ(sum, std::int64_t(items));
  }
  for (const std::int64_t of_state : sums) EXPECT_GT(of_state, 100);
  EXPECT_GT(left_out, not_seen * 7 / 10) << "of " << not_seen << " items that no image shows";
}

/// Whoever culls, it is the same; the frames that follow are as if nobody had asked; hidden items are not counted.
TEST_F(CullStatesTest, AreTheSameForAllCullersAndChangeNoFrame) {
  core::Scene scene;
  fill(scene, 22);
  auto first = Engine::create(scene, config());
  ASSERT_TRUE(first);
  const core::View eye = view(0.3), other = view(1.3);
  for (const CullerChoice culler : {CullerChoice::kLinear, CullerChoice::kGpu, CullerChoice::kHybrid}) {
    SCOPED_TRACE(name_of(culler));
    auto engine = Engine::create(scene, config(culler));
    ASSERT_TRUE(engine);
    ASSERT_TRUE(engine->frame(eye) && first->frame(eye));
    const auto a = first->cull_states(eye), b = engine->cull_states(eye);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->of_slot, b->of_slot);
    EXPECT_EQ(a->boxes.size(), b->boxes.size());
    auto fresh = Engine::create(scene, config());
    ASSERT_TRUE(fresh && engine->frame(other) && fresh->frame(other));
    expect_same_image(*engine, *fresh);
  }
  const std::vector<core::ItemId> some{core::ItemId{1}, core::ItemId{2}, core::ItemId{3}, core::ItemId{500}};
  const std::int64_t all = std::int64_t(scene.item_count());
  ASSERT_TRUE(first->hide(some));
  const auto states = first->cull_states(eye);
  std::int64_t sum = 0;
  for (const std::int64_t of_state : states->items) sum += of_state;
  EXPECT_EQ(sum, all - 4);
}

/// From aside: the items that are not drawn in their own colours are those left out.
TEST_F(CullStatesTest, AgreeWithFramesFromAside) {
  core::Scene scene;
  fill(scene, 16);
  EngineConfig c = config();
  c.drawing.culled_colour = core::vec3(0, 0, 1);
  auto engine = Engine::create(scene, c);
  ASSERT_TRUE(engine);
  const core::View eye = *core::View::perspective({{-6, 8, 8}, {8, 8, 8}, {0, 0, 1}}, 0.6, 1.5, 0.1),
                   aside = *core::View::perspective({{8, -60, 8}, {8, 8, 8}, {0, 0, 1}}, 0.5, 1.5, 0.1);
  const auto states = engine->cull_states(eye);
  ASSERT_TRUE(states && engine->frame({.view = aside, .cull_view = &eye}));
  const auto ids = engine->read_ids();
  const auto colours = engine->read_colour();
  ASSERT_TRUE(ids && colours);
  int blue = 0, other = 0;
  for (std::size_t i = 0; i < ids->ids.size(); ++i) {
    if (ids->ids[i] == 0) continue;
    const CullState state = state_of(*engine, *states, core::ItemId{ids->ids[i] - 1});
    const std::uint8_t* pixel = &colours->pixels[3 * i];
    const bool is_blue = pixel[2] > 40 && pixel[2] > 2 * pixel[0],
               left_out = state == CullState::kOccluded || state == CullState::kTooSmall;
    ASSERT_EQ(left_out, is_blue) << "item " << ids->ids[i] - 1 << " is " << name_of(state) << ", of red "
                                 << int(pixel[0]);
    ++(is_blue ? blue : other);
  }
  EXPECT_GT(blue, 100);
  EXPECT_GT(other, 100);
}

TEST_F(CullStatesTest, TooSmallAreThoseBelowTheMinProjectedArea) {
  core::Scene scene;
  fill(scene, 22);
  EngineConfig c = config();
  c.culling.sample_test = false;
  c.culling.occlusion = engine::OcclusionChoice::kOff;
  for (const float pixels : {0.0f, 1.0f, 20.0f}) {
    c.losses.min_projected_area = pixels;
    for (const double turn : {0.0, 0.7}) {
      auto engine = Engine::create(scene, c);  // without a history, which hysteresis would keep
      const auto states = engine->cull_states(view(turn));
      const auto report = engine->frame(view(turn));
      ASSERT_TRUE(states && report);
      EXPECT_EQ(states->items[std::size_t(CullState::kTooSmall)], report->below_min_area);
      EXPECT_EQ(states->items[std::size_t(CullState::kOccluded)], 0);
    }
  }
}

TEST_F(CullStatesTest, WithoutDrawingTheViewVolumeAloneCounts) {
  core::Scene scene;
  fill(scene, 10);
  EngineConfig c = config();
  c.draw = c.drawing.ids = false;
  auto engine = Engine::create(scene, c);
  ASSERT_TRUE(engine);
  const auto states = engine->cull_states(view(0.4));
  const auto report = engine->frame(view(0.4));
  ASSERT_TRUE(states && report);
  EXPECT_EQ(states->items[0] + states->items[1], report->visible);
  EXPECT_EQ(states->items[std::size_t(CullState::kOccluded)] + states->items[std::size_t(CullState::kTooSmall)], 0);
  EXPECT_EQ(engine->loss(view(0.4))->items, 0);
}

TEST_F(CullStatesTest, ALostContextLeavesTheViewVolume) {
  core::Scene scene;
  fill(scene, 10);
  auto engine = Engine::create(scene, config());
  ASSERT_TRUE(engine);
  engine->drop_context();
  const auto states = engine->cull_states(view(0.4));
  ASSERT_TRUE(states);
  EXPECT_EQ(states->items[std::size_t(CullState::kOccluded)], 0);
  EXPECT_GT(states->items[0] + states->items[1], 0);
  EXPECT_TRUE(engine->loss(view(0.4)));
}

/// Pixels that differ from the full image, beside what the engine says before it knows that image.
TEST_F(CullStatesTest, ALossIsHardlyMoreThanSaid) {
  core::Scene scene;
  fill(scene, 22);
  Engine full = everything(scene);
  int lossy = 0;
  double said = 0.0, lost = 0.0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const core::View view = DrawnGrid::view(uniform(random, 0.0, 6.0));
    EngineConfig c = config();
    c.losses.min_projected_area = float(magnitude(random, 4.0, 400.0));
    auto engine = Engine::create(scene, c);
    ASSERT_TRUE(engine && engine->frame(view) && full.frame(view));
    const auto loss = engine->loss(view);
    ASSERT_TRUE(loss);
    const auto ids = engine->read_ids(), all = full.read_ids();
    ASSERT_TRUE(ids && all);
    int wrong = 0;
    for (std::size_t i = 0; i < all->ids.size(); ++i) wrong += ids->ids[i] != all->ids[i];
    EXPECT_LE(wrong, 2.0 * loss->pixels + 1.0);
    EXPECT_LE(loss->pixels, 192.0 * 128.0);
    EXPECT_EQ(wrong > 0 && loss->items == 0, false);
    lossy += wrong > 0;
    said += loss->pixels;
    lost += wrong;
    ASSERT_TRUE(full.loss(view));
    EXPECT_EQ(full.loss(view)->items, 0);
  }
  EXPECT_GT(lossy, 10);
  EXPECT_LT(said, 8.0 * lost);
}

/// A budget loses what is pending, and nothing once the image is complete.
TEST_F(CullStatesTest, ABudgetLosesUntilTheImageIsComplete) {
  const SimulatedGpu gpu(*context, {});  // software rasterisers draw coarser images instead
  core::Scene scene;
  fill(scene, 22);
  EngineConfig c = config();
  c.losses.budget_ms = 1e-3;
  auto engine = Engine::create(scene, c), asked = Engine::create(scene, c);
  ASSERT_TRUE(engine && asked);
  const auto first = asked->frame(view(0.2));
  ASSERT_TRUE(first);
  ASSERT_GT(first->pending, 0);
  auto loss = asked->loss(view(0.2));
  ASSERT_TRUE(loss);
  EXPECT_GT(loss->items, 0);
  EXPECT_GT(loss->pixels, 0.0);
  while (asked->frame(view(0.2))->pending > 0) ASSERT_TRUE(asked->loss(view(0.2)));  // asking changes nothing
  EXPECT_EQ(asked->loss(view(0.2))->items, 0);
  ASSERT_TRUE(draw_complete(*engine, view(0.2)));
  expect_same_image(*engine, *asked);
}

}  // namespace
}  // namespace sightline::tests::cull_states_test
