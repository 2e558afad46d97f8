// Internal to raytrace: what the tracer is made of, for the files that implement its queries.
#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sightline/gpuprims/internal/ray.h"
#include "sightline/raytrace/internal/item_trees.h"
#include "sightline/raytrace/internal/mesh_tree.h"
#include "sightline/raytrace/internal/packet.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::raytrace {

using core::Kind;
using core::Ray;
using core::Slot;

inline constexpr float kNotCrossed = std::numeric_limits<float>::quiet_NaN();  ///< HitFilter::crossed()

/// Whether the tracer accepts it: finite, with a direction, and ends that are numbers.
bool is_ray(const Ray& ray);

/// A part of a ray that the section planes keep.
struct KeptPart {
  double from, to;
  const core::Plane *cut = nullptr,
                    *end = nullptr;  ///< the planes behind which it begins, and ends; null: the ray does
};

/// None to two parts, in rising order. Also those that are empty, but for the rounding of items that a plane touches.
struct KeptParts {
  std::array<KeptPart, 2> part;
  int count = 0;
  void add(const KeptPart& added) {
    if (added.from < kInfinity && added.to > -kInfinity) part[std::size_t(count++)] = added;
  }
};
KeptParts kept_parts(const Ray& ray, const RayFilter& filter);

/// The inverse of a linear map is the transpose of its cofactors over its determinant.
struct Cofactors {
  dvec3 column[3];
  double determinant;

  explicit Cofactors(const core::mat3& linear) {
    const dvec3 x(linear[0]), y(linear[1]), z(linear[2]);
    column[0] = glm::cross(y, z);
    column[1] = glm::cross(z, x);
    column[2] = glm::cross(x, y);
    determinant = glm::dot(x, column[0]);
  }
};

/// A ray in an item's local coordinates, with the same t.
struct ItemRay {
  dvec3 origin, direction;
};

/// Whether a linear map is the identity, as of most meshes. May say false where it is.
inline constexpr core::mat3 kUnity(1.0f);
inline bool is_unity(const core::mat3& linear) {
  return std::memcmp(&linear, &kUnity, sizeof kUnity) == 0;
}

/// False: the placement is singular.
inline bool to_item(const core::Snapshot& snapshot, const core::Placement& placement, const dvec3& origin,
                    const dvec3& direction, ItemRay& out) {
  const dvec3 o = (origin - snapshot.chunk_origins()[placement.chunk]) - dvec3(placement.origin);
  if (is_unity(placement.linear)) {
    out = {o + 0.0, direction + 0.0};  // what the map would give: -0 becomes 0
    return true;
  }
  const Cofactors map(placement.linear);
  const double inverse = 1.0 / map.determinant;
  if (!(std::fabs(inverse) < kInfinity) || inverse == 0.0) return false;
  for (int i = 0; i < 3; ++i) {
    out.origin[i] = inverse * glm::dot(map.column[i], o);
    out.direction[i] = inverse * glm::dot(map.column[i], direction);
  }
  return true;
}

/// Crossings with a solid, in rising t.
gpuprims::Hits solid_hits(Kind kind, const float* parameters, const core::Ray& ray);

inline bool is_mesh(Kind kind) {
  return int(kind) >= core::kPrimitiveKindCount;
}

/// A hierarchy's space for packets whose origins are to be moved by `shift`.
inline LaneSpace lanes_of(const TreeSpace& space, const dvec3& shift) {
  return {{shift.x, shift.y, shift.z},
          {space.centre.x, space.centre.y, space.centre.z},
          {space.half.x, space.half.y, space.half.z},
          space.radius,
          space.reach};
}

/// Tracer documents each function.
class Tracer::Impl {
 public:
  explicit Impl(const core::Snapshot& snapshot) : snapshot_(&snapshot) {}

  core::Expected<void> build(int threads, const std::stop_token& stop);
  core::Expected<void> update(std::span<const Slot> touched);
  void nearest(const Ray& ray, const RayFilter& filter, std::optional<Hit>& hit) const {
    filter.sections.empty() ? nearest_in(ray, ray.t_min, ray.t_max, filter, hit) : nearest_kept(ray, filter, hit);
  }
  FirstHit first(const Ray& ray, const RayFilter& filter) const;
  /// Returns the first ray that is none, or their number. In stream.cpp, for Hit and FirstHit.
  template <class Answer>
  std::size_t nearest(std::span<const Ray> rays, const RayFilter& filter, std::span<Answer> hits) const;
  bool any(const Ray& ray, const RayFilter& filter) const;
  std::size_t any(std::span<const Ray> rays, const RayFilter& filter, std::span<bool> hit) const;
  void all(const Ray& ray, const RayFilter& filter, std::vector<Hit>& hits) const;
  const core::Snapshot& snapshot() const { return *snapshot_; }
  TracerMemory memory() const;

 private:
  struct Found {
    double t = kInfinity;
    Slot slot = core::kNone;
    std::uint32_t place = core::kNone;  // of meshes
    dvec3 normal{0.0};                  // of solids, local
    Face face = Face::kTriangle;
  };
  class Packet;
  template <class Answer>
  std::size_t by_packets(std::span<const Ray> rays, const RayFilter& filter, bool any, const Answer& answer) const;
  template <class Meet>
  void walk(const Ray& ray, double from, double to, const RayFilter& filter, const Meet& meet) const;
  bool nearest_of(Slot slot, const Ray& ray, double from, Found& found) const;
  Found find_nearest(const Ray& ray, double from, double to, const RayFilter& filter) const;
  void nearest_kept(const Ray& ray, const RayFilter& filter, std::optional<Hit>& hit) const;
  void nearest_in(const Ray& ray, double from, double to, const RayFilter& filter, std::optional<Hit>& hit) const;
  Found find_nearest(const Ray& ray, const KeptPart& part, const RayFilter& filter) const;
  /// How far planes are moved outwards (core/internal/section_rounding.h), in t, for an item: the part that is kept of
  /// it. Without an item at least as much.
  KeptPart part_of(Slot slot, const Ray& ray, const KeptPart& part) const;
  KeptPart widest(const Ray& ray, const KeptPart& part) const;
  template <class Visit>
  void cuts_at(const Ray& ray, const KeptPart& part, const RayFilter& filter, const Visit& visit) const;
  Hit cut_hit(const Ray& ray, double t, const core::Plane& plane, Slot slot) const;
  bool encloses(Slot slot, const Ray& ray, double t) const;
  core::Enclosure enclosure(std::uint32_t mesh) const;
  bool any_of(Slot slot, const Ray& ray, double from, double to) const;
  void all_of(Slot slot, const Ray& ray, double from, double to, std::vector<Hit>& hits) const;
  Hit finish(const Ray& ray, const Found& found) const;
  /// `normal`: in the world.
  Hit answer(const Ray& ray, const Found& found, std::uint32_t triangle, const dvec3& normal) const {
    return {found.slot, snapshot_->item(found.slot), found.t, ray.origin + found.t * ray.direction, normal, triangle,
            found.face};
  }
  const core::Placement& placement(Slot slot) const {
    return snapshot_->of_kind(snapshot_->kind(slot)).placements[snapshot_->index_in_kind(slot)];
  }
  const float* parameters(Slot slot) const {
    const Kind kind = snapshot_->kind(slot);
    const std::size_t index = snapshot_->index_in_kind(slot);
    return snapshot_->of_kind(kind).parameters.data() + index * std::size_t(core::parameter_count(kind));
  }
  std::uint32_t mesh_index(Slot slot) const {
    return snapshot_->of_kind(snapshot_->kind(slot)).meshes[snapshot_->index_in_kind(slot)];
  }
  bool is_built_from(std::uint32_t index, const std::shared_ptr<const core::Mesh>& mesh) const;
  core::Expected<void> add_meshes(std::span<const Slot> slots, int threads, const std::stop_token& stop = {});
  void count_users(std::span<const Slot> slots);

  const core::Snapshot* snapshot_;
  ItemTrees items_;
  std::vector<std::unique_ptr<const MeshTree>> meshes_;  // by mesh index; null: no item has had it
  std::vector<std::weak_ptr<const core::Mesh>> built_from_;
  std::vector<std::uint32_t> users_;  // by mesh index: slots that counted_ has
  std::vector<bool> counted_;         // by slot
  // What they enclose, 1 more than core::Enclosure; 0 until a section cuts one.
  mutable std::deque<std::atomic<std::uint8_t>> enclosures_;
};

}  // namespace sightline::raytrace
