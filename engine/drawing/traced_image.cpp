#include "sightline/engine/drawing/internal/traced_image.h"

#include <algorithm>
#include <cmath>

#include "sightline/core/internal/clock.h"
#include "sightline/core/internal/store.h"
#include "sightline/engine/drawing/internal/draw_context.h"

namespace sightline::engine {

#if SIGHTLINE_HAS_RAYTRACE

core::Expected<DrawCounts> TracedImage::draw(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                                             culling::SlotBits over) {
  constexpr double kShare = 0.98;  // of the budget
  const render::RenderTarget& target = context.target();
  const render::Renderer& looks = *context.renderer;
  const double deadline = frame.budget_began + kShare * 1e-3 * context.config.losses.budget_ms - show_seconds_;
  const auto traced = image_.draw(*frame.tracer, frame.view, target.width(), target.height(), over,
                                  {looks.lighting, looks.sun, looks.background}, context.threads, deadline);
  if (!traced) return tl::unexpected(traced.error());
  complete_ = traced->kept + traced->filled == 0;
  if (auto done = show(context, frame, visible); !done) return tl::unexpected(done.error());
  const double pixels = double(target.width()) * target.height();
  const auto items = std::int64_t(frame.snapshot.count(visible));
  DrawCounts counts{-1, items};
  counts.pending =
      std::max<std::int64_t>(1, items);  // until the rasteriser has drawn them, by whom all images are alike
  counts.coarseness = std::sqrt(pixels / std::max(1.0, pixels - double(traced->filled)));
  counts.earlier = double(traced->kept) / pixels;
  return counts;
}

core::Expected<void> TracedImage::show(DrawContext& context, const Frame& frame, const core::VisibleSet& visible) {
  const double begin = core::now_seconds();
  const render::RenderTarget& target = context.target();
  context.image->meshes = {};
  if (target.format().samples == 1) {
    target.write(image_.points().colours(), image_.points().depths(), image_.points().ids());
  } else {
    const auto create = [&] {
      return render::RenderTarget::create(context.context, target.width(), target.height(), {.ids = target.has_ids()});
    };
    if (!single_)
      if (auto done = core::store(create(), single_); !done) return done;
    single_->write(image_.points().colours(), image_.points().depths(), image_.points().ids());
    if (auto done = context.enlarge(*single_); !done) return done;
  }
  lines_.clear();
  lines_.generation = visible.generation;
  if (!frame.lines.empty())
    visible.for_each_slot([&](core::Slot slot) {
      if (culling::contains(frame.lines, slot)) lines_.single_slots.push_back(slot);
    });
  std::sort(lines_.single_slots.begin(), lines_.single_slots.end());
  auto done = lines_.single_slots.empty() ? core::Expected<void>() : context.draw(frame, {lines_, target});
  context.gl().Finish();
  show_seconds_ = core::now_seconds() - begin;
  return done;
}

void TracedImage::forget() {
  image_.forget();
  complete_ = false;
}

#else

core::Expected<DrawCounts> TracedImage::draw(DrawContext&, const Frame&, const core::VisibleSet&, culling::SlotBits) {
  return core::fail("engine: this build traces no rays");
}
core::Expected<void> TracedImage::show(DrawContext&, const Frame&, const core::VisibleSet&) {
  return {};
}
void TracedImage::forget() {}

#endif

}  // namespace sightline::engine
