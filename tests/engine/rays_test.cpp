// Images by rays beside those of OpenGL, and without it.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sightline/core/scene.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/render/image/image_metrics.h"
#include "sightline/tests/engine/drawing_modes.h"

namespace sightline::tests::rays_test {
namespace {

using engine::Engine;
using engine::EngineConfig;
using engine::Looks;
using engine::Renderer;

constexpr int kWidth = 320, kHeight = 200, kPixels = kWidth * kHeight;

/// A grid of solids with what images may hold besides: meshes, lines, glass.
void furnish(core::Scene& scene, std::vector<core::ItemId>& items) {
  for (int i = 0; i < 8 * 8 * 8; ++i) {
    const core::Affine place = core::translation({i % 8, i / 8 % 8, i / 64});
    const core::Primitive shape =
        i % 2 == 0 ? core::Primitive(core::Box{0.4f, 0.4f, 0.4f}) : core::Cylinder{0.2f, 0.5f};
    scene.add_primitive(scene.root(), shape, place);
  }
  const core::MaterialId glass = scene.add_material({"", {0.9f, 0.6f, 0.1f}, 0.5f, 0});
  for (int i = 0; i < 5; ++i)
    items.push_back(
        scene.add_primitive(scene.root(), core::Sphere{1.5f}, core::translation({2.0 * i, 3.5, 3.5}), glass));
  for (int i = 0; i < 20; ++i)
    items.push_back(scene.add_primitive(scene.root(), core::Line{-9, 9}, core::translation({0.4 * i, 4, 0.35 * i})));
  const core::Mesh ball = gpuprims::tessellate(core::Sphere{2.0f}, {.fixed_segments = 24});
  const core::MeshId mesh = scene.add_mesh(ball).value();
  for (int i = 0; i < 4; ++i)
    items.push_back(scene.add_mesh_instance(scene.root(), mesh, core::translation({2.5 * i, -1.0, 2.0 * i})));
}

core::View at(double turn) {
  const core::dvec3 centre(3.5), eye = centre + 13.0 * core::dvec3(std::cos(turn), std::sin(turn), 0.4);
  return *core::View::perspective({eye, centre, {0, 0, 1}}, 0.8, double(kWidth) / kHeight, 0.1);
}
core::View parallel(double turn) {
  const core::dvec3 centre(3.5), eye = centre + 20.0 * core::dvec3(std::cos(turn), std::sin(turn), 0.7);
  return *core::View::orthographic({eye, centre, {0, 0, 1}}, 14.0, double(kWidth) / kHeight, 0.1, 60.0);
}

/// Pixels that show another item, and of the others those with colours or depths that differ by more than rounding.
struct Differences {
  int ids = 0, colours = 0, depths = 0;
  double flip = 0.0;
};
core::Expected<Differences> differences(Engine& a, Engine& b, const core::View& view) {
  const auto colours = a.read_colour(), wanted = b.read_colour();
  const auto ids = a.read_ids(), wanted_ids = b.read_ids();
  const auto depths = a.read_depth(view), wanted_depths = b.read_depth(view);
  if (!(colours && wanted && ids && wanted_ids && depths && wanted_depths)) return core::fail("no image");
  Differences found;
  for (const float error : image::flip(*wanted, *colours)) found.flip += double(error) / kPixels;
  for (std::size_t i = 0; i < ids->ids.size(); ++i) {
    if (ids->ids[i] != wanted_ids->ids[i]) {
      ++found.ids;
      continue;
    }
    int most = 0;
    for (std::size_t c = 0; c < 3; ++c)
      most = std::max(most, std::abs(int(colours->pixels[3 * i + c]) - int(wanted->pixels[3 * i + c])));
    found.colours += most > 3;
    const float depth = depths->metres[i], other = wanted_depths->metres[i];
    found.depths += ids->ids[i] != 0 && std::abs(depth - other) > 1e-3f * other;
  }
  return found;
}

class Rays : public DrawnGrid, public testing::WithParamInterface<DrawingMode> {
 protected:
  void SetUp() override {
    DrawnGrid::SetUp();
    furnish(scene, items);
  }
  EngineConfig with(Renderer renderer) {
    EngineConfig c = config(engine::CullerChoice::kCpu, kWidth, kHeight);
    c.drawing.ids = true;
    GetParam().set(c);
    if (renderer == Renderer::kRays) c.context.application = nullptr;
    c.drawing.renderer = renderer;
    return c;
  }
  core::Scene scene;
  std::vector<core::ItemId> items;
};

const DrawingMode kStandard{"standard", [](EngineConfig& c) { c.drawing.looks = Looks::standard(); }};

INSTANTIATE_TEST_SUITE_P(, Rays,
                         testing::Values(DrawingMode{"plain", [](EngineConfig&) {}},
                                         DrawingMode{"standard",
                                                     [](EngineConfig& c) { c.drawing.looks = Looks::standard(); }},
                                         DrawingMode{"samples",
                                                     [](EngineConfig& c) {
                                                       c.drawing.looks = Looks::standard();
                                                       c.drawing.samples = 4;
                                                     }},
                                         DrawingMode{"sun",
                                                     [](EngineConfig& c) {
                                                       c.drawing.looks.lighting = gpuprims::Lighting::kSun;
                                                       c.drawing.looks.sun = {1, -2, 3};
                                                       c.drawing.looks.background.top = {0.2f, 0.3f, 0.7f};
                                                     }}),
                         name_of);

TEST_P(Rays, DrawWhatOpenGlDraws) {
  auto rays = Engine::create(scene, with(Renderer::kRays)), gl = Engine::create(scene, with(Renderer::kGl));
  ASSERT_TRUE(rays && gl) << (rays ? gl.error().message : rays.error().message);
  EXPECT_TRUE(rays->renderer().starts_with("rays")) << rays->renderer();
  const bool smooth = with(Renderer::kGl).drawing.samples > 1;
  for (int i = 0; i < 8; ++i) {
    core::View view = i % 2 == 0 ? at(0.7 * i) : parallel(0.7 * i);
    if (i >= 4) view.sections.push_back({{0, -1, 0}, 4.1});
    SCOPED_TRACE(i);
    const auto drawn = rays->frame(view);
    ASSERT_TRUE(drawn && gl->frame(view));
    EXPECT_TRUE(drawn->drawn);
    EXPECT_EQ(drawn->pending, 0);
    EXPECT_EQ(drawn->items_drawn, drawn->visible);
    const auto found = differences(*rays, *gl, view);
    ASSERT_TRUE(found);
    EXPECT_TRUE(rays->covered().value_or(false));
    // Four samples lie elsewhere than the driver's.
    EXPECT_LE(found->flip, smooth ? 0.07 : 0.004);
    if (smooth) continue;
    EXPECT_LE(found->ids, 0.006 * kPixels);
    EXPECT_LE(found->colours, 0.006 * kPixels);
    EXPECT_LE(found->depths, 0.004 * kPixels);
  }
}

class RaysThatFollow : public Rays {};

INSTANTIATE_TEST_SUITE_P(, RaysThatFollow, testing::Values(kStandard), name_of);

/// Styles, edits and tiles reach images by rays as they reach others.
TEST_P(RaysThatFollow, StylesAndEdits) {
  auto rays = Engine::create(scene, with(Renderer::kRays)), gl = Engine::create(scene, with(Renderer::kGl));
  ASSERT_TRUE(rays && gl);
  const core::View view = at(0.9);
  const auto expect_alike = [&](const char* what) {
    SCOPED_TRACE(what);
    ASSERT_TRUE(rays->frame(view) && gl->frame(view));
    const auto found = differences(*rays, *gl, view);
    ASSERT_TRUE(found);
    EXPECT_LE(found->ids, 0.006 * kPixels);
    EXPECT_LE(found->colours, 0.008 * kPixels);
  };
  const auto both = [&](const auto& change) {
    ASSERT_TRUE(change(*rays));
    ASSERT_TRUE(change(*gl));
  };
  const std::vector<core::ItemId> some(items.begin(), items.begin() + 3), meshes(items.end() - 4, items.end());
  both([&](Engine& e) { return e.set_override(meshes, {.ghost = true}); });
  expect_alike("ghosts");
  both([&](Engine& e) { return e.set_override(some, {.outline = true}); });
  expect_alike("outlines");
  both([&](Engine& e) { return e.hide(meshes); });
  expect_alike("hidden");
  scene.set_placement(items[0], core::translation({1, 1, 6}));
  scene.add_primitive(scene.root(), core::Box{2, 2, 2}, core::translation({5, 5, 7}));
  both([&](Engine& e) { return e.commit(); });
  expect_alike("edited");
  both([&](Engine& e) { return e.resize(kWidth / 2, kHeight); });
  const engine::ImageTile right{kWidth, kHeight, kWidth / 2.0, 0.0};
  ASSERT_TRUE(rays->frame_tile(view, right) && gl->frame_tile(view, right));
  const auto tile = rays->read_colour(), wanted = gl->read_colour();
  ASSERT_TRUE(tile && wanted);
  EXPECT_EQ(tile->width, kWidth / 2);
  EXPECT_LE(image::compare(*tile, *wanted)->pixels, std::uint64_t(0.04 * kPixels));
}

/// Without a context, and the same for any number of threads.
TEST(RaysAlone, DrawTheSameWithAnyNumberOfThreads) {
  core::Scene scene;
  std::vector<core::ItemId> items;
  furnish(scene, items);
  std::optional<image::Image> first;
  for (const int threads : {1, 2, 3, 5, 16}) {
    EngineConfig config;
    config.draw = true;
    config.width = kWidth, config.height = kHeight;
    config.threads = threads;
    config.drawing.renderer = Renderer::kRays;
    config.drawing.looks = Looks::standard();
    auto engine = Engine::create(scene, config);
    ASSERT_TRUE(engine) << engine.error().message;
    EXPECT_EQ(engine::EngineParts::drawing(*engine), nullptr);
    EXPECT_FALSE(engine->read_colour()) << "before the first frame";
    ASSERT_TRUE(engine->frame(at(0.4)));
    auto image = engine->read_colour();
    ASSERT_TRUE(image);
    if (!first) first = std::move(*image);
    EXPECT_EQ(engine->read_colour()->pixels, first->pixels) << threads;
    EXPECT_FALSE(engine->framebuffer());
    const auto& entries = engine->plan().entries;
    EXPECT_TRUE(std::ranges::any_of(entries, [](const auto& e) { return e.feature == "images by rays" && e.used; }));
    EXPECT_TRUE(std::ranges::none_of(entries, [](const auto& e) { return e.feature == "sphere program" && e.used; }));
  }
}

/// An engine that may draw by either shows its first images by rays, once it can, until it has a context.
TEST(RaysAlone, DrawUntilThereIsAContext) {
  core::Scene scene;
  std::vector<core::ItemId> items;
  furnish(scene, items);
  EngineConfig config;
  config.draw = true;
  config.width = kWidth, config.height = kHeight;
  config.drawing.renderer = Renderer::kRays;
  config.drawing.looks = Looks::standard();
  auto wanted = Engine::create(scene, config);
  config.drawing.renderer = Renderer::kAutomatic;
  config.drawing.culled_colour = core::vec3(1.0f);  // of no use here, and no reason not to draw
  config.context.later = true;
  auto engine = Engine::create(scene, config);
  ASSERT_TRUE(wanted && engine) << engine.error().message;
  EXPECT_EQ(engine->renderer(), "");
  engine->prepare_picks();
  for (bool drawn = false; !drawn;) {
    const bool waits = engine->preparing_picks();
    const auto report = engine->frame(at(0.4));
    ASSERT_TRUE(report);
    drawn = report->drawn;
    ASSERT_TRUE(drawn || waits);
    EXPECT_GT(report->visible, 0);
  }
  ASSERT_TRUE(wanted->frame(at(0.4)));
  EXPECT_EQ(engine->read_colour()->pixels, wanted->read_colour()->pixels);
}

TEST(RaysAlone, RefuseWhatOnlyOpenGlHas) {
  core::Scene scene;
  std::vector<core::ItemId> items;
  furnish(scene, items);
  const auto error_with = [&](const auto& set) {
    EngineConfig config;
    config.draw = true;
    config.drawing.renderer = Renderer::kRays;
    set(config);
    const auto engine = Engine::create(scene, config);
    return engine ? std::string() : engine.error().message;
  };
  EXPECT_EQ(error_with([](EngineConfig&) {}), "");
  EXPECT_NE(error_with([](EngineConfig& c) { c.drawing.looks.hatching.strength = 1.0f; }).find("hatching"),
            std::string::npos);
  EXPECT_NE(
      error_with([](EngineConfig& c) { c.drawing.transparency = engine::Transparency::kBlended; }).find("blended"),
      std::string::npos);
  EXPECT_NE(error_with([](EngineConfig& c) { c.culling.culler = engine::CullerChoice::kGpu; }).find("culler gpu"),
            std::string::npos);
  EXPECT_NE(error_with([](EngineConfig& c) { c.context.later = true; }).find("context"), std::string::npos);
}

}  // namespace
}  // namespace sightline::tests::rays_test
