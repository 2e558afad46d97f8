#include "sightline/raytrace/internal/traced_scene.h"

#include <algorithm>
#include <array>

#include "sightline/raytrace/internal/surface.h"

namespace sightline::raytrace {
namespace {

bool is_hit(const SceneRays::PartHit& hit) {
  return hit.hit.slot != core::kNone;
}

/// The t of the farthest hit; infinity while a ray has none.
double farthest_of(std::span<const SceneRays::PartHit> hits) {
  double farthest = -kInfinity;
  for (const SceneRays::PartHit& hit : hits) farthest = std::max(farthest, is_hit(hit) ? hit.hit.t : kInfinity);
  return farthest;
}

}  // namespace

SceneRays::SceneRays(const TracedScene& scene, const core::View& view, const core::ImageRays& rays, int height)
    : scene_(scene),
      rays_(rays),
      height_(height),
      filters_(scene.parts.size(), filter_of(view)),
      box_filter_(filter_of(view)) {
  for (std::size_t i = 0; i < scene.parts.size(); ++i) {
    filters_[i].without = scene.parts[i].without;
    all_opaque_ = all_opaque_ && raytrace::all_opaque(scene.parts[i].tracer->snapshot().materials());
  }
  box_filter_.layers = ~0u;  // boxes say nothing of what they hold
  box_filter_.without = scene.boxes.without;
}

Beam SceneRays::beam_of(const PixelRange& pixels) const {
  const auto corner = [&](int x, int y) { return rays_.through(x, height_ - y); };
  return Beam({corner(pixels.left, pixels.bottom), corner(pixels.right, pixels.bottom),
               corner(pixels.right, pixels.top), corner(pixels.left, pixels.top)});
}

/// Replaces hits by those of a part that are nearer.
void SceneRays::nearest_of(std::uint32_t part, std::span<const core::Ray> rays, std::span<PartHit> hits) const {
  const auto& [tracer, without, count] = scene_.parts[part];
  std::array<Hit, kMostRays> found;
  if (!tracer->nearest(rays, {found.data(), rays.size()}, filters_[part])) return;
  std::uint32_t nearer = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (found[i].slot == core::kNone || (is_hit(hits[i]) && found[i].t >= hits[i].hit.t)) continue;
    hits[i] = {found[i], &tracer->snapshot()};
    ++nearer;
  }
  if (count && nearer > 0) count->fetch_add(nearer, std::memory_order_relaxed);
}

/// nearest() of a scene in one part.
void SceneRays::nearest_alone(std::span<const core::Ray> rays, std::span<PartHit> hits) const {
  const Tracer& tracer = *scene_.parts[0].tracer;
  std::array<Hit, kMostRays> found;
  if (!tracer.nearest(rays, {found.data(), rays.size()}, filters_[0])) found.fill({});
  for (std::size_t i = 0; i < rays.size(); ++i)
    hits[i] = {found[i], found[i].slot != core::kNone ? &tracer.snapshot() : nullptr};
}

/// nearest_of() for those rays that may hit a part before what they have hit. `first`: they do not before this t.
void SceneRays::nearer_of(std::uint32_t part, double first, std::span<const core::Ray> rays,
                          std::span<PartHit> hits) const {
  std::array<core::Ray, kMostRays> left;
  std::array<PartHit, kMostRays> before;
  std::array<std::size_t, kMostRays> place;
  std::size_t count = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (is_hit(hits[i]) && hits[i].hit.t <= first) continue;
    left[count] = rays[i];
    if (is_hit(hits[i])) left[count].t_max = std::min(rays[i].t_max, hits[i].hit.t);
    before[count] = hits[i];
    place[count++] = i;
  }
  if (count > 0) nearest_of(part, {left.data(), count}, {before.data(), count});
  for (std::size_t i = 0; i < count; ++i) hits[place[i]] = before[i];
}

void SceneRays::nearest(std::span<const core::Ray> rays, const PixelRange& pixels, std::span<PartHit> hits) const {
  if (!scene_.boxes.boxes) return nearest_alone(rays, hits);
  std::fill(hits.begin(), hits.end(), PartHit());
  enter_boxes(rays, hits);
  std::vector<bool> traced(scene_.parts.size());
  double farthest = farthest_of(hits);
  scene_.boxes.boxes->find(beam_of(pixels), farthest, [&](core::Slot slot, double first) {
    const std::uint32_t part = scene_.boxes.part_of[slot];
    if (part == core::kNone || traced[part]) return;
    traced[part] = true;
    nearer_of(part, first, rays, hits);
    farthest = farthest_of(hits);
  });
}

/// Parts with items that a ray may meet.
std::vector<std::uint32_t> SceneRays::parts_along(const core::Ray& ray) const {
  if (!scene_.boxes.boxes) return {0};
  std::vector<std::uint32_t> parts;
  scene_.boxes.boxes->find(ray, [&](core::Slot slot) {
    if (const std::uint32_t part = scene_.boxes.part_of[slot]; part != core::kNone) parts.push_back(part);
  });
  std::sort(parts.begin(), parts.end());
  parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
  return parts;
}

/// Replaces hits by those of boxes before them.
void SceneRays::enter_boxes(std::span<const core::Ray> rays, std::span<PartHit> hits) const {
  if (!scene_.boxes.boxes) return;
  std::array<ItemBoxes::Entry, kMostRays> entries;
  scene_.boxes.boxes->nearest(rays, box_filter_, {entries.data(), rays.size()});
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const ItemBoxes::Entry& entry = entries[i];
    if (entry.slot == core::kNone || (is_hit(hits[i]) && hits[i].hit.t <= entry.t)) continue;
    hits[i] = {};
    hits[i].hit.slot = entry.slot;
    hits[i].hit.t = entry.t;
    hits[i].hit.point = rays[i].origin + entry.t * rays[i].direction;
    hits[i].hit.normal = entry.normal;
  }
}

}  // namespace sightline::raytrace
