// Cuts: where the kept part of a ray begins behind a section plane within an item.
#include "sightline/core/internal/section_rounding.h"
#include "sightline/raytrace/internal/tracer_impl.h"

namespace sightline::raytrace {
namespace {

/// The part with its planes moved outwards. `coordinates`: of an item in its chunk and of its points in it, absolute;
/// `world`: those of the chunk.
KeptPart moved(const Ray& ray, KeptPart part, const dvec3& coordinates, const dvec3& world) {
  const auto distance = [&](const core::Plane& plane) {  // in t
    const double slope = std::fabs(glm::dot(plane.normal, ray.direction));
    return slope > 0.0 ? core::section_margin(plane, coordinates, world) / slope : 0.0;
  };
  if (part.cut) part.from = std::max(ray.t_min, part.from - distance(*part.cut));
  if (part.end) part.to = std::min(ray.t_max, part.to + distance(*part.end));
  return part;
}

}  // namespace

KeptPart Tracer::Impl::part_of(Slot slot, const Ray& ray, const KeptPart& part) const {
  const core::Placement& placed = placement(slot);
  const dvec3& chunk = snapshot_->chunk_origins()[placed.chunk];
  const core::Aabb box = snapshot_->bounds().box(slot);
  const dvec3 origin = chunk - snapshot_->bounds().origin + dvec3(placed.origin);
  const dvec3 farthest = glm::max(glm::abs(dvec3(box.min) - origin), glm::abs(dvec3(box.max) - origin));
  return moved(ray, part, glm::abs(dvec3(placed.origin)) + farthest, glm::abs(chunk));
}

KeptPart Tracer::Impl::widest(const Ray& ray, const KeptPart& part) const {
  const core::ItemBounds& bounds = snapshot_->bounds();
  const dvec3 most = glm::max(glm::abs(dvec3(bounds.extent().min)), glm::abs(dvec3(bounds.extent().max)));
  return moved(ray, part, 4.0 * most, glm::abs(bounds.origin) + most);
}

Hit Tracer::Impl::cut_hit(const Ray& ray, double t, const core::Plane& plane, Slot slot) const {
  return {
      slot,      snapshot_->item(slot), t, ray.origin + t * ray.direction, -glm::normalize(plane.normal), core::kNone,
      Face::kCut};
}

core::Enclosure Tracer::Impl::enclosure(std::uint32_t mesh) const {
  std::atomic<std::uint8_t>& known = enclosures_[mesh];
  if (known == 0) known = std::uint8_t(1 + int(enclosure_of(*meshes_[mesh])));  // threads at once find the same
  return core::Enclosure(known - 1);
}

/// Whether the ray's point at t lies within the item. Surfaces without a volume, and meshes that are not closed,
/// contain nothing.
bool Tracer::Impl::encloses(Slot slot, const Ray& ray, double t) const {
  const Kind kind = snapshot_->kind(slot);
  if (!is_mesh(kind)) {
    ItemRay local;
    if (!to_item(*snapshot_, placement(slot), ray.origin, ray.direction, local)) return false;
    const gpuprims::Hits hits = solid_hits(kind, parameters(slot), {local.origin, local.direction});
    for (int i = 0; i + 1 < hits.count; i += 2)  // in and out in turn
      if (hits.hit[i].t < t && t <= hits.hit[i + 1].t) return true;
    return false;
  }
  const core::Enclosure encloses = enclosure(mesh_index(slot));
  if (encloses == core::Enclosure::kNothing) return false;
  // Behind a point within, the ray leaves once more than it enters.
  std::vector<Hit> behind;
  all_of(slot, ray, t, kInfinity, behind);
  int leaves = 0;
  for (const Hit& hit : behind) leaves += glm::dot(hit.normal, ray.direction) > 0.0 ? 1 : -1;
  return encloses == core::Enclosure::kInside ? leaves > 0 : leaves < 0;
}

}  // namespace sightline::raytrace
