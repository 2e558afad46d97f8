// The yardstick for times: every box against six plain float planes, structure of arrays, AVX2 where the machine has
// it, one bit per box. No promise. The baseline B of sightline-bench-cull.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"

namespace sightline::study {

class BruteForce {
 public:
  explicit BruteForce(std::span<const core::Aabb> boxes);
  /// Finds the visible boxes as bits; ids() lists those of the last call, sorted.
  void cull(const core::View& view);
  std::vector<std::uint32_t> ids() const;
  std::size_t memory_bytes() const { return bounds_.memory_bytes() + bits_.size(); }
  static const char* name();

 private:
  core::ItemBounds bounds_;
  std::vector<std::uint8_t> bits_;
};

}  // namespace sightline::study
