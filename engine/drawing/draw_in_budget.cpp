#include <algorithm>
#include <utility>

#include "sightline/core/internal/clock.h"
#include "sightline/engine/drawing/internal/draw_strategy.h"
#include "sightline/engine/drawing/internal/translucent.h"

namespace sightline::engine {
namespace {

constexpr double kBudgetShare = 0.93;   // of a frame's budget, to draw in
constexpr double kPassShare = 0.5;      // of the time left, for the next pass: it may take longer than expected
constexpr double kLeastPasses = 2.0;    // passes for which the time left must suffice
constexpr double kLeastShare = 0.1;     // of the time, for the first pass at least, though waits alone exceed it
constexpr double kSlower = 0.92;        // the estimate of splats_ms_ falls by at most this factor a frame
constexpr double kMostCoarsened = 2.0;  // pixels: beyond that, leaving out items costs less error for the same time
constexpr double kCoarser = 1.5, kFiner = 0.9;  // by these factors a frame: steps of detail should not be seen
constexpr double kStillShare = 4.0;             // times a still frame's overhead: the least time for its items
constexpr float kUnmeasured = 0.125f;  // of the area that the last frame came to: smaller items are not measured

/// Before a moving image leaves out items, levels of detail get coarser where they are asked for: the pixels within
/// which the next frame draws meshes, by whether the time has sufficed for this one. 0: as asked for.
double next_coarsened(const ImageState& image, double asked_for, bool sufficed) {
  if (asked_for <= 0.0) return 0.0;
  const double now = std::max(asked_for, image.coarsened);
  const double next = sufficed ? kFiner * now : std::min(kCoarser * now, kMostCoarsened);
  return next > asked_for ? next : 0.0;
}

}  // namespace

core::Expected<DrawCounts> DrawInBudget::draw(DrawContext& context, const Frame& frame,
                                              const core::VisibleSet& candidates) {
  const double began = core::now_seconds();
  const double frame_ends = frame.budget_began + kBudgetShare * 1e-3 * context.config.losses.budget_ms;
  ImageState& image = *context.image;
  const bool same = image.budget_view && core::same_image(*image.budget_view, frame.view);
  const bool stays = same || frame.at_rest, goes_on = same && image.refines;
  const bool splats = context.config.losses.contribution_mode != ContributionMode::kDrop;
  const bool beside = stays && (splats || frame.overlaid || image.shows_moving());
  DrawCounts& counts = image.budget_counts;
  if (goes_on && image.budget.complete()) {
    image.unchanged = true;
    counts.items_drawn = std::int64_t(image.budget.drawn());
    return counts;
  }
  if (beside)
    if (auto done = context.make_like_image(image.refined, 1.0); !done) return tl::unexpected(done.error());
  const render::RenderTarget& canvas = beside ? *image.refined : image.target;
  if (!goes_on) {
    begin(context, frame, candidates, stays);
    image.beside = beside;
    if (auto done = context.clear(canvas); !done) return tl::unexpected(done.error());
  }
  // Reading the depth of a large image back may take longer than the budget. A still image would then hardly go on.
  const double deadline = stays ? std::max(frame_ends, began + 1e-3 * kStillShare * image.overhead_ms) : frame_ends;
  const auto drawn_ms = draw_passes(context, frame, canvas, deadline);
  if (!drawn_ms) return tl::unexpected(drawn_ms.error());
  if (context.may_test_occlusion() && !goes_on)
    image.budget.remember(context.occlusion_test(frame), frame.snapshot.bounds(), &context.threads);
  counts = {-1, std::int64_t(image.budget.drawn()), counts.below_min_area,
            std::int64_t(image.budget.pending()) + image.unmeasured};
  if (image.coarsened > 0.0) counts.pending += image.meshes.coarser;
  const bool sufficed = image.budget.complete() && image.unmeasured == 0 && core::now_seconds() <= frame_ends;
  image.coarsened = stays ? 0.0 : next_coarsened(image, context.config.losses.lod_error, sufficed);
  const double begin = core::now_seconds();
  if (stays) image.resolution.rested(*drawn_ms, !goes_on, image.budget.complete(), context.config.losses.budget_ms);
  if (image.budget.complete()) {
    image.shown_step = 0;
    if (image.traced) image.traced->shown = false;
  }
  const bool moving = image.shows_moving();  // it has all items, and so is shown until the image is complete
  counts.coarseness = MovingResolution::kSteps[image.shown_step];
  if (moving && frame.overlaid) {
    auto done = image.shows_traced() ? image.traced->show(context, frame, candidates)
                                     : context.enlarge(*image.smaller[image.shown_step]);
    if (!done) return tl::unexpected(done.error());
  } else if (beside && !moving) {
    image.refined->copy_to(image.target);
  }
  if (splats && !moving) {
    auto done = draw_splats(context, frame, candidates);
    context.gl().Finish();
    splats_ms_ = std::max(1e3 * (core::now_seconds() - begin), kSlower * splats_ms_);
    if (!done) return tl::unexpected(done.error());
  }
  image.overhead_ms = 1e3 * (core::now_seconds() - began) - *drawn_ms;
  return counts;
}

/// Begins the image anew.
void DrawInBudget::begin(DrawContext& context, const Frame& frame, const core::VisibleSet& visible, bool stays) {
  ImageState& image = *context.image;
  if (stays) image.coarsened = 0.0;
  const float least = context.config.losses.min_projected_area;
  const float threshold = stays ? least : std::max(least, kUnmeasured * image.budget.largest_pending());
  context.clear_pyramid();
  const core::VisibleSet& candidates = contribution_culling_.leave_out(context, frame, visible, threshold);
  const auto left_out = std::int64_t(frame.snapshot.count(visible) - frame.snapshot.count(candidates));
  image.unmeasured = threshold > least ? left_out : 0;
  image.budget_counts.below_min_area = left_out - image.unmeasured;
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  if (stays && image.shows_traced() && image.traced->complete()) {
    core::VisibleSet shown, others;
    part(candidates, image.traced->shown_slots(frame.snapshot), shown, others);
    image.budget.begin_shown(context.outline_test(frame), bounds, shown, others, frame.lines);
  } else {
    image.budget.begin(context.contribution_test(frame), bounds, candidates, frame.lines);
  }
  image.refines = stays;
  image.budget_view = frame.view;
}

/// Draws a pass and learns what it takes, which it returns in milliseconds. `read_back`: later passes are tested
/// against its depth; the time for that is learnt apart, since it is the same whatever is drawn.
core::Expected<double> DrawInBudget::draw_pass(DrawContext& context, const Frame& frame,
                                               const render::RenderTarget& canvas, bool read_back) {
  culling::BudgetPasses& budget = context.image->budget;
  const double begin = core::now_seconds();
  auto done = context.draw(frame, {budget.pass(), canvas, nullptr, context.image->coarsened});
  if (!done) return tl::unexpected(done.error());
  context.gl().Finish();
  const double drawn = core::now_seconds(), ms = 1e3 * (drawn - begin);
  if (read_back) {
    if (done = context.read_back_depth(frame.view, canvas); !done) return tl::unexpected(done.error());
    readback_ms_ = 1e3 * (core::now_seconds() - drawn);
  }
  budget.took(std::max(0.0, ms - (context.software() ? 0.0 : context.round_trip_ms())));
  return ms;
}

/// Testing occlusion takes a read-back a pass, and saves no more than drawing all that is pending takes. So where that
/// is less, it is drawn untested. On a software rasteriser a read-back is a copy. Returns the milliseconds that drawing
/// alone took.
core::Expected<double> DrawInBudget::draw_passes(DrawContext& context, const Frame& frame,
                                                 const render::RenderTarget& canvas, double deadline) {
  double drawn_ms = 0.0;
  const core::ItemBounds& bounds = frame.snapshot.bounds();
  culling::BudgetPasses& budget = context.image->budget;
  const bool always = context.software() || context.config.culling.occlusion == OcclusionChoice::kOn;
  const culling::OcclusionTest test = context.occlusion_test(frame);
  distances_known_ = false;
  if (const int pixels = canvas.width() * canvas.height(); std::exchange(readback_pixels_, pixels) != pixels)
    readback_ms_ = 0.0;  // not known
  const double round_trip_ms = context.software() ? 0.0 : context.round_trip_ms();
  for (int passes = 0; !budget.complete(); ++passes) {
    double left = 1e3 * (deadline - core::now_seconds());
    if (budget.pending_ms() > left) left -= splats_ms_;
    const bool tests = context.may_test_occlusion() && (always || budget.most_pending_ms() > readback_ms_);
    const double waits = round_trip_ms + (tests ? readback_ms_ : 0.0);
    if (passes > 0 && left < kLeastPasses * (budget.least_ms() + waits)) break;
    if (budget.tests_others()) {
      budget.test_others(context.outline_test(frame), tests ? &test : nullptr, bounds, frame.hierarchy, context.threads,
                         core::now_seconds() + 1e-3 * kPassShare * left);
      if (budget.tests_others()) continue;  // none of them was open
      left = 1e3 * (deadline - core::now_seconds());
    }
    const double least = passes == 0 && waits > 0.0 ? kLeastShare * left : 0.0;
    if (!budget.next(tests ? &test : nullptr, bounds, std::max(least, kPassShare * left - waits))) break;
    const auto ms = draw_pass(context, frame, canvas, tests && budget.tests_next());
    if (!ms) return ms;
    drawn_ms += *ms;
    distances_known_ = tests;
  }
  return drawn_ms;
}

/// Draws a splat for each item that is small or pending.
core::Expected<void> DrawInBudget::draw_splats(DrawContext& context, const Frame& frame,
                                               const core::VisibleSet& visible) {
  ImageState& image = *context.image;
  if (image.budget_counts.pending + image.budget_counts.below_min_area == 0) return {};
  image.budget.looked_at(frame.snapshot.size(), without_splats_);
  const auto drawn = contribution_culling_.draw(context, frame, visible, {without_splats_, 0.0f, distances_known_});
  if (!drawn) return tl::unexpected(drawn.error());
  image.budget_counts.splats = *drawn;
  return {};
}

}  // namespace sightline::engine
