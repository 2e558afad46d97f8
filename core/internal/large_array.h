// Vectors with one value or more per item.
#pragma once

#include <cstddef>
#include <vector>

#include "sightline/core/api.h"

namespace sightline::core {

/// Allocates memory that starts at a cache line, so that a group of sixteen floats is one line and not two. From 2 MiB
/// on it asks for huge pages (Linux): queries and edits touch thousands of places far apart, and with small pages each
/// of them costs another miss.
SIGHTLINE_API void* allocate_lines(std::size_t bytes);
SIGHTLINE_API void release_lines(void* memory, std::size_t bytes);

template <class T>
struct LineAllocator {
  using value_type = T;
  LineAllocator() = default;
  template <class U>
  explicit LineAllocator(const LineAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(allocate_lines(n * sizeof(T))); }
  void deallocate(T* p, std::size_t n) { release_lines(p, n * sizeof(T)); }
  friend bool operator==(const LineAllocator&, const LineAllocator&) { return true; }
};

template <class T>
using LargeArray = std::vector<T, LineAllocator<T>>;

}  // namespace sightline::core
