// Images of a model that is being read.
#include "sightline/apps/view/preview.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sightline/apps/common/model.h"
#include "sightline/apps/view/camera.h"
#include "sightline/gl/context.h"
#include "sightline/render/image/image.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::apps::preview_test {
namespace {

using core::ItemId;

class PreviewTest : public tests::GlTest {
 protected:
  static engine::EngineConfig config() {
    engine::EngineConfig c;
    c.draw = true;
    return c;
  }
  /// Later than any image waits.
  image::Image read(std::uint32_t framebuffer, int width, int height) const {
    const gl::Functions& gl = context->functions();
    image::Image image{width, height, std::vector<std::uint8_t>(std::size_t(3 * width * height))};
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.ReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, image.pixels.data());
    image::Image flipped = image;
    const int row = 3 * width;
    for (int y = 0; y < height; ++y)
      std::copy_n(image.pixels.begin() + y * row, row, flipped.pixels.begin() + (height - 1 - y) * row);
    return flipped;
  }
  /// Once it is complete.
  std::optional<std::uint32_t> draw(Preview& preview, const std::array<int, 2>& size) {
    std::optional<std::uint32_t> framebuffer;
    do framebuffer = preview.draw(*context, size);
    while (preview.drawing());
    return framebuffer;
  }
  Preview::Clock::time_point later() { return now += std::chrono::hours(1); }

  core::Scene scene;
  Preview::Clock::time_point now = Preview::Clock::now();
};

/// From items in any order, in portions of any size, it keeps those that a sorted list has first.
TEST_F(PreviewTest, KeepsTheLargestItems) {
  constexpr unsigned kSeed = 3;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  Preview preview(config());
  const core::NodeId hidden = scene.add_node(scene.root(), "hidden");
  scene.set_visible(hidden, false);
  std::vector<std::pair<float, ItemId>> sizes;
  while (sizes.size() < Preview::kMostItems * 5 / 4) {
    for (auto left = random() % 20'000; left > 0; --left) {
      const auto size = float(1 + random() % 1000);  // many equal ones
      const bool shown = random() % 8 != 0;
      const ItemId item = scene.add_primitive(shown ? scene.root() : hidden, core::Box{size, size, size});
      if (shown) sizes.emplace_back(-size, item);
    }
    (void)preview.follow(scene, now);
  }
  std::sort(sizes.begin(), sizes.end());
  std::vector<ItemId> expected;
  for (std::size_t i = 0; i < Preview::kMostItems; ++i) expected.push_back(sizes[i].second);
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(preview.largest(), expected);
}

/// Solids, meshes with their materials and what lies below turned nodes: the image of the scene itself.
TEST_F(PreviewTest, ShowsWhatTheSceneShows) {
  constexpr unsigned kSeed = 8;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random{kSeed};
  const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  core::Mesh wedge;
  wedge.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  wedge.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  const core::MeshId mesh = *scene.add_mesh(std::move(wedge));
  std::vector<core::MaterialId> materials;
  for (int i = 0; i < 5; ++i)
    materials.push_back(scene.add_material({"", core::vec3(between(0, 1), between(0, 1), between(0, 1))}));
  Preview preview(config());
  EXPECT_FALSE(preview.follow(scene, later())) << "nothing to see";
  EXPECT_FALSE(preview.draw(*context, {60, 40}));
  for (int i = 0; i < 300; ++i) {
    const double turn = between(0.0, 6.0);
    core::Affine place = core::translation({between(0, 20), between(0, 20), between(0, 20)});
    place.linear[0] = core::dvec3(std::cos(turn), std::sin(turn), 0.0);
    place.linear[1] = core::dvec3(-std::sin(turn), std::cos(turn), 0.0);
    const core::NodeId node = scene.add_node(scene.root(), "", place);
    const core::MaterialId material = materials[random() % materials.size()];
    if (i % 3 == 0)
      scene.add_mesh_instance(node, mesh, {}, material);
    else
      scene.add_primitive(node, core::Cylinder{0.4f, 1.5f}, {}, material);
    if (i == 150) {
      ASSERT_TRUE(preview.follow(scene, later()));
      EXPECT_TRUE(preview.drawing());
      EXPECT_FALSE(preview.draw(*context, {60, 40})) << "not yet";
      ASSERT_TRUE(draw(preview, {60, 40}));
      EXPECT_EQ(preview.items(), 151u);
    }
  }
  ASSERT_TRUE(preview.follow(scene, later()));
  EXPECT_FALSE(preview.follow(scene, later())) << "nothing is new";
  ASSERT_TRUE(preview.draw(*context, {90, 60})) << "the former one";
  EXPECT_EQ(preview.items(), 151u);
  ASSERT_TRUE(draw(preview, {90, 60}));
  const auto framebuffer = draw(preview, {120, 80});
  ASSERT_TRUE(framebuffer);
  const image::Image seen = read(*framebuffer, 120, 80);
  EXPECT_EQ(preview.items(), 300u);

  ASSERT_TRUE(scene.commit());
  engine::EngineConfig c = config();
  c.width = 120;
  c.height = 80;
  c.context.application = &*context;
  auto twin = engine::Engine::create(scene, c);
  ASSERT_TRUE(twin);
  Camera camera(twin->snapshot().bounds().fitted_bounds().bounds, kFovy, 1.5);
  camera.show_all(twin->snapshot().bounds(), core::kOverviewDirection, 1.5);
  ASSERT_TRUE(twin->frame(*camera.view(1.5)));
  EXPECT_LE(image::compare(*twin->read_colour(), seen)->max, 1);
}

/// A mesh that would be too much is a box.
TEST_F(PreviewTest, HasBoxesForHugeMeshes) {
  core::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, 5}};
  mesh.indices.resize(Preview::kMostCorners + 3);
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) mesh.indices[i] = std::uint32_t(i % 4);
  scene.add_mesh_instance(scene.root(), *scene.add_mesh(std::move(mesh)));
  scene.add_mesh_instance(scene.root(), *scene.add_mesh({}));
  Preview preview(config());
  ASSERT_TRUE(preview.follow(scene, later()));
  ASSERT_TRUE(draw(preview, {60, 40}));
  EXPECT_EQ(preview.items(), 2u);
}

}  // namespace
}  // namespace sightline::apps::preview_test
