#include "sightline/raytrace/tracer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include "sightline/core/internal/openmp.h"
#include "sightline/gpuprims/internal/primitives.h"
#include "sightline/raytrace/internal/item_walk.h"
#include "sightline/raytrace/internal/kernels.h"
#include "sightline/raytrace/internal/tracer_impl.h"

namespace sightline::raytrace {
namespace {

constexpr std::uint32_t kLargeMesh = 100'000;                 // triangles; all threads build it
constexpr std::size_t kMostTriangles = std::size_t(1) << 28;  // places of triangles fit in 32 bits

// --- rays ------------------------------------------------------------------------------------------------------------

core::Error fault(const Ray& ray) {
  if (!core::is_finite(ray.origin) || !core::is_finite(ray.direction))
    return {"ray: origin and direction must be finite"};
  if (ray.direction == dvec3(0.0)) return {"ray: direction must not be zero"};
  return {"ray: t_min and t_max must not be NaN"};
}

}  // namespace

bool is_ray(const Ray& ray) {
  // A sum of products with 0 is 0 unless one factor is not finite.
  const dvec3 o = 0.0 * ray.origin, d = 0.0 * ray.direction;
  const dvec3 size = magnitude(ray.direction);
  return o.x + o.y + o.z + (d.x + d.y + d.z) == 0.0 && size.x + size.y + size.z > 0.0 &&
         !std::isunordered(ray.t_min, ray.t_max);
}

KeptParts kept_parts(const Ray& ray, const RayFilter& filter) {
  KeptParts parts;
  const bool all = filter.section_mode == core::SectionMode::kIntersection;
  // One plane keeps up to `to`, or from `from` on; several keep what is common to them, or what any of them keeps.
  double from = all ? ray.t_min : kInfinity, to = all ? ray.t_max : -kInfinity;
  bool cuts = false;
  const core::Plane *behind = nullptr, *before = nullptr;  // the planes of `from` and `to`
  for (const core::Plane& plane : filter.sections) {
    if (plane.normal == dvec3(0.0)) continue;
    cuts = true;
    const double value = core::evaluate(plane, ray.origin), slope = glm::dot(plane.normal, ray.direction);
    const double end = slope != 0.0 ? -value / slope : value >= 0.0 ? -kInfinity : kInfinity;  // kept from there on
    if (slope < 0.0) {
      if (all ? end < to : end > to) to = end, before = &plane;
    } else if (all ? end > from : end < from) {
      from = end, behind = &plane;
    }
  }
  if (all && cuts) {
    parts.add({from, to, behind, before});
  } else if (!cuts || from <= to) {
    parts.add({ray.t_min, ray.t_max});
  } else {
    parts.add({ray.t_min, std::min(to, ray.t_max), nullptr, to < ray.t_max ? before : nullptr});
    parts.add({std::max(from, ray.t_min), ray.t_max, from > ray.t_min ? behind : nullptr, nullptr});
  }
  return parts;
}

// --- items -----------------------------------------------------------------------------------------------------------

namespace {

dvec3 world_normal(const core::Placement& placement, const dvec3& n) {
  if (is_unity(placement.linear)) return glm::normalize(n + 0.0);
  const Cofactors map(placement.linear);
  const dvec3 sum = map.column[0] * n.x + map.column[1] * n.y + map.column[2] * n.z;
  return glm::normalize(map.determinant < 0.0 ? -sum : sum);
}

/// Whether a line passes through the hole of a circular torus, further from it than rounding errors. May say false
/// where it does. Where it is as low and as high as the tube, both points must lie within the hole, which is convex.
bool passes_hole(const float* parameters, const ItemRay& ray) {
  const double major = std::fabs(double(parameters[0])), tube = std::fabs(double(parameters[1]));
  const dvec3 &o = ray.origin, &d = ray.direction;
  const double lost = 1e-14 * (std::fabs(o.x) + std::fabs(o.y) + std::fabs(o.z) + major);
  const double height = tube * (1.0 + 1e-6) + lost, hole = (major - tube) * (1.0 - 1e-6) - lost * (2.0 + major / tube);
  if (!(hole > 0.0) || d.z == 0.0) return false;
  const double inverse = 1.0 / d.z, low = (-height - o.z) * inverse, high = (height - o.z) * inverse;
  const double x0 = o.x + low * d.x, y0 = o.y + low * d.y, x1 = o.x + high * d.x, y1 = o.y + high * d.y;
  return x0 * x0 + y0 * y0 < hole * hole && x1 * x1 + y1 * y1 < hole * hole;
}

template <class Solid>
gpuprims::Hits hits_of(const float* parameters, const core::Ray& ray) {
  Solid solid;
  std::memcpy(&solid, parameters, sizeof(Solid));
  return gpuprims::intersect(solid, ray);
}

template <std::size_t... kKinds>
constexpr auto table_of_hits(std::index_sequence<kKinds...>) {
  return std::array{hits_of<std::variant_alternative_t<kKinds, core::Primitive>>...};
}

}  // namespace

gpuprims::Hits solid_hits(Kind kind, const float* parameters, const core::Ray& ray) {
  static constexpr auto kHitsOf = table_of_hits(std::make_index_sequence<core::kPrimitiveKindCount>());
  return is_mesh(kind) ? gpuprims::Hits() : kHitsOf[std::size_t(kind)](parameters, ray);
}

RayFilter filter_of(const core::View& view) {
  return {view.layers, view.sections, view.section_mode};
}

// --- building --------------------------------------------------------------------------------------------------------

/// Whether the index still is that of the mesh, and not of another one since.
bool Tracer::Impl::is_built_from(std::uint32_t index, const std::shared_ptr<const core::Mesh>& mesh) const {
  return !built_from_[index].owner_before(mesh) && !mesh.owner_before(built_from_[index]);
}

core::Expected<void> Tracer::Impl::add_meshes(std::span<const Slot> slots, [[maybe_unused]] int threads,
                                              const std::stop_token& stop) {
  std::vector<Slot> firsts;  // one for each new mesh
  for (const Slot slot : slots) {
    const std::uint32_t index = mesh_index(slot);
    if (index >= meshes_.size()) {
      meshes_.resize(std::size_t(index) + 1);
      built_from_.resize(meshes_.size());
      enclosures_.resize(meshes_.size());
    }
    if (snapshot_->vacant(slot) || (meshes_[index] && is_built_from(index, snapshot_->share_mesh(slot)))) continue;
    if (snapshot_->mesh(slot).indices.size() / 3 >= kMostTriangles)
      return core::fail("tracer: mesh \"" + snapshot_->mesh(slot).name + "\" must have fewer than 2^28 triangles");
    firsts.push_back(slot);
  }
  const auto by_mesh = [&](Slot a, Slot b) { return mesh_index(a) < mesh_index(b); };
  const auto same_mesh = [&](Slot a, Slot b) { return mesh_index(a) == mesh_index(b); };
  std::sort(firsts.begin(), firsts.end(), by_mesh);
  firsts.erase(std::unique(firsts.begin(), firsts.end(), same_mesh), firsts.end());
  const auto build_one = [&](Slot slot, int with) {
    if (stop.stop_requested()) return;
    const std::uint32_t index = mesh_index(slot);
    meshes_[index] = std::make_unique<const MeshTree>(build_mesh_tree(snapshot_->mesh(slot), with, stop));
    built_from_[index] = snapshot_->share_mesh(slot);
    enclosures_[index] = 0;
  };
  const auto large = std::partition(firsts.begin(), firsts.end(),
                                    [&](Slot slot) { return snapshot_->mesh(slot).indices.size() / 3 < kLargeMesh; });
  for (auto slot = large; slot != firsts.end(); ++slot) build_one(*slot, threads);
  const std::ptrdiff_t small = large - firsts.begin();
#pragma omp parallel for schedule(dynamic, 8) num_threads(core::team_of(threads)) if (small > 16)
  for (std::ptrdiff_t i = 0; i < small; ++i) build_one(firsts[std::size_t(i)], 1);
  return {};
}

/// Counts which of these slots hold meshes, and frees the trees of meshes that no slot holds any more.
void Tracer::Impl::count_users(std::span<const Slot> slots) {
  counted_.resize(snapshot_->size());
  users_.resize(meshes_.size());
  for (const bool held : {true, false})  // first those that hold one: another mesh may have got the index of a former
    for (const Slot slot : slots) {
      if ((snapshot_->item(slot) != core::kNoItem) != held || counted_[slot] == held) continue;
      counted_[slot] = held;
      const std::uint32_t index = mesh_index(slot);
      if (held)
        ++users_[index];
      else if (--users_[index] == 0)
        meshes_[index] = nullptr, built_from_[index].reset();
    }
}

core::Expected<void> Tracer::Impl::build(int threads, const std::stop_token& stop) {
  std::vector<Slot> slots;
  for (const Kind kind : {Kind::kFacetGroup, Kind::kMesh}) {
    const auto& of_kind = snapshot_->of_kind(kind).members;
    slots.insert(slots.end(), of_kind.begin(), of_kind.end());
  }
  if (auto done = add_meshes(slots, threads, stop); !done) return done;
  count_users(slots);
  if (!stop.stop_requested()) items_ = ItemTrees(snapshot_->bounds(), threads, stop);
  if (stop.stop_requested()) return core::fail("tracer: stopped");
  return {};
}

core::Expected<void> Tracer::Impl::update(std::span<const Slot> touched) {
  std::vector<Slot> slots;
  for (const Slot slot : touched)
    if (is_mesh(snapshot_->kind(slot))) slots.push_back(slot);
  for (std::size_t slot = items_.slot_count(); slot < snapshot_->size(); ++slot)
    if (is_mesh(snapshot_->kind(Slot(slot)))) slots.push_back(Slot(slot));
  if (auto done = add_meshes(slots, 1); !done) return done;
  count_users(slots);
  items_.update(snapshot_->bounds(), touched);
  return {};
}

TracerMemory Tracer::Impl::memory() const {
  TracerMemory memory;
  memory.items = items_.memory_bytes();
  memory.meshes = meshes_.capacity() * sizeof(meshes_[0]);
  for (const auto& mesh : meshes_)
    if (mesh) memory.meshes += mesh->memory_bytes();
  return memory;
}

// --- queries ---------------------------------------------------------------------------------------------------------

namespace {

/// `kAny`: any triangle does.
template <bool kAny>
bool nearest_triangle(const MeshTree& tree, const ItemRay& ray, double from, double to, double& t,
                      std::uint32_t& place) {
  struct Filter : HitFilter {
    RayFrame frame;
    const MeshTree* tree;
    double from, to;

    double s(std::uint32_t at) const {
      dvec3 corners[3];
      tree->corners(at, corners);
      return crossing(frame, corners);
    }
  } filter;
  const double scale = tree.per_unit;
  if (tree.empty || !enter(tree.space, scale * ray.origin, scale * ray.direction, from, to, filter.frame)) return false;
  filter.crossed = [](HitFilter& base, std::uint32_t at) {
    const auto& self = static_cast<Filter&>(base);
    const double s = self.s(at), t_at = self.frame.t(s);
    return t_at >= self.from && t_at <= self.to ? float(s) : kNotCrossed;
  };
  filter.tree = &tree;
  filter.from = from;
  filter.to = to;
  const RayFrame& frame = filter.frame;
  TriangleQuery query{tree.nodes.data(),   tree.blocks.data(),        tree.root,      &frame.boxes,
                      triangle_ray(frame), float(2.0 * frame.margin), frame.across(), &filter};
  const Kernels& kernel = kernels();
  TriangleHit hit = kAny ? kernel.any(query) : kernel.nearest(query);
  for (const bool last : {false, true}) {
    if (hit.triangle == kNoTriangle) return false;
    place = hit.place;
    t = frame.t(filter.s(place));
    if ((t >= from && t <= to) || last) break;
    // Float has taken one that in double lies beyond an end. Then double decides on all.
    query.t_sure = std::numeric_limits<float>::infinity();
    hit = kernel.nearest(query);
  }
  return t >= from && t <= to;
}

}  // namespace

/// walk_items() through all items.
template <class Meet>
void Tracer::Impl::walk(const Ray& ray, double from, double to, const RayFilter& filter, const Meet& meet) const {
  walk_items({items_, snapshot_->bounds(), ray, from, to, filter}, meet);
}

/// Whether the item is hit before what was found so far; then that is replaced.
bool Tracer::Impl::nearest_of(Slot slot, const Ray& ray, double from, Found& found) const {
  ItemRay local;
  if (!to_item(*snapshot_, placement(slot), ray.origin, ray.direction, local)) return false;
  const Kind kind = snapshot_->kind(slot);
  const auto nearer = [&](double t) { return t < found.t || (t == found.t && slot < found.slot); };
  if (is_mesh(kind)) {
    double t;
    std::uint32_t place;
    if (!nearest_triangle<false>(*meshes_[mesh_index(slot)], local, from, found.t, t, place) || !nearer(t))
      return false;
    found = {t, slot, place, {}};
    return true;
  }
  if (kind == Kind::kCircularTorus && passes_hole(parameters(slot), local)) return false;
  const gpuprims::Hits hits = solid_hits(kind, parameters(slot), {local.origin, local.direction});
  for (int i = 0; i < hits.count; ++i) {
    if (!(hits.hit[i].t >= from)) continue;
    if (!nearer(hits.hit[i].t)) return false;
    found = {hits.hit[i].t, slot, core::kNone, hits.hit[i].normal, Face(hits.hit[i].face)};
    return true;
  }
  return false;
}

Hit Tracer::Impl::finish(const Ray& ray, const Found& found) const {
  dvec3 normal = found.normal;
  std::uint32_t triangle = core::kNone;
  if (found.place != core::kNone) {
    const MeshTree& tree = *meshes_[mesh_index(found.slot)];
    dvec3 c[3];
    tree.corners(found.place, c);
    normal = glm::cross(c[1] - c[0], c[2] - c[0]);
    triangle = tree.triangle(found.place);
  }
  return answer(ray, found, triangle, world_normal(placement(found.slot), normal));
}

/// Calls visit(slot) for items that contain the ray's point where the part begins that a section plane keeps of them.
template <class Visit>
void Tracer::Impl::cuts_at(const Ray& ray, const KeptPart& part, const RayFilter& filter, const Visit& visit) const {
  if (!part.cut || !filter.cuts) return;
  const KeptPart around = widest(ray, part);
  walk(ray, around.from, part.from, filter, [&](Slot slot) {
    const KeptPart of_item = part_of(slot, ray, part);
    if (of_item.from <= of_item.to && encloses(slot, ray, of_item.from)) visit(slot);
    return part.from;
  });
}

Tracer::Impl::Found Tracer::Impl::find_nearest(const Ray& ray, double from, double to, const RayFilter& filter) const {
  Found found;
  found.t = to;
  walk(ray, from, to, filter, [&](Slot slot) {
    nearest_of(slot, ray, from, found);
    return found.t;
  });
  return found;
}

Tracer::Impl::Found Tracer::Impl::find_nearest(const Ray& ray, const KeptPart& part, const RayFilter& filter) const {
  const KeptPart around = widest(ray, part);
  Found found;
  found.t = around.to;
  walk(ray, around.from, around.to, filter, [&](Slot slot) {
    const KeptPart of_item = part_of(slot, ray, part);
    Found nearer = found;
    if (of_item.to < found.t) nearer = {of_item.to};
    if (nearest_of(slot, ray, of_item.from, nearer)) found = nearer;
    return found.t;
  });
  return found;
}

void Tracer::Impl::nearest_in(const Ray& ray, double from, double to, const RayFilter& filter,
                              std::optional<Hit>& hit) const {
  const Found found = find_nearest(ray, from, to, filter);
  if (found.slot != core::kNone) hit = finish(ray, found);
}

FirstHit Tracer::Impl::first(const Ray& ray, const RayFilter& filter) const {
  if (filter.sections.empty()) {
    const Found found = find_nearest(ray, ray.t_min, ray.t_max, filter);
    return {found.slot, found.t};
  }
  std::optional<Hit> hit;
  nearest_kept(ray, filter, hit);
  return hit ? FirstHit{hit->slot, hit->t} : FirstHit();
}

void Tracer::Impl::nearest_kept(const Ray& ray, const RayFilter& filter, std::optional<Hit>& hit) const {
  const KeptParts parts = kept_parts(ray, filter);
  for (int i = 0; i < parts.count; ++i) {
    const KeptPart& part = parts.part[std::size_t(i)];
    Slot cut = core::kNone;
    cuts_at(ray, part, filter, [&](Slot slot) { cut = std::min(cut, slot); });
    if (cut != core::kNone) {
      hit = cut_hit(ray, part.from, *part.cut, cut);
      return;
    }
    if (const Found found = find_nearest(ray, part, filter); found.slot != core::kNone) {
      hit = finish(ray, found);
      return;
    }
  }
}

/// Whether an item is hit from … to.
bool Tracer::Impl::any_of(Slot slot, const Ray& ray, double from, double to) const {
  ItemRay local;
  if (!to_item(*snapshot_, placement(slot), ray.origin, ray.direction, local)) return false;
  const Kind kind = snapshot_->kind(slot);
  if (is_mesh(kind)) {
    double t;
    std::uint32_t place;
    return nearest_triangle<true>(*meshes_[mesh_index(slot)], local, from, to, t, place);
  }
  const gpuprims::Hits hits = solid_hits(kind, parameters(slot), {local.origin, local.direction});
  return std::any_of(hits.hit.begin(), hits.hit.begin() + hits.count,
                     [&](const auto& hit) { return hit.t >= from && hit.t <= to; });
}

bool Tracer::Impl::any(const Ray& ray, const RayFilter& filter) const {
  const KeptParts parts = kept_parts(ray, filter);
  bool hit = false;
  for (int i = 0; i < parts.count && !hit; ++i) {
    const KeptPart& part = parts.part[std::size_t(i)];
    cuts_at(ray, part, filter, [&](Slot) { hit = true; });
    if (hit) break;
    const KeptPart around = widest(ray, part);
    walk(ray, around.from, around.to, filter, [&](Slot slot) {
      const KeptPart of_item = part_of(slot, ray, part);
      hit = any_of(slot, ray, of_item.from, of_item.to);
      return hit ? -kInfinity : around.to;
    });
  }
  return hit;
}

void Tracer::Impl::all_of(Slot slot, const Ray& ray, double from, double to, std::vector<Hit>& hits) const {
  ItemRay local;
  if (!to_item(*snapshot_, placement(slot), ray.origin, ray.direction, local)) return;
  const Kind kind = snapshot_->kind(slot);
  const auto add = [&](const Found& found) {
    if (found.t >= from && found.t <= to) hits.push_back(finish(ray, found));
  };
  if (!is_mesh(kind)) {
    const gpuprims::Hits crossings = solid_hits(kind, parameters(slot), {local.origin, local.direction});
    for (int i = 0; i < crossings.count; ++i)
      add({crossings.hit[i].t, slot, core::kNone, crossings.hit[i].normal, Face(crossings.hit[i].face)});
    return;
  }
  const MeshTree& tree = *meshes_[mesh_index(slot)];
  RayFrame frame;
  if (tree.empty || !enter(tree.space, tree.per_unit * local.origin, tree.per_unit * local.direction, from, to, frame))
    return;
  struct Collector : HitFilter {
    std::vector<std::uint32_t> places;
  } collector;
  collector.crossed = [](HitFilter& base, std::uint32_t place) {
    static_cast<Collector&>(base).places.push_back(place);
    return kNotCrossed;
  };
  kernels().nearest({tree.nodes.data(), tree.blocks.data(), tree.root, &frame.boxes, triangle_ray(frame),
                     std::numeric_limits<float>::infinity(), frame.across(), &collector});
  for (const std::uint32_t place : collector.places) {
    dvec3 corners[3];
    tree.corners(place, corners);
    add({frame.t(crossing(frame, corners)), slot, place, {}});
  }
}

void Tracer::Impl::all(const Ray& ray, const RayFilter& filter, std::vector<Hit>& hits) const {
  hits.clear();
  const KeptParts parts = kept_parts(ray, filter);
  for (int i = 0; i < parts.count; ++i) {
    const KeptPart& part = parts.part[std::size_t(i)];
    cuts_at(ray, part, filter, [&](Slot slot) { hits.push_back(cut_hit(ray, part.from, *part.cut, slot)); });
    const KeptPart around = widest(ray, part);
    walk(ray, around.from, around.to, filter, [&](Slot slot) {
      const KeptPart of_item = part_of(slot, ray, part);
      all_of(slot, ray, of_item.from, of_item.to, hits);
      return around.to;
    });
  }
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return a.t != b.t ? a.t < b.t : a.slot != b.slot ? a.slot < b.slot : a.triangle < b.triangle;
  });
}

// --- public interface ------------------------------------------------------------------------------------------------

core::Expected<Tracer> Tracer::create(const core::Snapshot& snapshot, int threads, const std::stop_token& stop) {
  auto impl = std::make_unique<Impl>(snapshot);
  if (auto done = impl->build(threads, stop); !done) return tl::unexpected(done.error());
  return Tracer(std::move(impl));
}

Tracer::Tracer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;
Tracer::~Tracer() = default;

core::Expected<void> Tracer::update(std::span<const Slot> touched) {
  return impl_->update(touched);
}
core::Expected<std::optional<Hit>> Tracer::nearest(const Ray& ray, const RayFilter& filter) const {
  core::Expected<std::optional<Hit>> result;
  if (is_ray(ray))
    impl_->nearest(ray, filter, *result);
  else
    result = tl::unexpected(fault(ray));
  return result;
}
core::Expected<FirstHit> Tracer::first(const Ray& ray, const RayFilter& filter) const {
  if (!is_ray(ray)) return tl::unexpected(fault(ray));
  return impl_->first(ray, filter);
}
template <class Answer>
core::Expected<void> Tracer::nearest_of(std::span<const Ray> rays, std::span<Answer> hits,
                                        const RayFilter& filter) const {
  if (hits.size() != rays.size()) return core::fail("nearest: there must be as many hits as rays");
  const std::size_t done = impl_->nearest(rays, filter, hits);
  if (done != rays.size()) return core::fail("rays[" + std::to_string(done) + "]: " + fault(rays[done]).message);
  return {};
}
core::Expected<void> Tracer::nearest(std::span<const Ray> rays, std::span<Hit> hits, const RayFilter& filter) const {
  return nearest_of(rays, hits, filter);
}
core::Expected<void> Tracer::nearest(std::span<const Ray> rays, std::span<FirstHit> hits,
                                     const RayFilter& filter) const {
  return nearest_of(rays, hits, filter);
}
core::Expected<bool> Tracer::any(const Ray& ray, const RayFilter& filter) const {
  if (!is_ray(ray)) return tl::unexpected(fault(ray));
  return impl_->any(ray, filter);
}
core::Expected<void> Tracer::any(std::span<const Ray> rays, std::span<bool> hit, const RayFilter& filter) const {
  if (hit.size() != rays.size()) return core::fail("any: there must be as many answers as rays");
  const std::size_t done = impl_->any(rays, filter, hit);
  if (done != rays.size()) return core::fail("rays[" + std::to_string(done) + "]: " + fault(rays[done]).message);
  return {};
}
core::Expected<void> Tracer::all(const Ray& ray, std::vector<Hit>& hits, const RayFilter& filter) const {
  if (!is_ray(ray)) return tl::unexpected(fault(ray));
  impl_->all(ray, filter, hits);
  return {};
}
const core::Snapshot& Tracer::snapshot() const {
  return impl_->snapshot();
}
TracerMemory Tracer::memory() const {
  return impl_->memory();
}

}  // namespace sightline::raytrace
