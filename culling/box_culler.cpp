#include "sightline/culling/box_culler.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>

#include <glm/gtc/type_ptr.hpp>

#include "sightline/core/internal/block_order.h"
#include "sightline/core/item_bounds.h"
#include "sightline/culling/cpu_culler.h"
#include "sightline/culling/cull_threads.h"
#include "sightline/culling/internal/set_parts.h"
#include "sightline/culling/internal/slot_list.h"

namespace sightline::culling {
namespace {

core::Expected<void> check(const core::AabbD& box, std::size_t index) {
  bool fine = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.min[axis], high = box.max[axis];
    fine = fine && (box.empty() ? !std::isnan(low) && !std::isnan(high) : std::isfinite(low) && std::isfinite(high));
  }
  if (!fine) return core::fail("box " + std::to_string(index) + ": expected finite corners");
  return {};
}

}  // namespace

struct BoxCuller::Impl {
  core::ItemBounds bounds;              // by slot
  std::vector<std::uint32_t> index_of;  // slot to index
  std::vector<core::Slot> slot_of;      // index to slot
  std::optional<CpuCuller> culler;      // borrows bounds
  mutable CullThreads threads;          // for the occlusion test

  core::Aabb rounded(const core::AabbD& box) const {
    return box.empty() ? core::Aabb() : core::round_outwards(box, bounds.origin);
  }
  void list(const core::VisibleSet& set, std::vector<std::uint32_t>& indices) const {
    indices.clear();
    set.for_each_slot([&](core::Slot slot) {
      if (!bounds.vacant(slot)) indices.push_back(index_of[slot]);
    });
  }
};

BoxCuller::BoxCuller(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BoxCuller::BoxCuller(BoxCuller&&) noexcept = default;
BoxCuller& BoxCuller::operator=(BoxCuller&&) noexcept = default;
BoxCuller::~BoxCuller() = default;

core::Expected<BoxCuller> BoxCuller::create(std::span<const core::AabbD> boxes) {
  if (boxes.size() >= core::kNone / 2) return core::fail("box culler: expected fewer than 2^31 - 1 boxes");
  core::AabbD around;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (auto fine = check(boxes[i], i); !fine) return tl::unexpected(fine.error());
    if (!boxes[i].empty()) around.grow(boxes[i]);
  }
  auto impl = std::make_unique<Impl>();
  if (!around.empty()) impl->bounds.origin = glm::round(around.centre());
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
  impl->culler.emplace(impl->bounds);
  return BoxCuller(std::move(impl));
}

std::size_t BoxCuller::size() const {
  return impl_->index_of.size();
}

core::Expected<void> BoxCuller::visible(const double clip_from_world[16], core::ClipDepth depth,
                                        std::vector<std::uint32_t>& indices) const {
  const auto view = core::View::from_matrices(core::dmat4(1.0), glm::make_mat4(clip_from_world), depth);
  if (!view) return tl::unexpected(view.error());
  visible(*view, indices);
  return {};
}

void BoxCuller::visible(const core::View& view, std::vector<std::uint32_t>& indices) const {
  thread_local core::VisibleSet set;
  impl_->culler->cull(view, set);
  impl_->list(set, indices);
}

void BoxCuller::visible(const core::View& view, const DepthPyramid& depth, std::vector<std::uint32_t>& indices) const {
  if (depth.level_count() == 0) return visible(view, indices);
  thread_local core::VisibleSet set;
  thread_local SetParts parts;
  thread_local std::vector<std::size_t> places;  // of each part's first index
  impl_->culler->cull(view, set);
  const OcclusionTest test(view, impl_->bounds.origin, depth.width(), depth.height(), depth);
  parts.split(set);
  parts.for_each(&impl_->threads, [&](core::VisibleSet& part, std::uint32_t) {
    test.filter(impl_->bounds, part, part, {}, nullptr, &impl_->culler->hierarchy());
  });
  places.assign(1, 0);
  for (std::uint32_t i = 0; i < parts.count(); ++i) places.push_back(places.back() + parts[i].count());
  indices.resize(places.back());
  const std::span<const std::size_t> to = places;
  parts.for_each(&impl_->threads, [&](const core::VisibleSet& part, std::uint32_t i) {
    list_ids(part, impl_->index_of, std::span(indices).subspan(to[i], to[i + 1] - to[i]));
  });
}

core::Expected<void> BoxCuller::update(std::uint32_t index, const core::AabbD& box) {
  assert(index < size());
  if (auto fine = check(box, index); !fine) return fine;
  const core::Slot slot = impl_->slot_of[index];
  impl_->bounds.set(slot, impl_->rounded(box));
  impl_->culler->update(std::span(&slot, 1));
  return {};
}

}  // namespace sightline::culling
