#include "sightline/culling/box_culler.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>

#include <glm/gtc/type_ptr.hpp>

#include "sightline/core/block_order.h"
#include "sightline/core/internal/prefetch.h"
#include "sightline/core/internal/scratch.h"
#include "sightline/core/item_bounds.h"
#include "sightline/core/thread_pool.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/frustum/internal/set_parts.h"
#include "sightline/culling/frustum/internal/slot_list.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/culling/queries/spatial_queries.h"

namespace sightline::culling {
namespace {

/// Boxes of a job for threads, and changes that are worth threads.
constexpr std::size_t kJobBoxes = 8192, kChangesWorthThreads = 4096;
constexpr const char* kMovedFrom = "box culler: its boxes were moved to another one";

struct VisibleBuffers {
  core::VisibleSet set;
  SetParts parts;
  std::vector<std::size_t> firsts;  // of each part's slots in the list of all

  std::size_t memory_bytes() const { return core::bytes_of(set, parts, firsts); }
};

struct HitBuffer {
  std::vector<SlotDistance> hits;
  std::size_t memory_bytes() const { return core::bytes_of(hits); }
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

core::Expected<void> check_count(std::size_t expected, std::size_t found) {
  if (found == expected) return {};
  return core::fail("box culler: expected " + std::to_string(expected) + " boxes, found " + std::to_string(found));
}

/// Lets queries run side by side and changes alone. Whoever comes takes its turn first, so that queries without a pause
/// do not keep a change waiting.
class QueryMutex {
 public:
  std::shared_lock<std::shared_mutex> for_query() {
    const std::lock_guard turn(turn_);
    return std::shared_lock(mutex_);
  }
  std::unique_lock<std::shared_mutex> for_change() {
    const std::lock_guard turn(turn_);
    return std::unique_lock(mutex_);
  }

 private:
  std::mutex turn_;
  std::shared_mutex mutex_;
};

std::size_t job_count(std::size_t boxes) {
  return (boxes + kJobBoxes - 1) / kJobBoxes;
}

/// Calls job(number, begin, end) for ranges that cover 0 … count - 1.
template <class Job>
void for_ranges(std::size_t count, core::ThreadPool* threads, const Job& job) {
  core::ThreadPool::run_on(threads, std::uint32_t(job_count(count)), [&](std::uint32_t i) {
    const std::size_t begin = i * kJobBoxes;
    job(i, begin, std::min(count, begin + kJobBoxes));
  });
}

/// Fails with the first box that is not acceptable.
core::Expected<core::AabbD> union_of(std::span<const core::AabbD> boxes, core::ThreadPool* threads) {
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
  core::ThreadPool threads;             // for the occlusion test and large changes
  QueryMutex mutex;

  /// The middle of the boxes, to which coordinates in float are relative.
  static core::dvec3 origin_of(const core::AabbD& all) {
    return all.empty() ? core::dvec3(0.0) : glm::round(all.centre());
  }

  SpatialQueries queries() const { return {bounds, culler->hierarchy()}; }
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
  core::Expected<void> check(std::span<const std::uint32_t> indices, std::span<const core::AabbD> boxes) const;
  void replace(std::span<const std::uint32_t> indices, std::span<const core::AabbD> boxes);
  void replace_all(std::span<const core::AabbD> boxes, const core::AabbD& all);
};

core::Expected<void> BoxCuller::Impl::check(std::span<const std::uint32_t> indices,
                                            std::span<const core::AabbD> boxes) const {
  if (auto fits = check_count(indices.size(), boxes.size()); !fits) return fits;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (indices[i] >= slot_of.size())
      return core::fail("box culler: expected indices below " + std::to_string(slot_of.size()) + ", found " +
                        std::to_string(indices[i]));
    if (!acceptable(boxes[i])) return refuse(indices[i]);
  }
  return {};
}

/// Boxes lie all over the arrays, so their lines are prefetched.
void BoxCuller::Impl::replace(std::span<const std::uint32_t> indices, std::span<const core::AabbD> boxes) {
  changed.resize(indices.size());
  for (std::size_t i = 0; i < indices.size(); ++i) changed[i] = slot_of[indices[i]];
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
  for_ranges(boxes.size(), &threads, [&](std::uint32_t job, std::size_t begin, std::size_t end) {
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

BoxCuller::Impl& BoxCuller::impl() const {
  static const std::unique_ptr<Impl> nothing = std::move(create({})->impl_);
  return impl_ ? *impl_ : *nothing;
}

core::Expected<BoxCuller> BoxCuller::create(std::span<const core::AabbD> boxes) {
  if (boxes.size() >= core::kNone / 2) return core::fail("box culler: expected fewer than 2^31 - 1 boxes");
  auto impl = std::make_unique<Impl>();
  // Threads start with work that is worth them, which a culler may never have; this is a small part of its making.
  const auto all = union_of(boxes, nullptr);
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
  return impl().index_of.size();
}

const core::ItemBounds& BoxCuller::bounds() const {
  return impl().bounds;
}

const CpuCuller& BoxCuller::culler() const {
  return *impl().culler;
}

std::span<const std::uint32_t> BoxCuller::indices() const {
  return impl().index_of;
}

core::Expected<void> BoxCuller::visible(const double clip_from_world[16], core::ClipDepth depth,
                                        std::vector<std::uint32_t>& indices) const {
  return visible(glm::make_mat4(clip_from_world), depth, indices);
}

core::Expected<void> BoxCuller::visible(const core::dmat4& clip_from_world, core::ClipDepth depth,
                                        std::vector<std::uint32_t>& indices) const {
  if (!impl_) return core::fail(kMovedFrom);
  const auto view = core::View::from_matrices(core::dmat4(1.0), clip_from_world, depth);
  if (!view) return tl::unexpected(view.error());
  visible(*view, indices);
  return {};
}

void BoxCuller::visible(const core::View& view, std::vector<std::uint32_t>& indices) const {
  Impl& boxes = impl();
  const auto lock = boxes.mutex.for_query();
  const core::Scratch<VisibleBuffers> scratch;
  boxes.culler->cull(view, scratch->set);
  boxes.list(scratch->set, indices);
}

void BoxCuller::visible(const core::View& view, const DepthPyramid& depth, std::vector<std::uint32_t>& indices) const {
  if (depth.level_count() == 0) return visible(view, indices);
  Impl& boxes = impl();
  const auto lock = boxes.mutex.for_query();
  const core::Scratch<VisibleBuffers> scratch;
  auto& [set, parts, firsts] = *scratch;
  boxes.culler->cull(view, set);
  const OcclusionTest test(view, boxes.bounds.origin, depth.width(), depth.height(), depth);
  parts.split(set);
  parts.for_each(&boxes.threads, [&](core::VisibleSet& part, std::uint32_t) {
    test.filter(boxes.bounds, part, part, {}, nullptr, &boxes.culler->hierarchy());
  });
  firsts.assign(1, 0);
  for (std::uint32_t i = 0; i < parts.count(); ++i) firsts.push_back(firsts.back() + parts[i].count());
  indices.resize(firsts.back());
  const std::span<const std::size_t> to = firsts;
  parts.for_each(&boxes.threads, [&](const core::VisibleSet& part, std::uint32_t i) {
    list_ids(part, boxes.index_of, std::span(indices).subspan(to[i], to[i + 1] - to[i]));
  });
}

namespace {

/// Slots become indices of boxes, in rising order.
void sort_by_index(std::span<const std::uint32_t> index_of, std::vector<std::uint32_t>& slots) {
  for (std::uint32_t& slot : slots) slot = index_of[slot];
  std::sort(slots.begin(), slots.end());
}

void list_hits(std::span<const std::uint32_t> index_of, const std::vector<SlotDistance>& found,
               std::vector<BoxHit>& hits) {
  hits.clear();
  for (const auto& [slot, distance] : found) hits.push_back({index_of[slot], distance});
}

}  // namespace

void BoxCuller::in_box(const core::AabbD& range, bool inside, std::vector<std::uint32_t>& indices) const {
  Impl& boxes = impl();
  const auto lock = boxes.mutex.for_query();
  if (inside)
    boxes.queries().inside(range, core::kLayerModel, indices);
  else
    boxes.queries().intersecting(range, core::kLayerModel, indices);
  sort_by_index(boxes.index_of, indices);
}

void BoxCuller::around(const core::dvec3& point, double radius, std::vector<std::uint32_t>& indices) const {
  Impl& boxes = impl();
  const auto lock = boxes.mutex.for_query();
  boxes.queries().around(point, radius, core::kLayerModel, indices);
  sort_by_index(boxes.index_of, indices);
}

void BoxCuller::along(const core::Ray& ray, std::size_t most, std::vector<BoxHit>& hits) const {
  Impl& boxes = impl();
  const auto lock = boxes.mutex.for_query();
  const core::Scratch<HitBuffer> scratch;
  boxes.queries().first_along(ray, most, core::kLayerModel, scratch->hits);
  list_hits(boxes.index_of, scratch->hits, hits);
}

void BoxCuller::nearest(const core::dvec3& point, std::size_t most, std::vector<BoxHit>& hits) const {
  Impl& boxes = impl();
  const auto lock = boxes.mutex.for_query();
  const core::Scratch<HitBuffer> scratch;
  boxes.queries().nearest(point, most, core::kLayerModel, scratch->hits);
  list_hits(boxes.index_of, scratch->hits, hits);
}

core::Expected<void> BoxCuller::update(std::uint32_t index, const core::AabbD& box) {
  return update(std::span(&index, 1), std::span(&box, 1));
}

core::Expected<void> BoxCuller::update(std::span<const std::uint32_t> indices, std::span<const core::AabbD> boxes) {
  if (!impl_) return core::fail(kMovedFrom);
  if (auto fits = impl_->check(indices, boxes); !fits) return fits;
  const auto lock = impl_->mutex.for_change();
  impl_->replace(indices, boxes);
  return {};
}

core::Expected<void> BoxCuller::refit(std::span<const core::AabbD> boxes) {
  if (!impl_) return core::fail(kMovedFrom);
  if (auto fits = check_count(size(), boxes.size()); !fits) return fits;
  const auto lock = impl_->mutex.for_change();
  const auto all = union_of(boxes, &impl_->threads);
  if (!all) return tl::unexpected(all.error());
  impl_->replace_all(boxes, *all);
  return {};
}

}  // namespace sightline::culling
