// Functions of Engine that ask what lies in a region, what shows at a point, and what culling does, between frames.
#include <algorithm>
#include <cmath>
#include <utility>

#include "sightline/core/image_rays.h"
#include "sightline/engine/internal/engine_state.h"
#if SIGHTLINE_HAS_RAYTRACE
#include "sightline/engine/pick.h"
#endif

namespace sightline::engine {

// --- what culling does -----------------------------------------------------------------------------------------------

core::Expected<LossReport> Engine::loss(const core::View& view) {
  const auto kept = state_->keep_state();
  if (state_->backend->lost()) return LossReport();
  return state_->backend->loss(state_->frame(view, view), state_->visible);
}

core::Expected<culling::CullStates> Engine::cull_states(const core::View& view) {
  EngineState& s = *state_;
  const auto kept = s.keep_state();
  if (auto landed = land(s); !landed) return tl::unexpected(landed.error());
  if (auto followed = make_gpu_follow(s); !followed) return tl::unexpected(followed.error());
  const core::Snapshot& snapshot = *s.live.snapshot;
  std::optional<culling::Hierarchy> made;  // the linear culler has none
  const culling::Hierarchy* hierarchy = s.live.hierarchy();
  if (!hierarchy) hierarchy = &made.emplace(snapshot.bounds());
  LeftOut out;
  if (s.backend->ready() && !s.backend->lost()) {
    core::VisibleSet visible;
    std::visit([&](const auto& culler) { culler.cull(view, visible); }, *s.live.culler);
    auto found = s.backend->left_out({view, view, snapshot, s.live.lines, hierarchy}, visible);
    if (found)
      out = std::move(*found);
    else if (!s.backend->lost())
      return tl::unexpected(found.error());
  }
  return culling::cull_states(view, snapshot.bounds(), *hierarchy, out.small, out.occluded);
}

// --- regions ---------------------------------------------------------------------------------------------------------

namespace {

std::vector<core::ItemId> items_in_volume(const SceneVersion& version, const core::View& volume,
                                          culling::RegionRule rule) {
  const core::Snapshot& snapshot = *version.snapshot;
  core::VisibleSet candidates;
  if (version.culler)
    std::visit([&](const auto& culler) { culler.cull(volume, candidates); }, *version.culler);
  else
    culling::LinearCuller(snapshot.bounds()).cull(volume, candidates);
  std::vector<core::ItemId> items;
  for (const core::Slot slot : culling::items_in_region(snapshot, volume, candidates, rule))
    items.push_back(snapshot.item(slot));
  std::sort(items.begin(), items.end());
  return items;
}

}  // namespace

core::Expected<std::vector<core::ItemId>> Engine::items_in(const core::View& view, const PixelRectangle& rectangle,
                                                           culling::RegionRule rule) const {
  const auto volume = culling::rectangle_view(view, config().width, config().height, rectangle.x0, rectangle.y0,
                                              rectangle.x1, rectangle.y1);
  if (!volume) return tl::unexpected(volume.error());
  return items_in_volume(state_->live, *volume, rule);
}
core::Expected<std::vector<core::ItemId>> Engine::items_in(std::vector<core::Plane> planes, culling::RegionRule rule,
                                                           std::uint32_t layers) const {
  if (planes.size() > core::kMaxSectionPlanes)
    return core::fail("region: expected at most " + std::to_string(core::kMaxSectionPlanes) + " planes");
  return items_in_volume(state_->live, culling::region_view(std::move(planes), layers), rule);
}

#if SIGHTLINE_HAS_RAYTRACE

// --- picking ---------------------------------------------------------------------------------------------------------

void Engine::prepare_picks() {
  state_->picks = true;
  state_->new_tracer.begin(state_->live);
}
bool Engine::preparing_picks() const {
  return !state_->new_tracer.ready();
}

namespace {

/// The tracer of the live order; waits for it where it is being made.
core::Expected<const raytrace::Tracer*> tracer_of(EngineState& s) {
  s.picks = true;
  s.new_tracer.finish(s.live);
  if (auto made = make_tracer(s.live); !made) return tl::unexpected(made.error());
  return s.live.tracer.get();
}

}  // namespace

core::Expected<std::optional<Pick>> Engine::pick(const core::View& view, double x, double y, Ghosts ghosts) {
  const auto ray = core::image_ray(view, config().width, config().height, x, y);
  if (!ray) return tl::unexpected(ray.error());
  return pick(*ray, raytrace::filter_of(view), ghosts);
}

core::Expected<std::optional<Pick>> Engine::pick(const core::Ray& ray) {
  return pick(ray, {}, Ghosts::kPassed);
}

core::Expected<std::optional<Pick>> Engine::pick(const core::Ray& ray, const raytrace::RayFilter& filter,
                                                 Ghosts ghosts) {
  const auto tracer = tracer_of(*state_);
  if (!tracer) return tl::unexpected(tracer.error());
  raytrace::RayFilter seen = filter;
  if (ghosts == Ghosts::kPassed) seen.without = state_->overrides.ghosts();
  const auto hit = (*tracer)->nearest(ray, seen);
  if (!hit) return tl::unexpected(hit.error());
  if (!*hit) return std::nullopt;
  return Pick{**hit, state_->nodes[to_index((*hit)->item)]};
}

core::Expected<std::vector<raytrace::VisibleItem>> Engine::visible_items_in(const core::View& view,
                                                                            const PixelRectangle& rectangle,
                                                                            int samples) {
  const auto [width, height] = std::pair(config().width, config().height);
  const auto asked =
      culling::rectangle_view(view, width, height, rectangle.x0, rectangle.y0, rectangle.x1, rectangle.y1);
  if (!asked) return tl::unexpected(asked.error());
  const auto low = [](double a, double b) { return std::floor(std::min(a, b)); };
  const auto high = [](double a, double b) { return std::ceil(std::max(a, b)); };
  const double x0 = std::max(0.0, low(rectangle.x0, rectangle.x1)), y0 = std::max(0.0, low(rectangle.y0, rectangle.y1));
  const double x1 = std::min(double(width), high(rectangle.x0, rectangle.x1));
  const double y1 = std::min(double(height), high(rectangle.y0, rectangle.y1));
  const auto cropped = culling::rectangle_view(view, width, height, x0, y0, x1, y1);
  if (!cropped) return tl::unexpected(cropped.error());
  if (!(x0 < x1 && y0 < y1)) return std::vector<raytrace::VisibleItem>();  // beside the image
  const auto tracer = tracer_of(*state_);
  if (!tracer) return tl::unexpected(tracer.error());
  return raytrace::ExactVisibility(**tracer).compute(*cropped, int(x1 - x0), int(y1 - y0), samples, 0,
                                                     state_->overrides.ghosts());
}

#endif

}  // namespace sightline::engine
