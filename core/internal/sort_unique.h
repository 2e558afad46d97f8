// Internal: lists as sets.
#pragma once

#include <algorithm>
#include <vector>

namespace sightline::core {

/// Sorts values in rising order, and keeps one of each.
template <class Value>
void sort_unique(std::vector<Value>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace sightline::core
