#include "sightline/culling/box_culler.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>

#include <glm/gtc/type_ptr.hpp>

#include "sightline/core/block_order.h"
#include "sightline/core/internal/prefetch.h"
#include "sightline/core/internal/scratch.h"
#include "sightline/core/item_bounds.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/frustum/cull_threads.h"
#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/frustum/internal/slot_list.h"
#include "sightline/culling/occlusion/occlusion_test.h"

namespace sightline::culling {
namespace {

/// Boxes of a job for threads, and changes that are worth threads.
constexpr std::size_t kJobBoxes = 8192, kChangesWorthThreads = 4096;

struct VisibleBuffers {
  core::VisibleSet set;
  SetParts parts;
  std::vector<std::size_t> firsts;  // of each part's slots in the list of all

  std::size_t memory_bytes() const { return core::bytes_of(set, parts, firsts); }
};

bool acceptable(const core::AabbD& box) {
  bool fine = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.min[axis], high = box.max[axis];
    fine = fine && (box.empty() ? !std::isnan(low) && !std::isnan(high) : std::isfinite(low) && std::isfinite(high));
  }
  return fine;
}

tl::unexpected<core::Error> refuse(std::size_t index) {
  return core::fail("box " + std::to_string(index) + ": expected finite corners");
}

std::size_t job_count(std::size_t boxes) {
  return (boxes + kJobBoxes - 1) / kJobBoxes;
}

/// Calls job(number, begin, end) for ranges that cover 0 … count - 1.
template <class Job>
void for_ranges(std::size_t count, CullThreads& threads, const Job& job) {
  threads.run(std::uint32_t(job_count(count)), [&](std::uint32_t i) {
    const std::size_t begin = i * kJobBoxes;
    job(i, begin, std::min(count, begin + kJobBoxes));
  });
}

/// Fails with the first box that is not acceptable.
core::Expected<core::AabbD> union_of(std::span<const core::AabbD> boxes, CullThreads& threads) {
  std::vector<core::AabbD> unions(job_count(boxes.size()));
  std::vector<std::size_t> refused(unions.size(), boxes.size());
  for_ranges(boxes.size(), threads, [&](std::uint32_t job, std::size_t begin, std::size_t end) {
    core::AabbD all;
    for (std::size_t i = end; i-- > begin;) {
      if (!acceptable(boxes[i])) refused[job] = i;
      if (!boxes[i].empty()) all.grow(boxes[i]);
    }
    unions[job] = all;
  });
  core::AabbD all;
  for (std::size_t job = 0; job < unions.size(); ++job) {
    if (refused[job] < boxes.size()) return refuse(refused[job]);
    all.grow(unions[job]);
  }
  return all;
}

}  // namespace

struct BoxCuller::Impl {
  core::ItemBounds bounds;              // by slot
  std::vector<std::uint32_t> index_of;  // slot to index
  std::vector<core::Slot> slot_of;      // index to slot
  std::optional<CpuCuller> culler;      // borrows bounds
  std::size_t empty_boxes = 0;          // which ranges of slots may hold
  std::vector<core::Slot> changed;      // scratch of update()
  mutable CullThreads threads;          // for the occlusion test and large changes

  /// The middle of the boxes, to which coordinates in float are relative.
  static core::dvec3 origin_of(const core::AabbD& all) {
    return all.empty() ? core::dvec3(0.0) : glm::round(all.centre());
  }

  core::Aabb rounded(const core::AabbD& box) const {
    return box.empty() ? core::Aabb() : core::round_outwards(box, bounds.origin);
  }
  void list(const core::VisibleSet& set, std::vector<std::uint32_t>& indices) const {
    if (empty_boxes == 0) {
      indices.resize(set.count());
      return list_ids(set, index_of, indices);
    }
    indices.clear();
    set.for_each_slot([&](core::Slot slot) {
      if (!bounds.vacant(slot)) indices.push_back(index_of[slot]);
    });
  }
  void count_empty() {
    empty_boxes = 0;
    for (core::Slot slot = 0; slot < bounds.size(); ++slot) empty_boxes += bounds.vacant(slot) ? 1 : 0;
  }
  void replace(std::span<const std::uint32_t> indices, std::span<const core::AabbD> boxes);
  void replace_all(std::span<const core::AabbD> boxes, const core::AabbD& all);
};

/// Boxes lie all over the arrays, so their lines are prefetched.
void BoxCuller::Impl::replace(std::span<const std::uint32_t> indices, std::span<const core::AabbD> boxes) {
  changed.resize(indices.size());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    assert(indices[i] < slot_of.size());
    changed[i] = slot_of[indices[i]];
  }
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const std::size_t next = i + core::kPrefetchAhead;
    for (int axis = 0; axis < 6 && next < boxes.size(); ++axis) core::prefetch(bounds.coordinate(axis)[changed[next]]);
    empty_boxes -= bounds.vacant(changed[i]) ? 1 : 0;
    empty_boxes += boxes[i].empty() ? 1 : 0;
    bounds.set(changed[i], rounded(boxes[i]));
  }
  culler->update(changed, changed.size() < kChangesWorthThreads ? nullptr : &threads);
}

void BoxCuller::Impl::replace_all(std::span<const core::AabbD> boxes, const core::AabbD& all) {
  std::vector<core::Aabb> extents(job_count(boxes.size()));
  bounds.origin = origin_of(all);
  for_ranges(boxes.size(), threads, [&](std::uint32_t job, std::size_t begin, std::size_t end) {
    core::Aabb extent;
    for (std::size_t slot = begin; slot < end; ++slot) {
      if (slot + core::kPrefetchAhead < end) core::prefetch(boxes[index_of[slot + core::kPrefetchAhead]]);
      const core::Aabb box = rounded(boxes[index_of[slot]]);
      bounds.store(slot, box);
      extent.grow(box);
    }
    extents[job] = extent;
  });
  core::Aabb extent;
  for (const core::Aabb& part : extents) extent.grow(part);
  bounds.set_extent(extent);
  culler->refit(&threads);
  count_empty();
}

BoxCuller::BoxCuller(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BoxCuller::BoxCuller(BoxCuller&&) noexcept = default;
BoxCuller& BoxCuller::operator=(BoxCuller&&) noexcept = default;
BoxCuller::~BoxCuller() = default;

core::Expected<BoxCuller> BoxCuller::create(std::span<const core::AabbD> boxes) {
  if (boxes.size() >= core::kNone / 2) return core::fail("box culler: expected fewer than 2^31 - 1 boxes");
  auto impl = std::make_unique<Impl>();
  const auto all = union_of(boxes, impl->threads);
  if (!all) return tl::unexpected(all.error());
  impl->bounds.origin = Impl::origin_of(*all);
  std::vector<core::Aabb> rounded;
  rounded.reserve(boxes.size());
  for (const core::AabbD& box : boxes) rounded.push_back(impl->rounded(box));
  impl->index_of = core::block_order(rounded);
  impl->slot_of.resize(boxes.size());
  impl->bounds.resize(boxes.size());
  for (core::Slot slot = 0; slot < boxes.size(); ++slot) {
    impl->slot_of[impl->index_of[slot]] = slot;
    impl->bounds.set(slot, rounded[impl->index_of[slot]]);
  }
  impl->count_empty();
  impl->culler.emplace(impl->bounds);
  return BoxCuller(std::move(impl));
}

std::size_t BoxCuller::size() const {
  return impl_->index_of.size();
}

const core::ItemBounds& BoxCuller::bounds() const {
  return impl_->bounds;
}

const CpuCuller& BoxCuller::culler() const {
  return *impl_->culler;
}

std::span<const std::uint32_t> BoxCuller::indices() const {
  return impl_->index_of;
}

core::Expected<void> BoxCuller::visible(const double clip_from_world[16], core::ClipDepth depth,
                                        std::vector<std::uint32_t>& indices) const {
  const auto view = core::View::from_matrices(core::dmat4(1.0), glm::make_mat4(clip_from_world), depth);
  if (!view) return tl::unexpected(view.error());
  visible(*view, indices);
  return {};
}

void BoxCuller::visible(const core::View& view, std::vector<std::uint32_t>& indices) const {
  const core::Scratch<VisibleBuffers> scratch;
  impl_->culler->cull(view, scratch->set);
  impl_->list(scratch->set, indices);
}

void BoxCuller::visible(const core::View& view, const DepthPyramid& depth, std::vector<std::uint32_t>& indices) const {
  if (depth.level_count() == 0) return visible(view, indices);
  const core::Scratch<VisibleBuffers> scratch;
  auto& [set, parts, firsts] = *scratch;
  impl_->culler->cull(view, set);
  const OcclusionTest test(view, impl_->bounds.origin, depth.width(), depth.height(), depth);
  parts.split(set);
  parts.for_each(&impl_->threads, [&](core::VisibleSet& part, std::uint32_t) {
    test.filter(impl_->bounds, part, part, {}, nullptr, &impl_->culler->hierarchy());
  });
  firsts.assign(1, 0);
  for (std::uint32_t i = 0; i < parts.count(); ++i) firsts.push_back(firsts.back() + parts[i].count());
  indices.resize(firsts.back());
  const std::span<const std::size_t> to = firsts;
  parts.for_each(&impl_->threads, [&](const core::VisibleSet& part, std::uint32_t i) {
    list_ids(part, impl_->index_of, std::span(indices).subspan(to[i], to[i + 1] - to[i]));
  });
}

core::Expected<void> BoxCuller::update(std::uint32_t index, const core::AabbD& box) {
  return update(std::span(&index, 1), std::span(&box, 1));
}

core::Expected<void> BoxCuller::update(std::span<const std::uint32_t> indices, std::span<const core::AabbD> boxes) {
  assert(indices.size() == boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i)
    if (!acceptable(boxes[i])) return refuse(indices[i]);
  impl_->replace(indices, boxes);
  return {};
}

core::Expected<void> BoxCuller::refit(std::span<const core::AabbD> boxes) {
  assert(boxes.size() == size());
  const auto all = union_of(boxes, impl_->threads);
  if (!all) return tl::unexpected(all.error());
  impl_->replace_all(boxes, *all);
  return {};
}

}  // namespace sightline::culling
