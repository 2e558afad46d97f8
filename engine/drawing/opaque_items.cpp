#include "sightline/engine/drawing/internal/opaque_items.h"

#include <algorithm>

#include "sightline/core/internal/clock.h"
#include "sightline/engine/drawing/internal/item_sizes.h"
#include "sightline/engine/internal/device_constants.h"

namespace sightline::engine {
namespace {

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

core::Expected<DrawCounts> OpaqueItems::draw(DrawContext& context, const DrawInput& input) {
  const Culled& culled = input.candidates;
  const EngineConfig& config = context.config;
  ImageState& image = *context.image;
  image.pyramid_valid = image.unchanged = false;
  if (config.losses.budget_ms > 0.0) return in_budget_.draw(context, input);
  const core::VisibleSet& large = contribution_culling_.leave_out(context, culled, config.losses.min_projected_area);
  const bool all = &large == &culled.visible;
  DrawInput left = {culled.with(large), input.deadline, input.all_visible && all, input.overlaid};
  const auto count = std::int64_t(culled.snapshot.count(large));
  const OcclusionMode mode = occlusion_mode(context, left.candidates, count);
  if (mode == OcclusionMode::kOff) image.passes.reset(), image.clusters.reset();
  auto counts = mode == OcclusionMode::kOff  ? draw_timed(context, left, at_once_)
                : mode == OcclusionMode::kOn ? draw_timed(context, left, tested_strategy(left))
                                             : draw_and_measure(context, left);
  if (!counts) return counts;
  counts->below_min_area = all ? 0 : std::int64_t(culled.snapshot.count(culled.visible)) - count;
  if (counts->below_min_area == 0 || config.losses.contribution_mode == ContributionMode::kDrop) return counts;
  const float least_area =
      config.losses.contribution_mode == ContributionMode::kStochastic ? config.losses.min_projected_area : 0.0f;
  const auto splats =
      contribution_culling_.draw(context, culled, image.was_large, least_area, mode != OcclusionMode::kOff);
  if (!splats) return tl::unexpected(splats.error());
  counts->splats = *splats;
  return counts;
}

DrawStrategy& OpaqueItems::tested_strategy(const DrawInput& input) {
  if (prepass_.suits(input)) return prepass_;
  return in_passes_;
}

/// Between passes the depth is read back, which is a copy in memory on a software rasteriser. What it takes on a GPU is
/// measured before the test is tried there. Frames with a prepass need none of it. The test does not pay for few items.
OcclusionMode OpaqueItems::occlusion_mode(const DrawContext& context, const Culled& candidates, std::int64_t count) {
  using Frame = OcclusionTrial::Frame;
  trial_ = Frame::kSwitch;
  if (!context.may_test_occlusion()) return OcclusionMode::kOff;
  if (context.config.culling.occlusion == OcclusionChoice::kOn) return OcclusionMode::kOn;
  if (count < std::int64_t(kSmallOcclusionScene)) return OcclusionMode::kOff;
  if (!context.software()) trial_ = occlusion_trial_.next(double(count));
  if (trial_ != Frame::kSwitch) return trial_ == Frame::kTimedTest ? OcclusionMode::kOn : OcclusionMode::kOff;
  return occlusion_switch_.use(
      mean_area(candidates.view, candidates.snapshot.bounds(), candidates.visible, context.target().height()));
}

/// Draws by a strategy, and times it if the trial wants that.
core::Expected<DrawCounts> OpaqueItems::draw_timed(DrawContext& context, const DrawInput& input,
                                                   DrawStrategy& strategy) {
  using Frame = OcclusionTrial::Frame;
  if (trial_ != Frame::kTimedPlain && trial_ != Frame::kTimedTest) return strategy.draw(context, input);
  const double begin = finished_at(context);
  auto counts = strategy.draw(context, input);
  const double ms = 1e3 * (finished_at(context) - begin) - context.round_trip_ms();
  if (counts && trial_ == Frame::kTimedPlain) occlusion_trial_.plain_took(ms);
  if (counts && trial_ == Frame::kTimedTest) occlusion_trial_.test_took(ms);
  return counts;
}

/// Draws with the test, and then some of the candidates again, as a frame without the test would draw all of them: see
/// OcclusionMode. That changes no pixel, since the image has an item at least as near everywhere.
core::Expected<DrawCounts> OpaqueItems::draw_and_measure(DrawContext& context, const DrawInput& input) {
  const auto& [view, snapshot, visible, lines, hierarchy] = input.candidates;
  DrawStrategy& tested = tested_strategy(input);
  double begin = finished_at(context);
  const auto counts = tested.draw(context, input);
  if (!counts) return counts;
  const double tested_ms = 1e3 * (finished_at(context) - begin);
  constexpr auto kParts = core::Slot(1.0 / OcclusionSwitch::kTriedPart);
  measured_part_ = (measured_part_ + 1) % kParts;
  const core::VisibleSet part = part_of(visible, kParts, measured_part_);
  const double round_trip_ms = context.round_trip_ms();
  begin = core::now_seconds();
  context.sample_test(view, snapshot.bounds()).filter(snapshot.bounds(), part, sampled_, lines);
  const gpuscene::MeshCounts meshes = context.image->meshes;
  if (auto done = context.draw_more(view, snapshot, sampled_, context.target()); !done)
    return tl::unexpected(done.error());
  context.image->meshes = meshes;
  const double cpu_ms = 1e3 * (core::now_seconds() - begin);
  const double all_ms = 1e3 * (finished_at(context) - begin) - round_trip_ms;
  occlusion_switch_.measured(tested_ms,
                             context.software() ? kSoftwareOverlap * all_ms : std::max(cpu_ms, all_ms - cpu_ms));
  return counts;
}

}  // namespace sightline::engine
