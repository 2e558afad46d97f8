// culling: what a view can see. Its rooms are frustum (view volume, hierarchy), occlusion (samples, contribution, depth
// pyramid, occluders), hybrid (CPU or GPU), queries (boxes, regions, rays) and gpu. This header is its simplest
// interface: boxes in, indices of the visible ones out. No scene, no snapshot, no GL.
//
//   auto culler = culling::BoxCuller::create(boxes);
//   std::vector<std::uint32_t> visible;
//   culler->visible(projection_times_view, core::ClipDepth::kMinusOneToOne, visible);  // a glm::dmat4
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/api.h"
#include "sightline/core/conventions.h"
#include "sightline/core/error.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/ray.h"
#include "sightline/core/view.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/occlusion/depth_pyramid.h"

namespace sightline::culling {

/// A box that a query has found: t along the ray where it enters the box, or metres to a point.
struct BoxHit {
  std::uint32_t index;
  double distance;
};

/// Owns its boxes: a copy in float, rounded outwards, in an order of its own (33 bytes a box with the hierarchy, and 4
/// for each box of the largest batch). Box i is the i-th of those given to create(). Promise: conservative, with the
/// same answer as CpuCuller.
///
/// Several threads may call visible() and the queries at once. Changes wait for those that run, and keep new ones
/// waiting, so each answer is that of the boxes before or after a change. Movable, while no other thread uses it; what
/// was moved from has no boxes, and all its functions that can fail do so.
class SIGHTLINE_API BoxCuller {
 public:
  /// Boxes in world coordinates, in any unit. Empty boxes (min > max) are never visible. Fails on a box with a NaN or
  /// an infinite corner, which the message names, and on 2^31 - 1 boxes or more.
  static core::Expected<BoxCuller> create(std::span<const core::AabbD> boxes);

  BoxCuller(BoxCuller&&) noexcept;
  BoxCuller& operator=(BoxCuller&&) noexcept;
  ~BoxCuller();

  std::size_t size() const;

  /// Replaces the contents of `indices` by the indices of the visible boxes. Their order is unspecified, but the same
  /// for the same boxes. `clip_from_world` is projection * view, sixteen numbers in columns as glUniformMatrix4dv takes
  /// them; `depth` is the range of depths that it projects to. Does not allocate once `indices` and this thread's
  /// scratch memory have grown to their sizes. Fails as core::View::from_matrices() does.
  core::Expected<void> visible(const double clip_from_world[16], core::ClipDepth depth,
                               std::vector<std::uint32_t>& indices) const;
  core::Expected<void> visible(const core::dmat4& clip_from_world, core::ClipDepth depth,
                               std::vector<std::uint32_t>& indices) const;
  /// Visible boxes of a view with its section planes. All boxes are on core::kLayerModel, which views show unless told
  /// otherwise.
  void visible(const core::View& view, std::vector<std::uint32_t>& indices) const;

  /// Visible boxes without those that are occluded in a depth image of this view (OcclusionTest says when) or that
  /// cover none of its pixel centres. The view must know its eye: one made from a combined matrix does not. Large sets
  /// are tested on several threads (core::ThreadPool), which start with the first set that is worth them. A pyramid
  /// that was never built hides nothing.
  void visible(const core::View& view, const DepthPyramid& depth, std::vector<std::uint32_t>& indices) const;

  /// Boxes that share a point with `range`, or with `inside` lie in it, in rising order of their indices. Queries take
  /// and promise what SpatialQueries does, and replace the contents of the lists that they are given.
  void in_box(const core::AabbD& range, bool inside, std::vector<std::uint32_t>& indices) const;
  /// Boxes within `radius` of a point, in rising order.
  void around(const core::dvec3& point, double radius, std::vector<std::uint32_t>& indices) const;
  /// The first `most` boxes that a ray meets, front to back.
  void along(const core::Ray& ray, std::size_t most, std::vector<BoxHit>& hits) const;
  /// The `most` boxes nearest to a point, nearest first.
  void nearest(const core::dvec3& point, std::size_t most, std::vector<BoxHit>& hits) const;

  /// Replaces box `index`. Fails on an index that is not below size() and on a box that create() refuses, and then
  /// changes nothing.
  /// Boxes that move far make culling slower, not wrong, since all keep their places in the order of create(): after
  /// many of them create a new culler.
  core::Expected<void> update(std::uint32_t index, const core::AabbD& box);
  /// Replaces box indices[i] by boxes[i] for each i, with the result of single updates one after the other: of a
  /// repeated index the last box counts. Faster than these, since each hierarchy node is refitted once, large batches
  /// by several threads: 0.15 us a box where a single update takes 0.7 (10,000 of a million boxes, two cores). Fails on
  /// spans of different sizes, on an index that is not below size() and on a box that create() refuses, which the
  /// message names by its index, and then changes nothing.
  core::Expected<void> update(std::span<const std::uint32_t> indices, std::span<const core::AabbD> boxes);
  /// Replaces all boxes: for boxes that move every frame. From then on answers are those of create(boxes), in a sixth
  /// of its time, since nothing is sorted: as after update(), far moves make culling slower. Linear in size(), on
  /// several threads. Fails as create() does and on any other number of boxes than size(), and then changes nothing.
  core::Expected<void> refit(std::span<const core::AabbD> boxes);

  /// What ContributionTest takes: the boxes in an order of the culler's own, by slot, and the culler over them.
  /// indices()[slot] is the index of a box. All belong to this object, and follow its updates, which do not wait for
  /// their use.
  const core::ItemBounds& bounds() const;
  const CpuCuller& culler() const;
  std::span<const std::uint32_t> indices() const;

 private:
  struct Impl;
  explicit BoxCuller(std::unique_ptr<Impl> impl);
  /// Returns that of a culler without boxes where they were moved to another one.
  Impl& impl() const;

  std::unique_ptr<Impl> impl_;
};

}  // namespace sightline::culling
