#include "sightline/engine/drawing/internal/image_overlays.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline::engine {
namespace {

/// Pixels in which an outline of these items may lie: around their boxes. All pixels where a box reaches behind the
/// eye, and for so many items that drawing them takes longer than the outline.
render::PixelBox pixels_around(const core::View& view, const core::Snapshot& snapshot, const core::VisibleSet& items,
                               int width, int height) {
  constexpr std::size_t kMostItems = 10'000;
  constexpr double kMargin = 4.0;  // pixels: the line, and what rounding may do to the boxes
  const render::PixelBox all{0, 0, width, height};
  const core::ItemBounds& bounds = snapshot.bounds();
  if (snapshot.count(items) > kMostItems) return all;
  core::dvec2 low(std::numeric_limits<double>::max()), high(-low);
  bool behind = false;
  items.for_each_slot([&](core::Slot slot) {
    if (bounds.vacant(slot)) return;
    const core::Aabb box = bounds.box(slot);
    for (int corner = 0; corner < 8; ++corner) {
      const core::dvec3 at((corner & 1 ? box.max : box.min).x, (corner & 2 ? box.max : box.min).y,
                           (corner & 4 ? box.max : box.min).z);
      const core::dvec4 clip = view.clip_from_world() * core::dvec4(bounds.origin + at, 1.0);
      behind |= !(clip.w > 0.0);
      const core::dvec2 pixel = 0.5 * (core::dvec2(clip.x, clip.y) / clip.w + 1.0) * core::dvec2(width, height);
      low = glm::min(low, pixel);
      high = glm::max(high, pixel);
    }
  });
  if (behind || !(low.x <= high.x && low.y <= high.y)) return all;
  const core::dvec2 from = glm::clamp(glm::floor(low - kMargin), core::dvec2(0.0), core::dvec2(width, height)),
                    to = glm::clamp(glm::ceil(high + kMargin), from, core::dvec2(width, height));
  return {int(from.x), int(from.y), int(to.x - from.x), int(to.y - from.y)};
}

bool empty(const core::VisibleSet& set) {
  return set.ranges.empty() && set.single_slots.empty();
}

/// Eye depths between which the boxes of a set lie; none of them is negative in perspective views.
glm::vec2 depth_range(const core::View& view, const core::ItemBounds& bounds, const core::VisibleSet& set) {
  if (empty(set)) return {0.0f, 0.0f};
  const core::dmat4& eye = view.eye_from_world();
  const core::dvec3 axis(-eye[0][2], -eye[1][2], -eye[2][2]);
  const double at_origin = glm::dot(axis, bounds.origin) - eye[3][2];
  double nearest = std::numeric_limits<double>::max(), farthest = -nearest;
  set.for_each_slot([&](core::Slot slot) {
    if (bounds.vacant(slot)) return;
    const core::Aabb box = bounds.box(slot);
    const core::dvec3 low(box.min), high(box.max);
    const double middle = at_origin + glm::dot(axis, 0.5 * (low + high));
    const double half_extent = glm::dot(glm::abs(axis), 0.5 * (high - low));
    nearest = std::min(nearest, middle - half_extent);
    farthest = std::max(farthest, middle + half_extent);
  });
  if (!view.orthographic()) nearest = std::max(nearest, 0.0);
  return {float(nearest), float(std::max(nearest, farthest))};
}

}  // namespace

render::Overlays& ImageOverlays::overlays(const DrawContext& context) {
  if (!overlays_) overlays_.emplace(context.gl());
  return *overlays_;
}

const core::VisibleSet& ImageOverlays::split(const DrawContext& context, const core::VisibleSet& visible) {
  if (!any(context)) return visible;
  part(visible, items(), over_, opaque_);
  return opaque_;
}

glm::vec2 ImageOverlays::blend_range(const core::View& view, const core::Snapshot& snapshot,
                                     const core::VisibleSet& visible) {
  part(visible, items(), over_, unused_);
  part(over_, translucent_.ghosts(), ghosts_, blended_);
  return depth_range(view, snapshot.bounds(), blended_);
}

core::Expected<void> ImageOverlays::finish(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                                           DrawCounts& counts) {
  ImageState& image = *context.image;
  const bool finished = image.unchanged && !frame.target, overlaid = any(context);
  if (!finished) image.meshes_over = {};
  if (!finished && change_image(context)) {
    if (image.unchanged && image.beside) image.refined->copy_to(image.target);
    if (shades(context, counts))
      if (auto done = draw_looks(context, frame, overlaid ? opaque_ : visible); !done) return done;
  }
  if (frame.target)
    if (auto done = context.compose(frame); !done) return done;
  return finished || !overlaid ? core::Expected<void>() : draw_over(context, frame, visible, counts);
}

/// With a budget, depth shading waits until the image is complete: it takes time in proportion to the image, and more
/// items could not be drawn to a shaded image. Moving images that were once incomplete have none until they are still,
/// so that it does not flicker.
bool ImageOverlays::shades(const DrawContext& context, const DrawCounts& counts) const {
  if (context.config.losses.budget_ms <= 0.0) return true;
  ImageState& image = *context.image;
  if (image.unchanged && !image.beside) return false;  // the image has it already
  return image.shaded = counts.pending == 0 && (image.shaded || image.refines);
}

core::Expected<void> ImageOverlays::draw_looks(DrawContext& context, const Frame& frame,
                                               const core::VisibleSet& opaque) {
  const DepthShading& depth_shading = context.config.drawing.looks.depth_shading;
  if (depth_shading.any()) {
    if (!depth_shading_pass_) depth_shading_pass_.emplace(context.gl());
    auto done =
        depth_shading_pass_->draw(context.target(), frame.view, depth_shading.strength, depth_shading.edge_lines);
    if (!done) return done;
  }
  if (!context.config.drawing.looks.edges.any()) return {};
  // By the depth of the whole image, whichever way it was drawn: so that the same items have lines in any case.
  if (context.target().format().samples == 1) {
    if (auto read = context.read_back_depth(frame.view, context.target()); !read) return read;
    context.image->pyramid_valid = true;
  }
  return edges_.draw(context, frame, leave_out_invisible(context, frame, opaque));
}

/// The items of a set that are large enough and cover a sample, as far as the tests know.
const core::VisibleSet& ImageOverlays::leave_out_invisible(DrawContext& context, const Frame& frame,
                                                           const core::VisibleSet& items) {
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  const float least = context.config.losses.min_projected_area;
  const core::VisibleSet* left = &items;
  if (least > 0.0f) {
    context.contribution_test(frame).filter(bounds, *left, least, unused_, {}, frame.lines);
    left = &unused_;
  }
  if (context.image->pyramid_valid) {
    context.occlusion_test(frame).filter(bounds, *left, tested_, frame.lines, &context.threads);
    left = &tested_;
  } else if (context.config.culling.sample_test) {
    context.sample_test(frame).filter(bounds, *left, tested_, frame.lines, &context.threads);
    left = &tested_;
  }
  return *left;
}

namespace {

/// Sets the draw lists for a set, in the full detail of its meshes, and returns a pass that draws them.
core::Expected<render::DrawPass> list_in_full(DrawContext& context, const Frame& frame, const core::VisibleSet& set,
                                              const render::RenderTarget& onto) {
  auto done = context.choice.update(*context.lists, *context.scene, frame.snapshot, set, {frame.view});
  return done.map([&] {
    return render::DrawPass{frame.view, frame.snapshot, *context.scene, *context.lists, onto, render::Surface::kGhost};
  });
}

/// Puts a layer over the image, and over the application's framebuffer, if there is one.
template <class Put>
core::Expected<void> put_over(const DrawContext& context, const Frame& frame, const Put& put) {
  const render::RenderTarget& target = context.target();
  gl::ExternalTarget image{target.framebuffer().id(), 0, 0, target.width(), target.height()};
  image.near_depth = 1.0;
  image.far_depth = 0.0;
  if (auto done = put(image); !done || !frame.target) return done;
  return put(*frame.target);
}

}  // namespace

core::Expected<void> ImageOverlays::draw_over(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                                              DrawCounts& counts) {
  if (auto done = draw_translucent(context, frame, counts); !done) return done;
  return draw_outline(context, frame, visible);
}

core::Expected<void> ImageOverlays::draw_translucent(DrawContext& context, const Frame& frame, DrawCounts& counts) {
  if (empty(over_)) return {};
  part(over_, translucent_.ghosts(), ghosts_, blended_);
  const glm::vec2 depths =
      frame.blend_range ? *frame.blend_range : depth_range(frame.view, frame.snapshot.bounds(), blended_);
  const core::VisibleSet& drawn = leave_out_invisible(context, frame, over_);
  const auto count = std::int64_t(frame.snapshot.count(drawn));
  counts.items_drawn += count;
  if (counts.sampled >= 0) counts.sampled += count;
  part(drawn, translucent_.ghosts(), ghosts_, blended_);
  if (auto done = draw_blended(context, frame, depths); !done) return done;
  return draw_ghosts(context, frame);
}

core::Expected<void> ImageOverlays::draw_blended(DrawContext& context, const Frame& frame, const glm::vec2& range) {
  if (empty(blended_)) return {};
  render::Overlays& over = overlays(context);
  const auto sums = over.begin_sums(context.target());
  if (!sums) return tl::unexpected(sums.error());
  auto pass = list_in_full(context, frame, blended_, context.target());
  if (!pass) return tl::unexpected(pass.error());
  context.image->meshes_over += context.choice.counts();
  pass->surface = render::Surface::kBlended;
  pass->sums = *sums;
  pass->range = range;
  auto done = context.renderer->draw(*pass);
  if (done) done = over.resolve_sums(context.context, context.target());
  if (!done) return done;
  return put_over(context, frame, [&](const gl::ExternalTarget& target) { return over.put_layer(target); });
}

core::Expected<void> ImageOverlays::draw_ghosts(DrawContext& context, const Frame& frame) {
  if (empty(ghosts_)) return {};
  render::Overlays& over = overlays(context);
  const auto layer = over.begin_layer(context.context, context.target(), true);
  if (!layer) return tl::unexpected(layer.error());
  const auto pass = list_in_full(context, frame, ghosts_, **layer);
  if (!pass) return tl::unexpected(pass.error());
  context.image->meshes_over += context.choice.counts();
  if (auto done = context.renderer->draw(*pass); !done) return done;
  return put_over(context, frame, [&](const gl::ExternalTarget& target) { return over.put_layer(target); });
}

/// Draws an outline around all outlined items, occluded ones included.
core::Expected<void> ImageOverlays::draw_outline(DrawContext& context, const Frame& frame,
                                                 const core::VisibleSet& visible) {
  if (translucent_.outlined().empty()) return {};
  part(visible, translucent_.outlined(), outlined_, unused_);
  if (empty(outlined_)) return {};
  const auto within = draw_outlined(context, frame, outlined_);
  if (!within) return tl::unexpected(within.error());
  return put_over(context, frame, [&](const gl::ExternalTarget& target) {
    return overlays_->put_outline(context.target(), context.config.drawing.outline_colour, *within, target);
  });
}

/// Draws items into the layer, as Overlays::put_outline() needs it. Returns the pixels in which the outline may lie.
core::Expected<render::PixelBox> ImageOverlays::draw_outlined(DrawContext& context, const Frame& frame,
                                                              const core::VisibleSet& items) {
  const auto layer = overlays(context).begin_layer(context.context, context.target(), false);
  if (!layer) return tl::unexpected(layer.error());
  const auto pass = list_in_full(context, frame, items, **layer);
  if (!pass) return tl::unexpected(pass.error());
  if (auto done = context.renderer->draw(*pass); !done) return tl::unexpected(done.error());
  return pixels_around(frame.view, frame.snapshot, items, context.target().width(), context.target().height());
}

core::Expected<void> ImageOverlays::put_outline(DrawContext& context, const Frame& frame, const core::VisibleSet& items,
                                                const gl::ExternalTarget& over) {
  const auto within = draw_outlined(context, frame, items);
  if (!within) return tl::unexpected(within.error());
  return overlays_->put_outline(context.target(), context.config.drawing.outline_colour, *within, over);
}

}  // namespace sightline::engine
