#include "sightline/engine/drawing/internal/opaque_items.h"

#include <algorithm>

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

core::Expected<DrawCounts> OpaqueItems::draw(DrawContext& context, const Frame& frame,
                                             const core::VisibleSet& visible) {
  const LossConfig& losses = context.config.losses;
  ImageState& image = *context.image;
  image.pyramid_valid = image.unchanged = false;
  if (losses.budget_ms > 0.0) return in_budget_.draw(context, frame, visible);
  const core::VisibleSet& large = contribution_culling_.leave_out(context, frame, visible, losses.min_projected_area);
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
  const float least_area = losses.contribution_mode == ContributionMode::kStochastic ? losses.min_projected_area : 0.0f;
  const auto splats =
      contribution_culling_.draw(context, frame, visible, {image.was_large, least_area, mode != OcclusionMode::kOff});
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
  context.sample_test(frame).filter(frame.snapshot.bounds(), part, sampled_, frame.lines);
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
