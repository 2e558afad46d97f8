// What Drawing does to the complete picture: relief, then transparent items, ghosts and outlines over it.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sightline/engine/internal/drawing.h"

namespace sightline::engine {
namespace {

/// Pixels in which an outline of these items may lie: around their boxes. All pixels where one reaches behind the eye,
/// and for so many items that drawing them takes longer than the outline.
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
      const core::dvec2 place = 0.5 * (core::dvec2(clip.x, clip.y) / clip.w + 1.0) * core::dvec2(width, height);
      low = glm::min(low, place);
      high = glm::max(high, place);
    }
  });
  if (behind || !(low.x <= high.x && low.y <= high.y)) return all;
  const core::dvec2 from = glm::clamp(glm::floor(low - kMargin), core::dvec2(0.0), core::dvec2(width, height)),
                    to = glm::clamp(glm::ceil(high + kMargin), from, core::dvec2(width, height));
  return {int(from.x), int(from.y), int(to.x - from.x), int(to.y - from.y)};
}

bool empty(const core::VisibleSet& set) {
  return set.ranges.empty() && set.items.empty();
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
    const double reach = glm::dot(glm::abs(axis), 0.5 * (high - low));
    nearest = std::min(nearest, middle - reach);
    farthest = std::max(farthest, middle + reach);
  });
  if (!view.orthographic()) nearest = std::max(nearest, 0.0);
  return {float(nearest), float(std::max(nearest, farthest))};
}

}  // namespace

/// Parts what is visible: what makes the picture is returned, and the rest is for draw_overlays().
const core::VisibleSet& Drawing::part_overlays(const core::VisibleSet& visible) {
  part(visible, translucent_.bits(), over_, solid_);
  return solid_;
}

core::Expected<void> Drawing::finish_picture(const Culled& culled) {
  if (!changes_picture()) return {};
  if (picture_->kept && !external_) return {};  // finished
  if (picture_->kept) picture_->refined->copy_to(picture_->target);
  if (relief_.any()) {
    if (!relief_pass_) relief_pass_.emplace(context_.functions());
    if (auto done = relief_pass_->draw(picture_->target, culled.view, relief_.shading, relief_.lines); !done)
      return done;
  }
  return has_overlays() ? draw_overlays(culled) : core::Expected<void>();
}

core::Expected<void> Drawing::draw_overlays(const Culled& culled) {
  if (!overlays_) overlays_.emplace(context_.functions());
  if (external_) {
    if (auto done = compose(); !done) return done;
    picture_->composed = true;
  }
  if (auto done = draw_translucent(culled.with(over_)); !done) return done;
  return draw_outline(culled);
}

glm::vec2 Drawing::blend_range(const core::View& view, const core::Snapshot& snapshot,
                               const core::VisibleSet& visible) {
  part(visible, translucent_.bits(), over_, unused_);
  part(over_, translucent_.ghosts(), ghosts_, blended_);
  return depth_range(view, snapshot.bounds(), blended_);
}

/// Of what is drawn over the picture, what contributes enough to it and covers a sample, as far as the tests know.
const core::VisibleSet& Drawing::worth_drawing(const Culled& culled) {
  const core::ItemBounds& bounds = culled.snapshot.bounds();
  const core::VisibleSet* left = &culled.visible;
  if (contribution_ > 0.0f) {
    contribution_test(culled.view, culled.snapshot).filter(bounds, *left, contribution_, tested_, {}, culled.lines);
    std::swap(tested_, unused_);
    left = &unused_;
  }
  if (depth_known_) {
    occlusion_test(culled.view, bounds.origin).filter(bounds, *left, tested_, culled.lines);
    left = &tested_;
  } else if (sample_test_) {
    culling::SampleTest(culled.view, bounds.origin, samples()).filter(bounds, *left, tested_, culled.lines);
    left = &tested_;
  }
  return *left;
}

/// Puts a layer over the picture, and over the application's framebuffer, if there is one.
core::Expected<void> Drawing::put_over(
    const std::function<core::Expected<void>(const core::ExternalTarget&)>& put) const {
  core::ExternalTarget picture{picture_->target.framebuffer().id(), 0, 0, picture_->target.width(),
                               picture_->target.height()};
  picture.near_depth = 1.0;
  picture.far_depth = 0.0;
  if (auto done = put(picture); !done || !external_) return done;
  return put(*external_);
}

core::Expected<void> Drawing::draw_translucent(const Culled& culled) {
  const auto& [view, snapshot, visible, lines, hierarchy] = culled;
  if (empty(visible)) return {};
  part(visible, translucent_.ghosts(), ghosts_, blended_);
  const glm::vec2 range = blend_range_ ? *blend_range_ : depth_range(view, snapshot.bounds(), blended_);
  const core::VisibleSet& shown = worth_drawing(culled);
  counts_.shown += std::int64_t(snapshot.count(shown));
  if (counts_.sampled >= 0) counts_.sampled += std::int64_t(snapshot.count(shown));
  part(shown, translucent_.ghosts(), ghosts_, blended_);
  const auto put_layer = [&](const core::ExternalTarget& over) { return overlays_->put_layer(over); };
  if (!empty(blended_)) {
    const auto sums = overlays_->begin_sums(picture_->target);
    if (!sums) return tl::unexpected(sums.error());
    auto done = lists_->update(snapshot, *scene_, blended_, &view);
    if (done) done = renderer_->draw_blended(view, snapshot, *scene_, *lists_, picture_->target, **sums, range);
    if (done) done = overlays_->resolve_sums(context_, picture_->target);
    if (done) done = put_over(put_layer);
    if (!done) return done;
  }
  if (empty(ghosts_)) return {};
  const auto layer = overlays_->begin_layer(context_, picture_->target, true);
  if (!layer) return tl::unexpected(layer.error());
  if (auto done = lists_->update(snapshot, *scene_, ghosts_, &view); !done) return done;
  if (auto done = renderer_->draw_ghosts(view, snapshot, *scene_, *lists_, **layer); !done) return done;
  return put_over(put_layer);
}

/// Around all outlined items, hidden ones, too.
core::Expected<void> Drawing::draw_outline(const Culled& culled) {
  if (translucent_.outlined().empty()) return {};
  part(culled.visible, translucent_.outlined(), outlined_, unused_);
  if (empty(outlined_)) return {};
  const auto within = draw_outlined(culled.with(outlined_));
  if (!within) return tl::unexpected(within.error());
  return put_over([&](const core::ExternalTarget& over) {
    return overlays_->put_outline(picture_->target, outline_colour_, *within, over);
  });
}

/// Into the layer, as put_outline() needs it, and where the outline may lie.
core::Expected<render::PixelBox> Drawing::draw_outlined(const Culled& items) {
  const auto layer = overlays_->begin_layer(context_, picture_->target, false);
  if (!layer) return tl::unexpected(layer.error());
  auto done = lists_->update(items.snapshot, *scene_, items.visible, &items.view);
  if (done) done = renderer_->draw_ghosts(items.view, items.snapshot, *scene_, *lists_, **layer);
  if (!done) return tl::unexpected(done.error());
  return pixels_around(items.view, items.snapshot, items.visible, picture_->target.width(), picture_->target.height());
}

core::Expected<void> Drawing::put_outline(const Culled& items, const core::ExternalTarget& over) {
  if (!overlays_) overlays_.emplace(context_.functions());
  const auto within = draw_outlined(items);
  if (!within) return tl::unexpected(within.error());
  return overlays_->put_outline(picture_->target, outline_colour_, *within, over);
}

}  // namespace sightline::engine
