#include "sightline/engine/drawing/internal/draw_context.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/core/internal/clock.h"
#include "sightline/core/internal/store.h"

namespace sightline::engine {

/// A fence is a command, so that drivers do not answer by themselves.
double DrawContext::round_trip_ms() {
  if (measured_round_trip_ms) return *measured_round_trip_ms;
  constexpr GLuint64 kLongest = 10'000'000'000;  // ns
  gl().Finish();
  double least = std::numeric_limits<double>::max();
  for (int i = 0; i < 3; ++i) {
    const double begin = core::now_seconds();
    const GLsync fence = gl().FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    if (!fence) return 0.0;  // no memory; it is tried again
    gl().ClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, kLongest);
    gl().DeleteSync(fence);
    least = std::min(least, 1e3 * (core::now_seconds() - begin));
  }
  return *(measured_round_trip_ms = least);
}

float DrawContext::snap() const {
  return culling::rasteriser_snap(context.capabilities().subpixel_bits, target().width(), target().height());
}

culling::ImageSamples DrawContext::samples() const {
  culling::ImageSamples samples{target().width(), target().height(), {}, snap()};
  for (const glm::vec2& offset : target().sample_offsets()) samples.offsets.push_back({offset.x, offset.y});
  return samples;
}

culling::OcclusionTest DrawContext::occlusion_test(const Frame& frame, const culling::DepthPyramid& pyramid) const {
  return {frame.view,
          frame.snapshot.bounds().origin,
          target().width(),
          target().height(),
          pyramid,
          render::RenderTarget::orthographic_error(frame.view),
          snap()};
}

culling::ContributionTest DrawContext::contribution_test(const Frame& frame) {
  return {frame.view, frame.snapshot.bounds().origin, target().width(), target().height(),
          solid_areas.of(frame.snapshot)};
}

culling::ContributionTest DrawContext::outline_test(const Frame& frame) const {
  return {frame.view, frame.snapshot.bounds().origin, target().width(), target().height()};
}

core::Expected<void> DrawContext::clear(const render::RenderTarget& canvas) {
  image->meshes = {};
  return renderer->clear(canvas);
}

std::optional<lod::ImageError> DrawContext::mesh_error(const core::View& view, double coarsened) const {
  if (!mesh_details.any()) return std::nullopt;
  return lod::ImageError(view, target().width(), target().height(), std::max(config.losses.lod_error, coarsened));
}

core::Expected<void> DrawContext::draw(const Frame& frame, const DrawRequest& request) {
  const core::View& view = frame.view;
  MeshRules rules{.view = view, .clusters = request.clusters, .threads = &threads};
  const std::optional<lod::ImageError> error = mesh_error(view, request.coarsened);
  if (error) rules.error = &*error;
  std::optional<culling::TriangleTest> triangles;
  if (software() && config.culling.sample_test) rules.triangles = &triangles.emplace(view, samples());
  const auto draw_lists = [&] {
    return renderer->draw({.view = view,
                           .snapshot = frame.snapshot,
                           .scene = *scene,
                           .lists = *lists,
                           .target = request.onto,
                           .materials = request.materials});
  };
  if (!software())
    rules.draw_others = [&] {
      auto done = draw_lists();
      gl().Flush();
      return done;
    };
  auto done = choice.update(*lists, *scene, frame.snapshot, request.set, rules);
  image->meshes += choice.counts();
  return done ? draw_lists() : done;
}

core::Expected<void> DrawContext::read_back_depth(const core::View& view, const render::RenderTarget& from) {
  if (auto done = from.read_distances(view, image->distances); !done) return done;
  image->pyramid.build(image->distances, target().width(), target().height());
  return {};
}

core::Expected<void> DrawContext::make_like_image(std::optional<render::RenderTarget>& made, double coarseness) const {
  if (made) return {};
  const auto pixels = [&](int side) { return std::max(1, int(std::lround(side / coarseness))); };
  return core::store(
      render::RenderTarget::create(context, pixels(target().width()), pixels(target().height()), target().format()),
      made);
}

core::Expected<void> DrawContext::enlarge(const render::RenderTarget& other) {
  if (!enlarge_pass) enlarge_pass.emplace(gl());
  return enlarge_pass->draw(other, image->target);
}

core::Expected<void> DrawContext::compose(const Frame& frame) {
  if (!compositor) compositor.emplace(gl());
  return compositor->draw(target(), *frame.target, renderer->background);
}

}  // namespace sightline::engine
