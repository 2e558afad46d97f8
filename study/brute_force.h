// The yardstick for times: every box against six plain float planes, structure of arrays, AVX2 where the machine has
// it, one bit per box. No promise. The baseline B of sightline-bench-cull.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/core/item_bounds.h"
#include "sightline/core/view.h"
#include "sightline/study/method.h"

namespace sightline::study {

class BruteForce : public Method {
 public:
  explicit BruteForce(std::span<const core::Aabb> boxes);
  /// Finds the visible boxes as bits; ids() lists those of the last call, sorted.
  void cull(const core::View& view) override;
  std::uint64_t count() const override;
  std::vector<std::uint32_t> ids() const override;
  std::size_t memory_bytes() const override { return bounds_.memory_bytes() + bits_.size(); }
  core::CullCounters counters() const override { return {0, bounds_.size()}; }
  static const char* name();

 private:
  core::ItemBounds bounds_;
  std::vector<std::uint8_t> bits_;
};

}  // namespace sightline::study
