// Draw lists, by the pictures they give: every record that a set names is drawn, however many commands that takes.
#include "sightline/gpuscene/draw_lists.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "sightline/render/renderer.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline {
namespace {

using core::dvec3;
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

/// A box in the middle of each pixel.
class BoxPerPixel : public tests::GlTest {
 protected:
  static constexpr int kWidth = 200, kHeight = 100, kItems = kWidth * kHeight;

  void SetUp() override {
    tests::GlTest::SetUp();
    for (int i = 0; i < kItems; ++i)
      scene.add_primitive(scene.root(), core::Box{0.8f, 0.8f, 0.8f},
                          core::translation({i % kWidth + 0.5, i / kWidth + 0.5, 0.0}));
    EXPECT_TRUE(scene.commit());
  }
  static View view() {
    return *View::orthographic({{0.5 * kWidth, 0.5 * kHeight, 10.0}, {0.5 * kWidth, 0.5 * kHeight, 0.0}, {0, 1, 0}},
                               kHeight, double(kWidth) / kHeight, 0.0, 20.0);
  }
  /// The picture shows the items of a set and no others.
  void expect_shown(Stage& stage, const VisibleSet& set) {
    ASSERT_TRUE(stage.lists.update(stage.snapshot, stage.gpu, set));
    std::vector<std::uint32_t> shown = stage.ids(view()), wanted;
    std::erase(shown, 0u);
    std::sort(shown.begin(), shown.end());
    for (const core::Slot slot : set.sorted_slots())
      if (!stage.snapshot.vacant(slot)) wanted.push_back(stage.snapshot.item(slot) + 1);
    std::sort(wanted.begin(), wanted.end());
    EXPECT_EQ(shown, wanted);
  }

  core::Scene scene;
};

TEST_F(BoxPerPixel, IsDrawnIfNamed) {
  Stage stage(*context, scene, kWidth, kHeight);
  expect_shown(stage, stage.all());  // runs of many commands
  VisibleSet singles;
  for (core::Slot slot = 0; slot < kItems; slot += 2) singles.items.push_back(slot);
  expect_shown(stage, singles);
  VisibleSet both;
  both.ranges = {{100, 128}, {1000, 50}, {2000, 9000}, {11000, 127}};
  for (core::Slot slot = 12000; slot < 19000; slot += 3) both.items.push_back(slot);
  for (int frame = 0; frame < 4; ++frame) expect_shown(stage, both);
  expect_shown(stage, {});
}

TEST_F(BoxPerPixel, IsGoneWhenHidden) {
  Stage stage(*context, scene, kWidth, kHeight);
  for (core::ItemId item = 0; item < kItems; ++item)
    if (item % 10 != 3 && item > 4000) scene.set_visible(item, false);
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
}  // namespace sightline
