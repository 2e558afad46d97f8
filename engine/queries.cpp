// Functions of Engine that ask what lies in a region, what shows at a point, and what culling does, between frames.
#include <algorithm>
#include <cmath>

#include "sightline/engine/internal/engine_impl.h"
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/engine/pick.h"
#endif

namespace sightline::engine {

// --- what culling does -----------------------------------------------------------------------------------------------

core::Expected<LossReport> Engine::Impl::loss(const core::View& view) {
  [[maybe_unused]] const auto kept = keep_state();
  if (!drawing_ || drawing_->lost()) return LossReport();
  return drawing_->loss({view, *live_.snapshot, visible_, live_.lines, live_.hierarchy()});
}

core::Expected<culling::CullStates> Engine::Impl::cull_states(const core::View& view) {
  [[maybe_unused]] const auto kept = keep_state();
  if (auto landed = land(); !landed) return tl::unexpected(landed.error());
  const core::Snapshot& snapshot = *live_.snapshot;
  std::optional<culling::Hierarchy> own;  // what culls without one has none
  const culling::Hierarchy* hierarchy = live_.hierarchy();
  if (!hierarchy) hierarchy = &own.emplace(snapshot.bounds());
  LeftOut out;
  if (drawing_ && !drawing_->lost()) {
    core::VisibleSet visible;
    std::visit([&](const auto& culler) { culler.cull(view, visible); }, *live_.culler);
    auto found = drawing_->left_out({view, snapshot, visible, live_.lines, hierarchy});
    if (found)
      out = std::move(*found);
    else if (!drawing_->lost())
      return tl::unexpected(found.error());
  }
  return culling::cull_states(view, snapshot.bounds(), *hierarchy, out.small, out.occluded);
}

core::Expected<LossReport> Engine::loss(const core::View& view) {
  return impl_->loss(view);
}
core::Expected<culling::CullStates> Engine::cull_states(const core::View& view) {
  return impl_->cull_states(view);
}

// --- regions ---------------------------------------------------------------------------------------------------------

core::Expected<std::vector<core::ItemId>> Engine::Impl::items_in(const core::View& view,
                                                                 const PixelRectangle& rectangle,
                                                                 culling::RegionRule rule) const {
  const auto volume = culling::rectangle_view(view, config_.width, config_.height, rectangle.x0, rectangle.y0,
                                              rectangle.x1, rectangle.y1);
  if (!volume) return tl::unexpected(volume.error());
  return items_in(*volume, rule);
}

std::vector<core::ItemId> Engine::Impl::items_in(const core::View& volume, culling::RegionRule rule) const {
  const core::Snapshot& snapshot = *live_.snapshot;
  core::VisibleSet candidates;
  if (live_.culler)
    std::visit([&](const auto& culler) { culler.cull(volume, candidates); }, *live_.culler);
  else
    culling::LinearCuller(snapshot.bounds()).cull(volume, candidates);
  std::vector<core::ItemId> items;
  for (const core::Slot slot : culling::items_in_region(snapshot, volume, candidates, rule))
    items.push_back(snapshot.item(slot));
  std::sort(items.begin(), items.end());
  return items;
}

core::Expected<std::vector<core::ItemId>> Engine::items_in(const core::View& view, const PixelRectangle& rectangle,
                                                           culling::RegionRule rule) const {
  return impl_->items_in(view, rectangle, rule);
}
core::Expected<std::vector<core::ItemId>> Engine::items_in(std::vector<core::Plane> planes, culling::RegionRule rule,
                                                           std::uint32_t layers) const {
  if (planes.size() > core::kMaxSectionPlanes)
    return core::fail("region: expected at most " + std::to_string(core::kMaxSectionPlanes) + " planes");
  return impl_->items_in(culling::region_view(std::move(planes), layers), rule);
}

#if SIGHTLINE_HAS_RAYTRACE

void Engine::prepare_picks() {
  impl_->prepare_picks();
}
bool Engine::preparing_picks() const {
  return impl_->preparing_picks();
}

// --- picking ---------------------------------------------------------------------------------------------------------

core::Expected<std::optional<Pick>> Engine::Impl::pick(const core::View& view, double x, double y, Ghosts ghosts) {
  const auto ray = raytrace::pixel_ray(view, config_.width, config_.height, x, y);
  if (!ray) return tl::unexpected(ray.error());
  return pick(*ray, raytrace::filter_of(view), ghosts);
}

core::Expected<std::optional<Pick>> Engine::Impl::pick(const raytrace::Ray& ray, const raytrace::RayFilter& filter,
                                                       Ghosts ghosts) {
  picks_ = true;
  new_tracer_.finish(live_);
  if (auto made = make_tracer(live_); !made) return tl::unexpected(made.error());
  const auto hit = ghosts == Ghosts::kHit ? live_.tracer->nearest(ray, filter)
                                          : raytrace::nearest_but(*live_.tracer, ray, filter, overrides_.ghosts());
  if (!hit) return tl::unexpected(hit.error());
  if (!*hit) return std::nullopt;
  return Pick{**hit, nodes_[(*hit)->item]};
}

core::Expected<std::vector<raytrace::VisibleItem>> Engine::Impl::visible_items_in(const core::View& view,
                                                                                  const PixelRectangle& rectangle,
                                                                                  int samples) {
  const auto asked = culling::rectangle_view(view, config_.width, config_.height, rectangle.x0, rectangle.y0,
                                             rectangle.x1, rectangle.y1);
  if (!asked) return tl::unexpected(asked.error());
  const auto low = [](double a, double b) { return std::floor(std::min(a, b)); };
  const auto high = [](double a, double b) { return std::ceil(std::max(a, b)); };
  const double x0 = std::max(0.0, low(rectangle.x0, rectangle.x1)), y0 = std::max(0.0, low(rectangle.y0, rectangle.y1));
  const double x1 = std::min(double(config_.width), high(rectangle.x0, rectangle.x1));
  const double y1 = std::min(double(config_.height), high(rectangle.y0, rectangle.y1));
  const auto cropped = culling::rectangle_view(view, config_.width, config_.height, x0, y0, x1, y1);
  if (!cropped) return tl::unexpected(cropped.error());
  if (!(x0 < x1 && y0 < y1)) return std::vector<raytrace::VisibleItem>();  // beside the picture
  picks_ = true;
  new_tracer_.finish(live_);
  if (auto made = make_tracer(live_); !made) return tl::unexpected(made.error());
  return raytrace::ExactVisibility(*live_.tracer)
      .compute(*cropped, int(x1 - x0), int(y1 - y0), samples, 0, overrides_.ghosts());
}

core::Expected<std::vector<raytrace::VisibleItem>> Engine::visible_items_in(const core::View& view,
                                                                            const PixelRectangle& rectangle,
                                                                            int samples) {
  return impl_->visible_items_in(view, rectangle, samples);
}
core::Expected<std::optional<Pick>> Engine::pick(const core::View& view, double x, double y, Ghosts ghosts) {
  return impl_->pick(view, x, y, ghosts);
}
core::Expected<std::optional<Pick>> Engine::pick(const raytrace::Ray& ray) {
  return impl_->pick(ray, {}, Ghosts::kPassed);
}
core::Expected<std::optional<Pick>> Engine::pick(const raytrace::Ray& ray, const raytrace::RayFilter& filter,
                                                 Ghosts ghosts) {
  return impl_->pick(ray, filter, ghosts);
}

#endif

}  // namespace sightline::engine
