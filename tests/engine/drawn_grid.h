// Engines that draw a grid of cylinders and boxes, in the test's context.
#pragma once

#include <vector>

#include "sightline/engine/drawing/internal/drawing.h"
#include "sightline/engine/engine.h"
#include "sightline/engine/internal/engine_parts.h"
#include "sightline/render/image/image.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::tests {

inline GLenum reset_in_frame() {
  return GL_UNKNOWN_CONTEXT_RESET;
}

/// What a driver does that resets a context: it says so. Whatever is done to its objects after that has no effect.
inline void lose(const gl::Context& context) {
  const_cast<gl::Capabilities&>(context.capabilities()).reset_notification = true;
  const_cast<gl::Functions&>(context.functions()).GetGraphicsResetStatus = reset_in_frame;
}

class DrawnGrid : public GlTest {
 protected:
  /// Cylinders and boxes, n^3 of them, one metre apart.
  static void fill(core::Scene& scene, int n) {
    for (int i = 0; i < n * n * n; ++i) {
      const core::Affine at = core::translation({i % n, i / n % n, i / n / n});
      if (i % 2 == 0)
        scene.add_primitive(scene.root(), core::Box{0.4f, 0.4f, 0.4f}, at);
      else
        scene.add_primitive(scene.root(), core::Cylinder{0.2f, 0.5f}, at);
    }
  }
  /// From among the items of a grid of 22 or so; `turn` in radians about its centre.
  static core::View view(double turn, double aspect = 1.5) {
    const core::dvec3 centre(11.0), eye = centre + 14.0 * core::dvec3(std::cos(turn), std::sin(turn), 0.2);
    return *core::View::perspective({eye, centre, {0, 0, 1}}, 0.7, aspect, 0.1);
  }
  engine::EngineConfig config(engine::CullerChoice culler, int width = 192, int height = 128) {
    engine::EngineConfig c;
    c.culling.culler = culler;
    c.draw = true;
    c.width = width;
    c.height = height;
    c.context.application = &*context;
    return c;
  }
  /// Draws until the image is complete, which takes several frames with a budget, and waits for it.
  static bool draw_complete(engine::Engine& engine, const core::View& view) {
    for (std::int64_t pending = 1; pending > 0;) {
      const auto report = engine.frame(view);
      EXPECT_TRUE(report) << report.error().message;
      if (!report) return false;
      pending = report->pending;
    }
    engine.finish();
    return true;
  }
  /// An engine that changes its images: depth shading, edges, ghosts, transparent items and one with an outline.
  static core::Expected<engine::Engine> create_with_overlays(core::Scene& scene, engine::EngineConfig c) {
    c.drawing.looks.depth_shading = {0.5f, 0.5f};
    c.drawing.looks.edges.which = engine::EdgeChoice::kFeature;
    auto engine = engine::Engine::create(scene, c);
    if (!engine) return engine;
    std::vector<core::ItemId> ghosts, faded;
    for (core::ItemId item{0}; to_index(item) < scene.item_slots(); item = core::ItemId{to_index(item) + 2})
      (to_index(item) % 3 == 0 ? ghosts : faded).push_back(item);
    auto done = engine->set_override(ghosts, {.ghost = true});
    if (done) done = engine->set_override(faded, {.alpha = 0.5f});
    if (done) done = engine->set_override({&faded[3], 1}, {.outline = true});
    if (!done) return tl::unexpected(done.error());
    return engine;
  }

 public:
  /// A hybrid that takes another path in every frame, as soon as it has measured both. With nothing drawn, on a
  /// software rasteriser that does not measure the GPU's culling, it takes the GPU's path every few frames to find out.
  static void switch_often(engine::EngineConfig& c) {
    culling::ControllerConfig& k = c.culling.controller;
    k.margin = k.dwell_margin = -1e6;
    k.least_gpu_cull_ms = 0.0;
    k.probe_share = k.probe_cost = 1e6, k.probe_interval = 0;
    k.presumed_gpu_excess = -1e-9;  // 0 would be the engine's default for a software rasteriser
  }

 protected:
  /// Another order of the items has other chunk origins, and so other last bits: for that, `max` 1.
  static void expect_same_image(engine::Engine& a, engine::Engine& b, int max = 0) {
    a.finish();
    b.finish();
    const auto difference = image::compare(engine::EngineParts::drawing(a)->target().read_colour(),
                                           engine::EngineParts::drawing(b)->target().read_colour());
    ASSERT_TRUE(difference) << difference.error().message;
    EXPECT_LE(difference->max, max) << difference->pixels << " pixels";
  }
};

}  // namespace sightline::tests
