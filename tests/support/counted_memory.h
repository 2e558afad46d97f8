// Counts what operator new gives out. It replaces the global operators: for one translation unit of a test program.
#pragma once

#include <atomic>
#include <cstdlib>
#include <new>

#include <malloc.h>

namespace sightline::tests {

inline std::atomic<std::size_t> live_bytes{0}, peak_bytes{0};

inline void* counted_allocation(std::size_t size) {
  void* p = std::malloc(size);
  if (!p) throw std::bad_alloc();
  const std::size_t live = live_bytes += malloc_usable_size(p);
  std::size_t peak = peak_bytes;
  while (peak < live && !peak_bytes.compare_exchange_weak(peak, live)) {
  }
  return p;
}

inline void counted_release(void* p) noexcept {
  if (p) live_bytes -= malloc_usable_size(p);
  std::free(p);
}

}  // namespace sightline::tests

void* operator new(std::size_t size) {
  return sightline::tests::counted_allocation(size);
}
void* operator new[](std::size_t size) {
  return sightline::tests::counted_allocation(size);
}
void operator delete(void* p) noexcept {
  sightline::tests::counted_release(p);
}
void operator delete[](void* p) noexcept {
  sightline::tests::counted_release(p);
}
void operator delete(void* p, std::size_t) noexcept {
  sightline::tests::counted_release(p);
}
void operator delete[](void* p, std::size_t) noexcept {
  sightline::tests::counted_release(p);
}
