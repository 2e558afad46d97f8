// What Drawing leaves out of pictures, for those who ask between frames.
#include <algorithm>

#include "sightline/engine/internal/drawing.h"

namespace sightline::engine {
namespace {

/// Slots of `all` that are not in `kept`.
std::vector<std::uint64_t> without(const core::VisibleSet& all, const core::VisibleSet& kept, std::size_t slots) {
  std::vector<std::uint64_t> bits(culling::bit_words(slots)), kept_bits(bits);
  culling::set_bits(all, bits);
  culling::set_bits(kept, kept_bits);
  for (std::size_t i = 0; i < bits.size(); ++i) bits[i] &= ~kept_bits[i];
  return bits;
}

}  // namespace

core::Expected<LeftOut> Drawing::left_out(const Culled& culled) {
  if (!renderer_) return LeftOut();
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  picture_changed();
  wait_for_room();
  const auto& [view, snapshot, visible, lines, hierarchy] = culled;
  const core::ItemBounds& bounds = snapshot.bounds();
  LeftOut out;
  core::VisibleSet large, sampled, shown;
  const core::VisibleSet* left = &visible;
  if (contribution_ > 0.0f) {
    contribution_test(view, snapshot).filter(bounds, *left, contribution_, large, {}, lines);
    left = &large;
  }
  if (sample_test_ || may_test_occlusion()) {
    culling::SampleTest(view, bounds.origin, samples()).filter(bounds, *left, sampled, lines);
    left = &sampled;
  }
  if (left != &visible) out.small = without(visible, *left, bounds.size());
  if (!may_test_occlusion()) return out;
  const core::VisibleSet& solid = has_overlays() ? part_overlays(*left) : *left;
  if (auto done = draw_in_passes(culled.with(solid)); !done) return tl::unexpected(done.error());
  occlusion_test(view, bounds.origin).filter(bounds, *left, shown, lines);
  out.occluded = without(*left, shown, bounds.size());
  return out;
}

/// Against the picture as it is now: what a budget goes on with must stay as it is.
core::Expected<LossReport> Drawing::loss(const Culled& culled) {
  if (!renderer_ || (contribution_ <= 0.0f && budget_ms_ <= 0.0)) return LossReport();
  if (auto current = make_current(); !current) return tl::unexpected(current.error());
  const auto& [view, snapshot, visible, lines, hierarchy] = culled;
  const core::ItemBounds& bounds = snapshot.bounds();
  std::vector<std::uint64_t> drawn = picture_->was_large;
  if (budget_ms_ > 0.0) picture_->budget.looked_at(bounds.size(), drawn);
  core::VisibleSet missing, sampled, open;
  visible.for_each_slot([&](core::Slot slot) {
    if (!bounds.vacant(slot) && !culling::contains(drawn, slot)) missing.items.push_back(slot);
  });
  std::sort(missing.items.begin(), missing.items.end());
  culling::SampleTest(view, bounds.origin, samples()).filter(bounds, missing, sampled);
  const core::VisibleSet* left = &sampled;
  if (picture_->target.format().samples == 1 && !sampled.items.empty()) {
    std::vector<float> distances;
    culling::DepthPyramid pyramid;
    picture_->target.read_distances(view, distances);
    pyramid.build(distances, picture_->target.width(), picture_->target.height());
    culling::OcclusionTest(view, bounds.origin, picture_->target.width(), picture_->target.height(), pyramid,
                           render::RenderTarget::orthographic_error(view), snap())
        .filter(bounds, sampled, open);
    left = &open;
  }
  std::vector<culling::ContributionTest::SlotArea> areas;
  contribution_test(view, snapshot).areas(bounds, *left, areas);
  LossReport report{std::int64_t(areas.size()), 0.0};
  for (const auto& area : areas) report.pixels += double(area.area);
  report.pixels = std::min(report.pixels, double(picture_->target.width()) * picture_->target.height());
  return report;
}

}  // namespace sightline::engine
