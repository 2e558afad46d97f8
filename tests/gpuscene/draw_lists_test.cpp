// Draw lists, by the images they give: every record that a set names is drawn, however many commands that takes.
#include "sightline/gpuscene/internal/draw_lists.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "sightline/render/internal/renderer.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::draw_lists_test {
namespace {

using core::View;
using core::VisibleSet;

/// All that it takes to draw a scene.
struct Stage {
  Stage(const gl::Context& context, const core::Scene& scene, int width, int height)
      : snapshot(scene),
        gpu(std::move(*gpuscene::GpuScene::create(context, snapshot))),
        lists(std::move(*gpuscene::DrawLists::create(context, gpu))),
        renderer(std::move(*render::Renderer::create(context, gpu, {.ids = true}))),
        target(std::move(*render::RenderTarget::create(context, width, height, {.ids = true}))) {}

  VisibleSet all() const {
    VisibleSet set;
    set.ranges = {{0, std::uint32_t(snapshot.size())}};
    return set;
  }
  std::vector<std::uint32_t> ids(const View& view) {
    EXPECT_TRUE(renderer.draw(view, snapshot, gpu, lists, target));
    return target.read_ids().ids;
  }

  core::Snapshot snapshot;
  gpuscene::GpuScene gpu;
  gpuscene::DrawLists lists;
  render::Renderer renderer;
  render::RenderTarget target;
};

/// A box in the middle of each pixel; of every third, a ball, so that two batches have records that are drawn one by
/// one.
class BoxPerPixel : public tests::GlTest {
 protected:
  static constexpr int kWidth = 200, kHeight = 100, kItems = kWidth * kHeight;

  void SetUp() override {
    tests::GlTest::SetUp();
    for (int i = 0; i < kItems; ++i) {
      const core::Affine place = core::translation({i % kWidth + 0.5, i / kWidth + 0.5, 0.0});
      if (i % 3 == 0)
        scene.add_primitive(scene.root(), core::Sphere{0.8f}, place);
      else
        scene.add_primitive(scene.root(), core::Box{0.8f, 0.8f, 0.8f}, place);
    }
    EXPECT_TRUE(scene.commit());
  }
  static View view() {
    return *View::orthographic({{0.5 * kWidth, 0.5 * kHeight, 10.0}, {0.5 * kWidth, 0.5 * kHeight, 0.0}, {0, 1, 0}},
                               kHeight, double(kWidth) / kHeight, 0.0, 20.0);
  }
  /// The image shows the items of a set and no others.
  void expect_shown(Stage& stage, const VisibleSet& set) {
    ASSERT_TRUE(stage.lists.update(stage.snapshot, stage.gpu, set));
    std::vector<std::uint32_t> shown = stage.ids(view()), wanted;
    std::erase(shown, 0u);
    std::sort(shown.begin(), shown.end());
    for (const core::Slot slot : set.sorted_slots())
      if (!stage.snapshot.vacant(slot)) wanted.push_back(to_index(stage.snapshot.item(slot)) + 1);
    std::sort(wanted.begin(), wanted.end());
    EXPECT_EQ(shown, wanted);
  }

  /// Ranges, single records, and both.
  void expect_named_shown(Stage& stage) {
    expect_shown(stage, stage.all());  // runs of many commands
    VisibleSet singles;
    for (core::Slot slot = 0; slot < kItems; slot += 2) singles.single_slots.push_back(slot);
    expect_shown(stage, singles);
    VisibleSet both;
    both.ranges = {{100, 128}, {1000, 50}, {2000, 9000}, {11000, 127}};
    for (core::Slot slot = 12000; slot < 19000; slot += 3) both.single_slots.push_back(slot);
    for (int frame = 0; frame < 4; ++frame) expect_shown(stage, both);
    expect_shown(stage, {});
  }

  core::Scene scene;
};

TEST_F(BoxPerPixel, IsDrawnIfNamed) {
  Stage stage(*context, scene, kWidth, kHeight);
  expect_named_shown(stage);
}

TEST_F(BoxPerPixel, IsDrawnIfNamedWithoutGeometryStage) {
  auto made = gl::Context::create_offscreen({.debug = true, .workarounds = "no-geometry-stage=on"});
  ASSERT_TRUE(made) << made.error().message;
  if (tests::watch_functions) tests::watch_functions(const_cast<gl::Functions&>(made->functions()));
  {
    Stage stage(*made, scene, kWidth, kHeight);
    expect_named_shown(stage);
  }
  EXPECT_TRUE(made->take_errors().empty());
  ASSERT_TRUE(context->make_current());
}

TEST_F(BoxPerPixel, IsGoneWhenHidden) {
  Stage stage(*context, scene, kWidth, kHeight);
  for (core::ItemId item{0}; to_index(item) < kItems; ++item)
    if (to_index(item) % 10 != 3 && to_index(item) > 4000) scene.set_visible(item, false);
  const auto touched = stage.snapshot.apply(*scene.commit());
  stage.gpu.update(stage.snapshot, touched);
  expect_shown(stage, stage.all());
}

/// So that no upload waits for frames that are still being drawn.
TEST_F(BoxPerPixel, ListsOfThreeFramesLieApart) {
  Stage stage(*context, scene, kWidth, kHeight);
  std::vector<std::size_t> offsets;
  for (int frame = 0; frame < 6; ++frame) {
    ASSERT_TRUE(stage.lists.update(stage.snapshot, stage.gpu, stage.all()));
    offsets.push_back(stage.lists.section(gpuscene::BatchKind::kBox).offset);
  }
  EXPECT_EQ(std::set(offsets.begin(), offsets.end()).size(), 3u);
  for (std::size_t frame = 0; frame < 3; ++frame) EXPECT_EQ(offsets[frame], offsets[frame + 3]);
}

}  // namespace
}  // namespace sightline::draw_lists_test
