#include "sightline/engine/drawing/internal/draw_context.h"

#include <algorithm>
#include <limits>

#include "sightline/core/internal/clock.h"

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

culling::OcclusionTest DrawContext::occlusion_test(const core::View& view, const core::ItemBounds& bounds) const {
  return {view,
          bounds.origin,
          target().width(),
          target().height(),
          image->pyramid,
          render::RenderTarget::orthographic_error(view),
          snap()};
}

culling::ContributionTest DrawContext::contribution_test(const core::View& view, const core::Snapshot& snapshot) {
  return {view, snapshot.bounds().origin, target().width(), target().height(), solid_areas.of(snapshot)};
}

core::Expected<void> DrawContext::clear(const render::RenderTarget& canvas) {
  image->meshes = {};
  return renderer->clear(canvas);
}

std::optional<lod::ImageError> DrawContext::mesh_error(const core::View& view) const {
  if (!mesh_details.any()) return std::nullopt;
  return lod::ImageError(view, target().width(), target().height(), std::max(config.losses.lod_error, coarsened));
}

core::Expected<void> DrawContext::list(const core::View& view, const core::Snapshot& snapshot,
                                       const core::VisibleSet& set) {
  gpuscene::DrawnIn in{&view};
  const std::optional<lod::ImageError> error = mesh_error(view);
  if (error) in.error = &*error;
  in.clusters = clusters;
  std::optional<culling::TriangleTest> triangles;
  if (software() && config.culling.sample_test) in.triangles = &triangles.emplace(view, samples());
  in.threads = &threads;
  auto done = lists->update(snapshot, *scene, set, in);
  image->meshes += lists->mesh_counts();
  return done;
}

core::Expected<void> DrawContext::draw(const core::View& view, const core::Snapshot& snapshot,
                                       const core::VisibleSet& set) {
  if (auto done = clear(target()); !done) return done;
  return draw_more(view, snapshot, set, target());
}

core::Expected<void> DrawContext::draw_more(const core::View& view, const core::Snapshot& snapshot,
                                            const core::VisibleSet& set, const render::RenderTarget& onto,
                                            const gl::TextureBuffer* materials) {
  if (auto done = list(view, snapshot, set); !done) return done;
  return renderer->draw_more(view, snapshot, *scene, *lists, onto, materials);
}

core::Expected<void> DrawContext::read_back_depth(const core::View& view, const render::RenderTarget& from) {
  if (auto done = from.read_distances(view, image->distances); !done) return done;
  image->pyramid.build(image->distances, target().width(), target().height());
  return {};
}

core::Expected<void> DrawContext::compose() {
  if (!compositor) compositor.emplace(gl());
  return compositor->draw(target(), *external, renderer->background);
}

}  // namespace sightline::engine
