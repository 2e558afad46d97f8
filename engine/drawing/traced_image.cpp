#include "sightline/engine/drawing/internal/traced_image.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "sightline/core/internal/clock.h"
#include "sightline/core/internal/store.h"
#include "sightline/engine/drawing/internal/draw_context.h"
#include "sightline/engine/drawing/internal/translucent.h"
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/raytrace/internal/moving_image.h"
#endif

namespace sightline::engine {

#if SIGHTLINE_HAS_RAYTRACE

core::Expected<DrawCounts> TracedImage::draw(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                                             culling::SlotBits over) {
  constexpr double kShare = 0.98;  // of the budget
  const render::RenderTarget& target = context.target();
  const render::Renderer& looks = *context.renderer;
  const double deadline = frame.budget_began + kShare * 1e-3 * context.config.losses.budget_ms - show_seconds_;
  if (!image_) image_ = std::make_shared<raytrace::MovingImage>();
  const raytrace::TracedPart all{frame.tracer, over};
  const auto traced = image_->draw(
      {{{&all, 1}}, frame.view, target.width(), target.height(), looks.lighting, looks.sun, looks.background},
      context.threads, deadline);
  if (!traced) return tl::unexpected(traced.error());
  complete_ = traced->kept + traced->filled == 0;
  if (auto done = show(context, frame, visible); !done) return tl::unexpected(done.error());
  const double pixels = double(target.width()) * target.height();
  const auto items = std::int64_t(frame.snapshot.count(visible));
  DrawCounts counts{-1, items};
  counts.pending = std::max<std::int64_t>(1, items);  // until the rasteriser has drawn them
  counts.coarseness = std::sqrt(pixels / std::max(1.0, pixels - double(traced->filled)));
  counts.earlier = double(traced->kept) / pixels;
  return counts;
}

void TracedImage::begin(DrawContext& context, const core::View& view, const render::RenderTarget& drawn) {
  if (!image_) image_ = std::make_shared<raytrace::MovingImage>();
  if (image_->shows(view)) return;
  const std::size_t pixels = std::size_t(drawn.width()) * std::size_t(drawn.height());
  std::vector<std::uint32_t> colours(pixels), ids(drawn.has_ids() ? pixels : 0);
  std::vector<float> depths(pixels);
  drawn.read(colours, depths, ids);
  image_->begin(view, drawn.width(), drawn.height(), {colours, depths, ids}, context.threads);
}

core::Expected<void> TracedImage::show(DrawContext& context, const Frame& frame, const core::VisibleSet& visible) {
  const double begin = core::now_seconds();
  const render::RenderTarget& target = context.target();
  const raytrace::PointImage::Pixels image = image_->points().pixels();
  context.image->meshes = {};
  if (target.format().samples == 1) {
    target.write(image.colours, image.depths, image.ids);
  } else {
    const auto create = [&] {
      return render::RenderTarget::create(context.context, target.width(), target.height(), {.ids = target.has_ids()});
    };
    if (!single_)
      if (auto done = core::store(create(), single_); !done) return done;
    single_->write(image.colours, image.depths, image.ids);
    if (auto done = context.enlarge(*single_); !done) return done;
  }
  core::Expected<void> done;
  if (!frame.lines.empty()) {
    part(visible, frame.lines, lines_, others_);
    if (lines_.count() > 0) done = context.draw(frame, {lines_, target});
  }
  context.gl().Finish();
  show_seconds_ = core::now_seconds() - begin;
  return done;
}

std::vector<std::uint64_t> TracedImage::shown_slots(const core::Snapshot& snapshot) const {
  std::vector<std::uint64_t> bits(culling::bit_words(snapshot.size()));
  std::uint32_t last = 0;
  for (const std::uint32_t id : image_->points().pixels().ids) {
    if (id == std::exchange(last, id) || id == 0) continue;
    const core::Slot slot = snapshot.slot(core::ItemId(id - 1));
    if (slot != core::kNone) bits[slot / 64] |= std::uint64_t(1) << slot % 64;
  }
  return bits;
}

std::size_t TracedImage::points_bytes() const {
  return image_ ? image_->points().memory_bytes() : 0;
}

void TracedImage::forget() {
  if (image_) image_->forget();
  complete_ = false;
}

#else

core::Expected<DrawCounts> TracedImage::draw(DrawContext&, const Frame&, const core::VisibleSet&, culling::SlotBits) {
  return core::fail("engine: this build traces no rays");
}
core::Expected<void> TracedImage::show(DrawContext&, const Frame&, const core::VisibleSet&) {
  return {};
}
std::vector<std::uint64_t> TracedImage::shown_slots(const core::Snapshot&) const {
  return {};
}
void TracedImage::begin(DrawContext&, const core::View&, const render::RenderTarget&) {}
void TracedImage::forget() {}
std::size_t TracedImage::points_bytes() const {
  return 0;
}

#endif

}  // namespace sightline::engine
