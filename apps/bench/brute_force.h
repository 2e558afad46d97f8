// Brute-force culling, the baseline for times of culling.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"

namespace sightline::bench {

/// Tests every box against six plain float planes: structure of arrays, AVX2 where the machine has it, one bit per box.
/// The planes are not padded, so nothing is promised for boxes within rounding of them.
class BruteForce {
 public:
  explicit BruteForce(std::span<const core::Aabb> boxes);
  /// The result is valid until the next call.
  void cull(const core::View& view);
  std::size_t size() const { return bounds_.size(); }
  /// Number of visible boxes.
  std::uint64_t count() const;
  /// Indices of the visible boxes, sorted.
  std::vector<std::uint32_t> ids() const;
  std::size_t memory_bytes() const { return bounds_.memory_bytes() + bits_.size(); }
  static const char* name();

 private:
  core::ItemBounds bounds_;
  std::vector<std::uint8_t> bits_;
};

}  // namespace sightline::bench
