#include "sightline/engine/drawing/internal/opaque_items.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "sightline/core/internal/clock.h"
#include "sightline/culling/occlusion/internal/item_sizes.h"
#include "sightline/engine/internal/device_constants.h"

namespace sightline::engine {
namespace {

using culling::OcclusionMode;
using Trial = culling::OcclusionTrial::Frame;

/// Every `parts`-th block of the slots, from block `part` on.
core::VisibleSet part_of(const core::VisibleSet& visible, core::Slot parts, core::Slot part) {
  core::VisibleSet some;
  some.generation = visible.generation;
  for (const core::Slot slot : visible.single_slots)
    if (slot / core::kBlockSlots % parts == part) some.single_slots.push_back(slot);
  for (const core::SlotRange& range : visible.ranges) {
    const core::Slot end = range.first + range.count, from = range.first / core::kBlockSlots;
    for (core::Slot block = from + (part + parts - from % parts) % parts; block * core::kBlockSlots < end;
         block += parts) {
      const core::Slot first = std::max(range.first, block * core::kBlockSlots);
      some.ranges.push_back({first, std::min(end, (block + 1) * core::kBlockSlots) - first});
    }
  }
  return some;
}

/// Seconds at which all work is done.
double finished_at(const DrawContext& context) {
  context.gl().Finish();
  return core::now_seconds();
}

}  // namespace

core::Expected<DrawCounts> OpaqueItems::draw(DrawContext& context, const Frame& frame, const core::VisibleSet& visible,
                                             culling::SlotBits over) {
  const LossConfig& losses = context.config.losses;
  ImageState& image = *context.image;
  image.pyramid_valid = image.unchanged = false;
  if (losses.budget_ms <= 0.0) return draw_all(context, frame, visible, losses.min_projected_area);
  const bool stays = image.budget_view && core::same_image(*image.budget_view, frame.view);
  if (stays && image.whole) return keep_whole(image);
  const bool drawn = image.whole || (image.refines && image.budget.complete());  // all of the last image
  image.whole = false;
  const bool refines = stays && !frame.at_rest && image.shows_traced() && !image.traced->complete();
  if (!stays) image.shown_step = 0;
  if (!stays && image.traced) image.traced->shown = false;
  const bool moves = context.software() && !frame.shows_unseen && !frame.aside() && (!stays || refines);
  if (!moves) return in_budget_.draw(context, frame, visible);
  image.resolution.begin(std::int64_t(frame.snapshot.count(visible)));
  if (frame.at_rest && image.resolution.step() > 0) return in_budget_.draw(context, frame, visible);
  if (frame.tracer && (refines || image.resolution.step() > 0)) {
    if (!image.traced) image.traced.emplace();
    if (image.budget_view && drawn)
      image.traced->begin(context, *image.budget_view, image.beside ? *image.refined : image.target);
    return draw_traced(context, frame, visible, over);
  }
  if (stays) return in_budget_.draw(context, frame, visible);
  return draw_moving(context, frame, visible);
}

/// The first frame after a motion whose last image has all pixels leaves it as it is but for what is drawn over it,
/// which may have waited for that: depth shading. Later ones draw nothing.
DrawCounts OpaqueItems::keep_whole(ImageState& image) {
  image.unchanged = std::exchange(image.refines, true);
  if (!image.unchanged && image.beside) image.refined->copy_to(image.target);
  return image.budget_counts;
}

/// All of a moving image, by rays. At rest they go on until they have met every pixel.
core::Expected<DrawCounts> OpaqueItems::draw_traced(DrawContext& context, const Frame& frame,
                                                    const core::VisibleSet& visible, culling::SlotBits over) {
  ImageState& image = *context.image;
  image.budget_view = frame.view;
  image.refines = false;
  image.traced->shown = true;
  auto counts = image.traced->draw(context, frame, visible, over);
  if (counts) image.budget_counts = *counts;
  return counts;
}

/// All of a moving image, with as few pixels as its time asks for. It is not complete before it is drawn with all of
/// them, so what it shows is pending until then.
core::Expected<DrawCounts> OpaqueItems::draw_moving(DrawContext& context, const Frame& frame,
                                                    const core::VisibleSet& visible) {
  ImageState& image = *context.image;
  image.budget_view = frame.view;
  image.refines = false;
  image.shown_step = image.resolution.step();
  image.whole = image.shown_step == 0;
  auto counts = image.whole ? draw_whole(context, frame, visible) : draw_smaller(context, frame, visible);
  if (!counts) return counts;
  context.gl().Finish();
  image.resolution.took(1e3 * (core::now_seconds() - frame.budget_began), context.config.losses.budget_ms);
  image.budget_counts = *counts;
  return counts;
}

/// With all pixels. What is drawn over it later must not be drawn twice: then a copy is kept without that.
core::Expected<DrawCounts> OpaqueItems::draw_whole(DrawContext& context, const Frame& frame,
                                                   const core::VisibleSet& visible) {
  ImageState& image = *context.image;
  auto counts = draw_all(context, frame, visible, context.config.losses.min_projected_area);
  image.beside = frame.overlaid || context.config.drawing.looks.finish();
  if (!counts || !image.beside) return counts;
  if (auto done = context.make_like_image(image.refined, 1.0); !done) return tl::unexpected(done.error());
  image.target.copy_to(*image.refined);
  return counts;
}

core::Expected<DrawCounts> OpaqueItems::draw_smaller(DrawContext& context, const Frame& frame,
                                                     const core::VisibleSet& visible) {
  ImageState& image = *context.image;
  const double coarseness = image.resolution.coarseness();
  std::optional<render::RenderTarget>& smaller = image.smaller[image.shown_step];
  if (auto done = context.make_like_image(smaller, coarseness); !done) return tl::unexpected(done.error());
  const auto pixels = [](const render::RenderTarget& of) { return float(of.width()) * float(of.height()); };
  const float share = pixels(*smaller) / pixels(image.target);  // areas shrink as the pixels do
  std::swap(image.target, *smaller);
  auto counts = draw_all(context, frame, visible, share * context.config.losses.min_projected_area);
  std::swap(image.target, *smaller);
  image.pyramid_valid = false;  // it has the smaller image's size
  if (!counts) return counts;
  counts->coarseness = coarseness;
  counts->pending = std::max<std::int64_t>(1, counts->items_drawn);
  return context.enlarge(*smaller).map([&] { return *counts; });
}

core::Expected<DrawCounts> OpaqueItems::draw_all(DrawContext& context, const Frame& frame,
                                                 const core::VisibleSet& visible, float least_area) {
  const LossConfig& losses = context.config.losses;
  ImageState& image = *context.image;
  const core::VisibleSet& large = contribution_culling_.leave_out(context, frame, visible, least_area);
  const bool all_large = &large == &visible;
  const OcclusionMode mode = occlusion_mode(context, frame, large);
  if (mode == OcclusionMode::kOff) image.passes.reset(), image.clusters.reset();
  const bool all = all_large && frame.all && !frame.shows_unseen && !frame.aside();
  DrawStrategy& strategy = mode == OcclusionMode::kOff    ? static_cast<DrawStrategy&>(at_once_)
                           : all && prepass_.suits(frame) ? static_cast<DrawStrategy&>(prepass_)
                                                          : in_passes_;
  const bool measures = mode == OcclusionMode::kOnBesidePart;
  const bool timed = measures || trial_ == Trial::kTimedPlain || trial_ == Trial::kTimedTest;
  const double begin = timed ? finished_at(context) : 0.0;
  auto counts = strategy.draw(context, frame, large);
  if (!counts) return counts;
  const double ms = timed ? 1e3 * (finished_at(context) - begin) : 0.0;
  if (trial_ == Trial::kTimedPlain) occlusion_trial_.plain_took(ms - context.round_trip_ms());
  if (trial_ == Trial::kTimedTest) occlusion_trial_.test_took(ms - context.round_trip_ms());
  if (measures)
    if (auto done = measure(context, frame, large, ms); !done) return tl::unexpected(done.error());
  if (!all_large)
    counts->below_min_area = std::int64_t(frame.snapshot.count(visible)) - std::int64_t(frame.snapshot.count(large));
  if (counts->below_min_area == 0 || losses.contribution_mode == ContributionMode::kDrop) return counts;
  const float least_splat = losses.contribution_mode == ContributionMode::kStochastic ? least_area : 0.0f;
  const auto splats =
      contribution_culling_.draw(context, frame, visible, {image.was_large, least_splat, mode != OcclusionMode::kOff});
  if (!splats) return tl::unexpected(splats.error());
  counts->splats = *splats;
  return counts;
}

/// Between passes the depth is read back, which is a copy in memory on a software rasteriser. What it takes on a GPU is
/// measured before the test is tried there. Frames with a prepass need none of it. The test does not pay for few items.
OcclusionMode OpaqueItems::occlusion_mode(const DrawContext& context, const Frame& frame,
                                          const core::VisibleSet& candidates) {
  trial_ = Trial::kSwitch;
  if (!context.may_test_occlusion()) return OcclusionMode::kOff;
  if (context.config.culling.occlusion == OcclusionChoice::kOn) return OcclusionMode::kOn;
  const std::size_t count = frame.snapshot.count(candidates);
  if (count < kSmallOcclusionScene) return OcclusionMode::kOff;
  if (!context.software()) trial_ = occlusion_trial_.next(double(count));
  if (trial_ != Trial::kSwitch) return trial_ == Trial::kTimedTest ? OcclusionMode::kOn : OcclusionMode::kOff;
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  return occlusion_switch_.use(culling::mean_area(frame.view, bounds, candidates, context.target().height()));
}

/// After a frame with the test, which took so long, draws some of the candidates again, as a frame without the test
/// would draw all of them: see OcclusionMode. That changes no pixel, since the image has an item at least as near
/// everywhere.
core::Expected<void> OpaqueItems::measure(DrawContext& context, const Frame& frame, const core::VisibleSet& candidates,
                                          double tested_ms) {
  constexpr auto kParts = core::Slot(1.0 / culling::OcclusionSwitch::kTriedPart);
  measured_part_ = (measured_part_ + 1) % kParts;
  const core::VisibleSet part = part_of(candidates, kParts, measured_part_);
  const double round_trip_ms = context.round_trip_ms();
  const double begin = core::now_seconds();
  context.sample_test(frame).filter(frame.snapshot.bounds(), part, sampled_, frame.lines, &context.threads);
  const MeshCounts meshes = context.image->meshes;
  if (auto done = context.draw(frame, {sampled_, context.target()}); !done) return done;
  context.image->meshes = meshes;
  const double cpu_ms = 1e3 * (core::now_seconds() - begin);
  const double all_ms = 1e3 * (finished_at(context) - begin) - round_trip_ms;
  occlusion_switch_.measured(tested_ms,
                             context.software() ? kSoftwareOverlap * all_ms : std::max(cpu_ms, all_ms - cpu_ms));
  return {};
}

}  // namespace sightline::engine
