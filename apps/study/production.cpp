#include "sightline/apps/study/production.h"

#include <algorithm>
#include <cstring>

#include "sightline/apps/bench/brute_force.h"
#include "sightline/apps/bench/harness.h"
#include "sightline/core/block_order.h"
#include "sightline/culling/frustum/cpu_culler.h"

namespace sightline::study {
namespace {

class Production : public Method {
 public:
  Production(std::span<const core::Aabb> boxes, bool list_ids)
      : list_ids_(list_ids),
        order_(core::block_order(boxes, {.smallest_block = culling::kLeafSize, .threads = 1})),
        culler_(filled(bounds_, boxes, order_)) {
    list_.reserve(boxes.size());
  }

  void cull(const core::View& view) override {
    culler_.cull(view, set_);
    if (list_ids_) list(list_);
  }
  std::uint64_t count() const override { return set_.count(); }
  std::vector<std::uint32_t> ids() const override {
    std::vector<std::uint32_t> ids;
    list(ids);
    std::sort(ids.begin(), ids.end());
    return ids;
  }
  core::CullCounters counters() const override { return set_.counters; }
  std::size_t memory_bytes() const override {
    return culler_.memory_bytes() + bounds_.memory_bytes() + order_.size() * sizeof(std::uint32_t);
  }

 private:
  static const core::ItemBounds& filled(core::ItemBounds& bounds, std::span<const core::Aabb> boxes,
                                        const std::vector<std::uint32_t>& order) {
    bench::fill(bounds, boxes, order);
    return bounds;
  }

  void list(std::vector<std::uint32_t>& ids) const {
    ids.resize(set_.count());
    std::uint32_t* out = ids.data();
    for (const core::SlotRange& r : set_.ranges) {
      std::memcpy(out, order_.data() + r.first, r.count * sizeof(std::uint32_t));
      out += r.count;
    }
    for (const core::Slot slot : set_.single_slots) *out++ = order_[slot];
  }

  bool list_ids_;
  std::vector<std::uint32_t> order_;
  core::ItemBounds bounds_;
  culling::CpuCuller culler_;
  core::VisibleSet set_;
  std::vector<std::uint32_t> list_;
};

class BruteForce : public Method {
 public:
  explicit BruteForce(std::span<const core::Aabb> boxes) : culler_(boxes) {}
  void cull(const core::View& view) override { culler_.cull(view); }
  std::uint64_t count() const override { return culler_.count(); }
  std::vector<std::uint32_t> ids() const override { return culler_.ids(); }
  std::size_t memory_bytes() const override { return culler_.memory_bytes(); }
  core::CullCounters counters() const override { return {0, culler_.size()}; }

 private:
  bench::BruteForce culler_;
};

}  // namespace

std::unique_ptr<Method> make_production(std::span<const core::Aabb> boxes, bool list_ids) {
  return std::make_unique<Production>(boxes, list_ids);
}

std::unique_ptr<Method> make_brute_force(std::span<const core::Aabb> boxes) {
  return std::make_unique<BruteForce>(boxes);
}

}  // namespace sightline::study
