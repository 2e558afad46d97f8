// Files of colour images (apps/common/colour_file.h), and images on a transparent background
// (apps/common/tiled_image.h) against those on other backgrounds.
#include "sightline/apps/common/colour_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "sightline/apps/common/tiled_image.h"
#include "sightline/core/scene.h"

namespace sightline::apps::colour_file_test {
namespace {

constexpr int kWidth = 160, kHeight = 110;

std::string bytes_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class ColourFiles : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return testing::TempDir() + "colour_file_" + name; }
  const image::Image grey_{kWidth, kHeight, std::vector<std::uint8_t>(std::size_t(3 * kWidth * kHeight), 77)};
};

TEST_F(ColourFiles, AreWhatTheirNamesSay) {
  for (const char* name : {"a.jpg", "a.JPEG"}) {
    ASSERT_TRUE(write_colours(grey_, path(name)));
    const std::string bytes = bytes_of(path(name));
    EXPECT_TRUE(bytes.starts_with("\xff\xd8\xff")) << name;
    EXPECT_TRUE(bytes.ends_with("\xff\xd9")) << name;
  }
  auto file = ColourFile::create(path("b.jpg"), kWidth, kHeight);
  ASSERT_TRUE(file);
  const std::span<const std::uint8_t> pixels = grey_.pixels;
  ASSERT_TRUE(file->write_rows(pixels.first(3u * kWidth * 30u)));
  EXPECT_FALSE(file->finish());
  ASSERT_TRUE(file->write_rows(pixels.subspan(3u * kWidth * 30u)));
  ASSERT_TRUE(file->finish());
  EXPECT_EQ(bytes_of(path("b.jpg")), bytes_of(path("a.jpg")));
  ASSERT_TRUE(write_colours(grey_, path("c.png")));
  const auto back = image::read_png(path("c.png"));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->pixels, grey_.pixels);
}

TEST_F(ColourFiles, AreRefusedWithTheReason) {
  const auto transparent = ColourFile::create(path("d.jpg"), kWidth, kHeight, true);
  ASSERT_FALSE(transparent);
  EXPECT_NE(transparent.error().message.find("transparency"), std::string::npos);
  EXPECT_FALSE(ColourFile::create(path("d.jpg"), 70'000, 10));
  EXPECT_FALSE(ColourFile::create(path("d.gif"), kWidth, kHeight));
  EXPECT_FALSE(parse_image_name("a.gif"));
  for (const char* good : {"a.png", "a.jpg", "a.JPEG", "a"}) EXPECT_TRUE(parse_image_name(good)) << good;
  EXPECT_FALSE(write_colours(grey_, path("no such folder/e.jpg")));
}

/// Everything that blends with a background: smooth edges, shading and lines beside items, glass, ghosts, lines.
TEST(TransparentImages, LieOnAnyBackgroundAsIfDrawnThere) {
  core::Scene scene;
  scene.add_primitive(scene.root(), core::Cylinder{0.8f, 2.0f}, core::translation({-1.0, 0.0, 0.0}));
  const core::ItemId ghost = scene.add_primitive(scene.root(), core::Box{1, 1, 1}, core::translation({1.0, 1.0, 0.0}));
  const core::MaterialId glass = scene.add_material({"", {0.9f, 0.3f, 0.1f}, 0.5f, 0});
  scene.add_primitive(scene.root(), core::Sphere{1.2f}, core::translation({0.4, -0.8, 0.6}), glass);
  scene.add_primitive(scene.root(), core::Line{-2, 2}, core::translation({0.0, 0.0, -1.2}));
  ASSERT_TRUE(scene.commit());
  engine::EngineConfig config;
  config.draw = true;
  config.drawing.ids = true;
  config.drawing.renderer = engine::Renderer::kRays;
  config.drawing.looks = engine::Looks::standard();
  config.drawing.looks.edges.which = engine::EdgeChoice::kFeature;
  const auto tiles = tiles_for({kWidth, kHeight}, 130, config);
  ASSERT_TRUE(tiles);
  config.width = tiles->width, config.height = tiles->height;
  auto engine = engine::Engine::create(scene, config);
  ASSERT_TRUE(engine && engine->set_override({&ghost, 1}, {.ghost = true}));
  const auto view = core::View::perspective({{3, -6, 3}, {0, 0, 0}, {0, 0, 1}}, 0.6, double(kWidth) / kHeight, 0.1);
  const auto draw = [&](bool transparent) {
    std::vector<std::uint8_t> pixels;
    TiledImage image(*view, *tiles, {.ids = transparent, .transparent = transparent, .shifts = sample_shifts(4)});
    engine::EngineConfig own = engine->config();
    while (!image.complete()) {
      const auto more = image.step(*engine);
      if (!more) return std::vector<std::uint8_t>();
      if (*more) pixels.insert(pixels.end(), image.rows().colours.begin(), image.rows().colours.end());
    }
    EXPECT_EQ(engine->config().drawing.looks.background, own.drawing.looks.background);
    return pixels;
  };
  engine::EngineConfig on_grey = engine->config();
  const std::vector<std::uint8_t> clear = draw(true);
  ASSERT_EQ(clear.size(), 4u * kWidth * kHeight);
  int seen_through = 0;
  for (const core::vec3& colour : {core::vec3(0.2f, 0.6f, 0.9f), core::vec3(1.0f), core::vec3(0.0f)}) {
    on_grey.drawing.looks.background = {colour, colour};
    ASSERT_TRUE(engine->configure(on_grey));
    const std::vector<std::uint8_t> wanted = draw(false);
    ASSERT_EQ(wanted.size(), 3u * kWidth * kHeight);
    double most = 0.0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const double alpha = clear[i / 3 * 4 + 3] / 255.0;
      const double over = clear[i / 3 * 4 + i % 3] * alpha + 255.0 * double(colour[int(i % 3)]) * (1.0 - alpha);
      most = std::max(most, std::abs(over - wanted[i]));
      seen_through += alpha > 0.05 && alpha < 0.95;
    }
    EXPECT_LE(most, 2.0);
  }
  EXPECT_GT(seen_through, 1000);
}

}  // namespace
}  // namespace sightline::apps::colour_file_test
