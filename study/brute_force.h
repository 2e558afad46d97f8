// The baseline B of sightline-bench cull as a method of the study.
#pragma once

#include "sightline/apps/bench/brute_force.h"
#include "sightline/study/method.h"

namespace sightline::study {

class BruteForce : public Method {
 public:
  explicit BruteForce(std::span<const core::Aabb> boxes) : culler_(boxes) {}
  void cull(const core::View& view) override { culler_.cull(view); }
  std::uint64_t count() const override { return culler_.count(); }
  std::vector<std::uint32_t> ids() const override { return culler_.ids(); }
  std::size_t memory_bytes() const override { return culler_.memory_bytes(); }
  core::CullCounters counters() const override { return {0, culler_.size()}; }
  static const char* name() { return bench::BruteForce::name(); }

 private:
  bench::BruteForce culler_;
};

}  // namespace sightline::study
