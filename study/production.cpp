#include "sightline/study/production.h"

#include <algorithm>
#include <cstring>

#include "sightline/core/block_order.h"
#include "sightline/core/item_bounds.h"
#include "sightline/culling/frustum/cpu_culler.h"
#include "sightline/culling/frustum/linear_culler.h"

namespace sightline::study {
namespace {

/// The one place of the study that knows how the culler is set up.
struct Scene {
  std::vector<std::uint32_t> order;
  core::ItemBounds bounds;
  std::optional<culling::CpuCuller> culler;

  explicit Scene(std::span<const core::Aabb> boxes) {
    order = core::block_order(boxes, {.smallest_block = culling::kLeafSize, .threads = 1});
    bounds.resize(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) bounds.set(i, boxes[order[i]]);
    culler.emplace(bounds);
  }
};

class Production : public Method {
 public:
  Production(const ProductionForm& form, std::span<const core::Aabb> boxes) : form_(form), scene_(boxes) {
    list_.reserve(boxes.size());
  }
  ~Production() override { core::force_instruction_set(std::nullopt); }

  void cull(const core::View& view) override {
    core::force_instruction_set(form_.instructions);
    if (form_.hierarchy)
      scene_.culler->cull(view, set_);
    else
      culling::LinearCuller(scene_.bounds).cull(view, set_);
    if (form_.list_ids) list(list_);
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
    return scene_.culler->memory_bytes() + scene_.bounds.memory_bytes() + scene_.order.size() * sizeof(std::uint32_t);
  }

 private:
  void list(std::vector<std::uint32_t>& ids) const {
    ids.resize(set_.count());
    std::uint32_t* out = ids.data();
    for (const core::SlotRange& r : set_.ranges) {
      std::memcpy(out, scene_.order.data() + r.first, r.count * sizeof(std::uint32_t));
      out += r.count;
    }
    std::transform(set_.single_slots.begin(), set_.single_slots.end(), out,
                   [this](core::Slot s) { return scene_.order[s]; });
  }

  ProductionForm form_;
  Scene scene_;
  core::VisibleSet set_;
  std::vector<std::uint32_t> list_;
};

}  // namespace

std::vector<ProductionForm> production_forms() {
  using core::InstructionSet;
  std::vector<ProductionForm> forms{{"production", std::nullopt, false}, {"production ids", std::nullopt, true}};
  if (core::supported(InstructionSet::kAvx2) && core::instruction_set() != InstructionSet::kAvx2)
    forms.push_back({"production AVX2", InstructionSet::kAvx2, false});
  forms.push_back({"production scalar", InstructionSet::kScalar, false});
  return forms;
}

std::unique_ptr<Method> make_production(const ProductionForm& form, std::span<const core::Aabb> boxes) {
  return std::make_unique<Production>(form, boxes);
}

}  // namespace sightline::study
