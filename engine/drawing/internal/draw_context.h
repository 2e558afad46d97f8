// The GL objects and settings that everything which draws an image shares. Internal to engine.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "sightline/core/thread_pool.h"
#include "sightline/culling/occlusion/contribution.h"
#include "sightline/culling/occlusion/internal/solid_areas.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/culling/occlusion/sample_test.h"
#include "sightline/engine/drawing/internal/draw_choice.h"
#include "sightline/engine/drawing/internal/image_state.h"
#include "sightline/engine/drawing/internal/mesh_details.h"
#include "sightline/engine/engine.h"
#include "sightline/gpuscene/internal/draw_lists.h"
#include "sightline/gpuscene/internal/gpu_scene.h"
#include "sightline/render/internal/compositor.h"
#include "sightline/render/internal/enlarge_pass.h"
#include "sightline/render/internal/renderer.h"

namespace sightline::engine {

/// What of a frame is drawn at once. Borrows everything.
struct DrawRequest {
  const core::VisibleSet& set;
  const render::RenderTarget& onto;
  ClusterPasses* clusters = nullptr;  ///< leaves out clusters of meshes
  double coarsened = 0.0;             ///< pixels within which meshes are drawn, if more than LossConfig::lod_error
  const gl::TextureBuffer* materials = nullptr;  ///< see render::DrawPass
};

/// Plain state: its owner (Drawing) fills it, and each strategy draws with it. `scene` and `lists` are empty until the
/// first upload is complete, and `renderer` is so where the engine only culls.
struct DrawContext {
  DrawContext(gl::Context shared, const EngineConfig& settings)
      : context(std::move(shared)), config(settings), threads(settings.threads, settings.runner) {}

  gl::Context context;
  EngineConfig config;
  std::optional<gpuscene::GpuScene> scene;
  std::optional<gpuscene::DrawLists> lists;
  std::optional<render::Renderer> renderer;
  std::map<std::uint32_t, ImageState> images;
  ImageState* image = &images[0];  // the one in use
  culling::SolidAreas solid_areas;
  MeshDetails mesh_details;
  DrawChoice choice;
  core::ThreadPool threads;                         // for tests of large sets; none starts before the first of them
  std::optional<render::Compositor> compositor;     // created with the first external target
  std::optional<render::EnlargePass> enlarge_pass;  // created with the first smaller image
  std::optional<double> measured_round_trip_ms;

  const gl::Functions& gl() const { return context.functions(); }
  bool software() const { return context.capabilities().software; }
  const render::RenderTarget& target() const { return image->target; }
  /// Time from the end of the device's work until the CPU knows of it, milliseconds: what any wait costs. Measured on
  /// first use, by three waits for nothing.
  double round_trip_ms();
  /// Pixels by which the rasteriser may move corners.
  float snap() const;
  culling::ImageSamples samples() const;
  culling::SampleTest sample_test(const Frame& frame) const {
    return {frame.view, frame.snapshot.bounds().origin, samples()};
  }
  /// The test against the image's depth pyramid.
  culling::OcclusionTest occlusion_test(const Frame& frame) const { return occlusion_test(frame, image->pyramid); }
  culling::OcclusionTest occlusion_test(const Frame& frame, const culling::DepthPyramid& pyramid) const;
  /// Measures the projected areas of all items of the snapshot on first use.
  culling::ContributionTest contribution_test(const Frame& frame);
  /// By the outlines of boxes alone, which suffice to order items: their solid areas are not measured for it.
  culling::ContributionTest outline_test(const Frame& frame) const;
  /// Whether the setting and the image allow it. One sample per pixel alone has one depth to test against.
  bool may_test_occlusion() const {
    return config.culling.occlusion != OcclusionChoice::kOff && target().format().samples == 1;
  }

  /// Begins an image: clears it, or what is drawn in its place.
  core::Expected<void> clear(const render::RenderTarget& canvas);
  /// By how much meshes drawn in a view may be off; none where no mesh has levels.
  std::optional<lod::ImageError> mesh_error(const core::View& view, double coarsened = 0.0) const;
  /// Draws a set beside what the target holds of the same view, with meshes in the detail that the view needs.
  core::Expected<void> draw(const Frame& frame, const DrawRequest& request);
  /// Builds the image's depth pyramid from the depth of `from`.
  core::Expected<void> read_back_depth(const core::View& view, const render::RenderTarget& from);
  void clear_pyramid() { image->pyramid.clear(target().width(), target().height()); }
  /// A target in the image's format, unless it is there, with a pixel for so many along either axis of the image.
  core::Expected<void> make_like_image(std::optional<render::RenderTarget>& made, double coarseness) const;
  /// Draws all of another image over the image.
  core::Expected<void> enlarge(const render::RenderTarget& other);
  /// Puts the image into a frame's external target.
  core::Expected<void> compose(const Frame& frame);
};

}  // namespace sightline::engine
