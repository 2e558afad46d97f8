// Any variant over any boxes.
#pragma once

#include <memory>
#include <span>

#include "sightline/apps/study/method.h"
#include "sightline/apps/study/tree.h"
#include "sightline/apps/study/variant.h"
#include "sightline/core/aabb.h"
#include "sightline/core/visible_set.h"

namespace sightline::study {

class Culler : public Method {
 public:
  /// `tree` must be built over `boxes` when the variant has a binary tree and is not read otherwise.
  /// Copies what it needs. The variant must be valid (asserted). Boxes must be finite and not empty.
  Culler(const Variant& variant, std::span<const core::Aabb> boxes, const Tree& tree);
  ~Culler() override;

  /// Coherent variants learn from frame to frame. Promise: see study::promise.
  void cull(const core::View& view) override;
  std::uint64_t count() const override { return visible_.count(); }
  std::vector<std::uint32_t> ids() const override;
  /// Boxes tested include those that a pre-test or a motion bound settled.
  core::CullCounters counters() const override { return visible_.counters; }
  std::size_t memory_bytes() const override;

 private:
  struct State;
  Variant variant_;
  std::unique_ptr<State> state_;
  core::VisibleSet visible_;  // of places in the tree's order; in no particular order with more than one thread
};

}  // namespace sightline::study
