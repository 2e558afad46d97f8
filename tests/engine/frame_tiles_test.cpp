// Engine::frame_tile() with image_tiles(): an image of tiles beside the same image in one.
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/tests/engine/drawing_modes.h"

namespace sightline::tests::frame_tiles_test {
namespace {

using core::ItemId;
using engine::Engine;
using engine::EngineConfig;
using engine::Transparency;

constexpr unsigned kSeed = 7;

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> colours;
  std::vector<std::uint32_t> ids;
  std::vector<float> metres;
};

struct Difference {
  int max = 0;
  double mean = 0.0;              // of channels
  double other = 0.0, ids = 0.0;  // shares of pixels: with another colour by more than 2; with another id
  double metres = 0.0;            // largest share of the distance, where ids are equal, but for the farthest 1 in 1000
};

Difference compare(const Image& a, const Image& b) {
  Difference d;
  const std::size_t pixels = a.ids.size();
  std::vector<double> metres;
  for (std::size_t i = 0; i < pixels; ++i) {
    int worst = 0;
    for (std::size_t c = 3 * i; c < 3 * i + 3; ++c) {
      const int by = std::abs(int(a.colours[c]) - int(b.colours[c]));
      worst = std::max(worst, by);
      d.mean += double(by) / double(3 * pixels);
    }
    d.max = std::max(d.max, worst);
    d.other += double(worst > 2) / double(pixels);
    d.ids += double(a.ids[i] != b.ids[i]) / double(pixels);
    if (a.ids[i] == b.ids[i] && a.ids[i] != 0)
      metres.push_back(std::abs(double(a.metres[i]) / double(b.metres[i]) - 1.0));
  }
  std::sort(metres.begin(), metres.end());
  if (!metres.empty()) d.metres = metres[metres.size() - 1 - metres.size() / 1000];
  return d;
}

class FrameTiles : public DrawnGrid {
 protected:
  /// Boxes and cylinders, meshes between them, and lines.
  void SetUp() override {
    DrawnGrid::SetUp();
    fill(scene, 9);
    core::Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0.8f, 0, 0}, {0, 0.8f, 0}, {0, 0, 0.8f}};
    mesh.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const auto tetrahedron = scene.add_mesh(mesh);
    ASSERT_TRUE(tetrahedron) << tetrahedron.error().message;
    for (int i = 0; i < 60; ++i)
      scene.add_mesh_instance(scene.root(), *tetrahedron,
                              core::translation({0.5 + i % 8, 0.5 + i / 8 % 8, 0.5 + i * 3 % 8}));
  }

  static core::View seen(double aspect, bool orthographic) {
    const core::Pose pose{{-6.0, -8.0, 9.0}, {4.0, 4.0, 4.0}, {0, 0, 1}};
    return orthographic ? *core::View::orthographic(pose, 11.0, aspect, -20.0, 60.0)
                        : *core::View::perspective(pose, 0.8, aspect, 0.1);
  }

  static void read(Engine& engine, const core::View& view, const engine::CroppedTile& tile, Image& into) {
    const auto colours = engine.read_colour();
    const auto ids = engine.read_ids();
    const auto depth = engine.read_depth(view);
    ASSERT_TRUE(colours && ids && depth);
    for (int y = tile.y0; y < tile.y1; ++y) {
      const std::size_t to = std::size_t(y) * std::size_t(into.width) + std::size_t(tile.x0);
      const std::size_t from =
          std::size_t(y - int(tile.tile.y)) * std::size_t(colours->width) + std::size_t(tile.x0 - int(tile.tile.x));
      const auto count = std::ptrdiff_t(tile.x1 - tile.x0);
      std::copy_n(colours->pixels.begin() + std::ptrdiff_t(3 * from), 3 * count,
                  into.colours.begin() + std::ptrdiff_t(3 * to));
      std::copy_n(ids->ids.begin() + std::ptrdiff_t(from), count, into.ids.begin() + std::ptrdiff_t(to));
      std::copy_n(depth->metres.begin() + std::ptrdiff_t(from), count, into.metres.begin() + std::ptrdiff_t(to));
    }
  }

  static Image drawn(Engine& engine, const core::View& view, int width, int height, int largest_side) {
    const std::size_t pixels = std::size_t(width) * std::size_t(height);
    Image image{width, height, std::vector<std::uint8_t>(3 * pixels), std::vector<std::uint32_t>(pixels),
                std::vector<float>(pixels)};
    const auto tiles = engine::image_tiles(width, height, largest_side);
    EXPECT_TRUE(tiles && engine.resize(tiles->width, tiles->height));
    for (const engine::CroppedTile& tile : tiles->tiles) {
      for (std::int64_t pending = 1; pending > 0;) {
        const auto report = engine.frame_tile(view, tile.tile);
        EXPECT_TRUE(report) << report.error().message;
        pending = report ? report->pending : 0;
      }
      read(engine, view, tile, image);
    }
    return image;
  }

  core::Scene scene;
};

/// What both the tests draw: depth shading, ghosts, faded and outlined items, and two section planes.
core::Expected<void> dress(Engine& engine, const core::Scene& scene) {
  std::vector<ItemId> ghosts, faded, red, outlined;
  for (ItemId item{0}; to_index(item) < scene.item_slots(); ++item) {
    if (to_index(item) % 11 == 0) ghosts.push_back(item);
    if (to_index(item) % 5 == 1) faded.push_back(item);
    if (to_index(item) % 5 == 2) red.push_back(item);
    if (to_index(item) % 60 == 4) outlined.push_back(item);
  }
  auto done = engine.set_override(ghosts, {.ghost = true});
  if (done) done = engine.set_override(faded, {.alpha = 0.5f});
  if (done) done = engine.set_override(red, {.colour = core::vec3(0.9f, 0.1f, 0.1f), .alpha = 0.4f});
  if (done) done = engine.set_override(outlined, {.outline = true});
  return done;
}

class FrameTilesInAllModes : public FrameTiles, public testing::WithParamInterface<DrawingMode> {};
INSTANTIATE_TEST_SUITE_P(, FrameTilesInAllModes,
                         testing::ValuesIn(drawing_modes(
                             {{"blended", [](EngineConfig& c) { c.drawing.transparency = Transparency::kBlended; }},
                              {"blended_gpu",
                               [](EngineConfig& c) {
                                 c.drawing.transparency = Transparency::kBlended;
                                 c.culling.culler = engine::CullerChoice::kGpu;
                               }},
                              {"edges",
                               [](EngineConfig& c) {
                                 c.drawing.looks.edges.which = engine::EdgeChoice::kFeature;
                               }},
                              {"depth_shading",
                               [](EngineConfig& c) {
                                 c.drawing.looks.depth_shading = {0.7f, 0.6f};
                               }},
                              {"standard_looks", [](EngineConfig& c) { c.drawing.looks = engine::Looks::standard(); }},
                              {"no_sample_test", [](EngineConfig& c) { c.culling.sample_test = false; }}})),
                         name_of);

/// Random sizes of images and tiles. The whole image is drawn by frame() itself.
TEST_P(FrameTilesInAllModes, JoinWithoutSeams) {
  std::mt19937 random(kSeed);
  const auto between = [&](int low, int high) { return std::uniform_int_distribution(low, high)(random); };
  EngineConfig c = config(engine::CullerChoice::kCpu);
  c.drawing.ids = true;
  GetParam().set(c);
  auto one = Engine::create(scene, c), tiled = Engine::create(scene, c);
  ASSERT_TRUE(one && tiled);
  ASSERT_TRUE(dress(*one, scene) && dress(*tiled, scene));
  for (int i = 0; i < 6; ++i) {
    const int width = between(150, 420), height = between(150, 420), largest = between(80, 200);
    SCOPED_TRACE(testing::Message() << "seed " << kSeed << ": " << width << "x" << height << " by " << largest);
    core::View view = seen(double(width) / height, i % 2 == 1);
    if (i % 3 != 0) view.sections = {{{1, 0.2, 0}, -2.3}, {{0, -1, 0.1}, 7.2}};
    if (i % 3 == 2) view.section_mode = core::SectionMode::kUnion;
    ASSERT_TRUE(one->resize(width, height) && draw_complete(*one, view));
    Image whole{width, height, one->read_colour()->pixels, one->read_ids()->ids, one->read_depth(view)->metres};
    const Difference d = compare(drawn(*tiled, view, width, height, largest), whole);
    EXPECT_LT(d.mean, 0.002);
    EXPECT_LT(d.other, 1e-4);
    EXPECT_LT(d.ids, 1e-4);
    EXPECT_LT(d.metres, 1e-5);
  }
}

}  // namespace
}  // namespace sightline::tests::frame_tiles_test
