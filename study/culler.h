// Any variant over any boxes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sightline/core/aabb.h"
#include "sightline/core/view.h"
#include "sightline/core/visible_set.h"
#include "sightline/study/tree.h"
#include "sightline/study/variant.h"

namespace sightline::study {

/// What a cull call found: ranges of Culler::order() and single places in it. Disjoint; in no particular order with
/// more than one thread.
struct Visible {
  std::vector<core::SlotRange> ranges;
  std::vector<std::uint32_t> items;
  core::CullCounters counters;  ///< boxes tested, those that a pre-test or a motion bound settled included

  void clear();
  void append(const Visible& other);
  std::uint64_t count() const;
};

class Culler {
 public:
  /// `tree` must be built over `boxes` when the variant has a binary tree and is not read otherwise.
  /// Copies what it needs. The variant must be valid (asserted). Boxes must be finite and not empty.
  Culler(const Variant& variant, std::span<const core::Aabb> boxes, const Tree& tree);
  ~Culler();
  Culler(const Culler&) = delete;
  Culler& operator=(const Culler&) = delete;

  /// Replaces the contents of `visible`. Not const: coherent variants learn from frame to frame. Promise: see
  /// study::promise.
  void cull(const core::View& view, Visible& visible);

  /// Ids (indices into `boxes`) of the visible items, sorted.
  std::vector<std::uint32_t> ids(const Visible& visible) const;

  const Variant& variant() const { return variant_; }
  std::size_t node_bytes() const;  ///< the hierarchy alone
  std::size_t memory_bytes() const;

 private:
  struct State;
  Variant variant_;
  std::unique_ptr<State> state_;
};

}  // namespace sightline::study
