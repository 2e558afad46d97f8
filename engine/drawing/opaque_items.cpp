#include "sightline/engine/drawing/internal/opaque_items.h"

#include <algorithm>

#include "sightline/engine/drawing/internal/item_sizes.h"
#include "sightline/engine/internal/clock.h"

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

}  // namespace

core::Expected<DrawCounts> OpaqueItems::draw(DrawContext& context, const DrawInput& input) {
  const Culled& culled = input.candidates;
  const EngineConfig& config = context.config;
  ImageState& image = *context.image;
  image.pyramid_valid = image.unchanged = false;
  if (config.losses.budget_ms > 0.0) return in_budget_.draw(context, input);
  const core::VisibleSet& large = contribution_culling_.leave_out(context, culled, config.losses.min_projected_area);
  const bool all = &large == &culled.visible;
  DrawInput left = {culled.with(large), input.deadline, input.all_visible && all, input.postprocessed};
  const auto count = std::int64_t(culled.snapshot.count(large));
  const OcclusionMode mode = occlusion_mode(context, left.candidates, count);
  if (mode == OcclusionMode::kOff) image.passes.reset(), image.clusters.reset();
  auto counts = mode == OcclusionMode::kOff  ? at_once_.draw(context, left)
                : mode == OcclusionMode::kOn ? tested_strategy(left).draw(context, left)
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

/// Between passes the depth is read back, which stalls a GPU, but is a copy in memory on a software rasteriser. Frames
/// with a prepass need none of it. The test does not pay for few items.
OcclusionMode OpaqueItems::occlusion_mode(const DrawContext& context, const Culled& candidates, std::int64_t count) {
  if (!context.may_test_occlusion()) return OcclusionMode::kOff;
  if (context.config.culling.occlusion == OcclusionChoice::kOn) return OcclusionMode::kOn;
  const std::size_t least = context.software() ? kSmallOcclusionScene : kSmallOcclusionSceneForGpu;
  if (count < std::int64_t(least)) return OcclusionMode::kOff;
  return occlusion_switch_.use(
      mean_area(candidates.view, candidates.snapshot.bounds(), candidates.visible, context.target().height()));
}

/// Draws with the test, and then some of the candidates again, as a frame without the test would draw all of them: see
/// OcclusionMode. That changes no pixel, since the image has an item at least as near everywhere.
core::Expected<DrawCounts> OpaqueItems::draw_and_measure(DrawContext& context, const DrawInput& input) {
  const auto& [view, snapshot, visible, lines, hierarchy] = input.candidates;
  const auto finished_at = [&] {
    context.gl().Finish();
    return now_seconds();
  };
  DrawStrategy& tested = tested_strategy(input);
  double begin = finished_at();
  const auto counts = tested.draw(context, input);
  if (!counts) return counts;
  const double tested_ms = 1e3 * (finished_at() - begin);
  constexpr auto kParts = core::Slot(1.0 / OcclusionSwitch::kTriedPart);
  measured_part_ = (measured_part_ + 1) % kParts;
  const core::VisibleSet part = part_of(visible, kParts, measured_part_);
  begin = now_seconds();
  context.sample_test(view, snapshot.bounds()).filter(snapshot.bounds(), part, sampled_, lines);
  const gpuscene::MeshCounts meshes = context.image->meshes;
  if (auto done = context.draw_more(view, snapshot, sampled_, context.target()); !done)
    return tl::unexpected(done.error());
  context.image->meshes = meshes;
  occlusion_switch_.measured(tested_ms, 1e3 * (finished_at() - begin));
  return counts;
}

}  // namespace sightline::engine
