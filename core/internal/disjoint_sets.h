// Union-find. Internal: for the library's own sources.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace sightline::core {

/// Numbers from 0 on, at first each in a set of its own. The smallest number of a set stands for it.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size = 0) { reset(size); }
  void reset(std::size_t size) {
    parents_.resize(size);
    std::iota(parents_.begin(), parents_.end(), 0u);
  }
  std::uint32_t find(std::uint32_t i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }
  void merge(std::uint32_t a, std::uint32_t b) {
    const auto [first, second] = std::minmax({find(a), find(b)});
    parents_[second] = first;
  }

 private:
  std::vector<std::uint32_t> parents_;
};

}  // namespace sightline::core
