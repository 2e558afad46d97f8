// raytrace: exact visibility by rays. What a ray hits first, whether it hits anything, and everything that it crosses.
//
//   auto tracer = raytrace::Tracer::create(snapshot);
//   if (auto hit = tracer->nearest({.origin = eye, .direction = towards}); hit && *hit) use((*hit)->item);
//
// Solids are hit where gpuprims' reference intersectors say, in double. Meshes are hit watertight: no ray passes
// between two triangles that share an edge or a corner. Lines are never hit, nor are items whose placement is singular
// (its linear part squeezes them flat). Both sides of every surface are hit.
//
// Errors. Items are where the snapshot places them. A solid's hit is exact up to double rounding: t is off by at most
// kSolidError of the coordinates involved (the lengths of the ray's origin, of the item's, and of the item's diagonal),
// over the length of the direction; where a ray grazes the surface, over the sine of the angle between them, too. A
// mesh is hit as if the ray passed it displaced by at most kMeshError of the mesh's size: the largest of its local
// coordinates, or twice its diagonal, whichever is more; and by a solid's error besides. Where two of its triangles are
// nearer to each other than that, either may be the nearest. Given the triangle, t is the ray's crossing with it, as
// exact as a solid's; of a triangle that the ray sees thinner than the displacement it is that of any of its points.
// Where a surface is nearer to the ray than its error without being met, or is met as near to its edge, either may be
// found; and of surfaces that are nearer to one another than their errors, either may be the nearest. Placements that
// nearly are singular add the loss of their inverse.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string_view>
#include <vector>

#include "sightline/core/api.h"
#include "sightline/core/error.h"
#include "sightline/core/primitive.h"
#include "sightline/core/ray.h"
#include "sightline/core/snapshot.h"
#include "sightline/core/view.h"

namespace sightline::raytrace {

inline constexpr double kSolidError = 4e-12;
inline constexpr double kMeshError = 1e-6;

/// What rays see: items that share a bit with `layers`, where the section planes keep them. Where a section cuts an
/// item open, the cut is a face (Face::kCut), as renderers fill it: of solids, and of meshes that are closed
/// (core::enclosure). It is hit by rays that come from what the sections remove.
struct RayFilter {
  std::uint32_t layers = core::kDefaultLayerMask;
  std::vector<core::Plane> sections;  ///< as in core::View
  core::SectionMode section_mode = core::SectionMode::kIntersection;
  bool cuts = true;  ///< false: cuts are not hit, and rays see the insides
  /// Slots that rays pass: a bit per slot, from the lowest of the first word on. Slots beyond the last word have none.
  std::span<const std::uint64_t> without = {};

  bool passes(core::Slot slot) const {
    return slot / 64 < without.size() && (without[slot / 64] >> slot % 64 & 1u) != 0;
  }
};
/// The filter of a view's layers and sections, with cuts.
SIGHTLINE_API RayFilter filter_of(const core::View& view);

using core::Face;

/// A crossing of a ray with a surface.
struct Hit {
  core::Slot slot = core::kNone;
  core::ItemId item = core::kNoItem;
  double t = 0.0;
  core::dvec3 point{0.0};                ///< in the world
  core::dvec3 normal{0.0};               ///< in the world, of unit length, out of the solid (not towards the ray)
  std::uint32_t triangle = core::kNone;  ///< of a mesh: indices 3 triangle … 3 triangle + 2; kNone for solids and cuts
  Face face = Face::kTriangle;
};

/// The part of the nearest hit that images of ids and of distances need.
struct FirstHit {
  core::Slot slot = core::kNone;  ///< kNone: nothing is hit, and t says nothing
  double t = 0.0;
};

/// Bytes held, and what for.
struct TracerMemory {
  std::size_t items = 0;   ///< hierarchy over the items
  std::size_t meshes = 0;  ///< hierarchies over triangles, with their own copies of the corners
  std::size_t total() const { return items + meshes; }
};

/// A hierarchy over the items of a snapshot, and one over the triangles of each mesh that they share. Several threads
/// may trace at once. Answers do not depend on the number of threads, nor on the instruction set.
class SIGHTLINE_API Tracer {
 public:
  /// The snapshot must outlive the tracer and stay at its address. `threads` build; 0: all that OpenMP offers. Fails
  /// for a mesh of 2^28 triangles or more, and soon, within milliseconds, after `stop` was requested.
  static core::Expected<Tracer> create(const core::Snapshot& snapshot, int threads = 0,
                                       const std::stop_token& stop = {});
  Tracer(Tracer&&) noexcept;
  Tracer& operator=(Tracer&&) noexcept;
  ~Tracer();

  /// Follows Snapshot::apply(), which has returned `touched`; slots appended since are found by themselves. Refits the
  /// boxes above touched slots, and makes small hierarchies of appended ones. No query may run meanwhile. Time is
  /// proportional to the number of touched and appended slots, times a logarithm. Fails as create() does; then nothing
  /// has changed.
  core::Expected<void> update(std::span<const core::Slot> touched);

  // All queries fail where the ray's origin or direction is not finite, its direction is zero, or an end is NaN.

  /// The hit with the least t; of several at the very same t, that in the lowest slot.
  core::Expected<std::optional<Hit>> nearest(const core::Ray& ray, const RayFilter& filter = {}) const;
  /// Its slot and t alone, in less time: for distances and lines of sight.
  core::Expected<FirstHit> first(const core::Ray& ray, const RayFilter& filter = {}) const;
  /// nearest() for many rays, for images: hits[i] is what nearest(rays[i]) answers, bit for bit. Only of surfaces
  /// that are nearer to one another than their errors may it be another. Its slot is kNone where nothing is hit; the
  /// rest then says nothing. Rays that follow one another should be near to each other, as those of 4 x 4 pixels are:
  /// sixteen at a time are traced together. Fails as nearest() does, naming the first such ray, and unless there are as
  /// many hits as rays; then `hits` may hold anything.
  core::Expected<void> nearest(std::span<const core::Ray> rays, std::span<Hit> hits,
                               const RayFilter& filter = {}) const;
  /// Nearest hits without points, normals and faces, which take a tenth to a fifth of the time.
  core::Expected<void> nearest(std::span<const core::Ray> rays, std::span<FirstHit> hits,
                               const RayFilter& filter = {}) const;
  /// Whether anything is hit. Faster than nearest().
  core::Expected<bool> any(const core::Ray& ray, const RayFilter& filter = {}) const;
  /// Answers for many rays, as for shadows: hit[i] is what any(rays[i]) answers. Fails as nearest() of many rays does.
  core::Expected<void> any(std::span<const core::Ray> rays, std::span<bool> hit, const RayFilter& filter = {}) const;
  /// Every crossing, in rising t: each entry and exit once, for closed meshes also where the ray meets an edge or a
  /// corner. Replaces the contents of `hits`.
  core::Expected<void> all(const core::Ray& ray, std::vector<Hit>& hits, const RayFilter& filter = {}) const;

  const core::Snapshot& snapshot() const;
  TracerMemory memory() const;

 private:
  class Impl;
  template <class Answer>
  core::Expected<void> nearest_of(std::span<const core::Ray> rays, std::span<Answer> hits,
                                  const RayFilter& filter) const;
  explicit Tracer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sightline::raytrace
