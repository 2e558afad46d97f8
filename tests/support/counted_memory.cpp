#include "sightline/tests/support/counted_memory.h"

#include <cstdlib>
#include <new>

#include <malloc.h>

namespace sightline::tests {

std::atomic<std::size_t> live_bytes{0}, peak_bytes{0}, allocations{0};

namespace {

std::size_t bytes_of(void* p) {
#if __has_include(<sys/mman.h>)
  return malloc_usable_size(p);
#else
  return _msize(p);
#endif
}

void* counted_allocation(std::size_t size) noexcept {
  ++allocations;
  void* p = std::malloc(size);
  if (!p) return nullptr;
  const std::size_t live = live_bytes += bytes_of(p);
  std::size_t peak = peak_bytes;
  while (peak < live && !peak_bytes.compare_exchange_weak(peak, live)) {
  }
  return p;
}

void* counted_or_throw(std::size_t size) {
  if (void* p = counted_allocation(size)) return p;
  throw std::bad_alloc();
}

void counted_release(void* p) noexcept {
  if (p) live_bytes -= bytes_of(p);
  std::free(p);
}

}  // namespace
}  // namespace sightline::tests

using sightline::tests::counted_allocation, sightline::tests::counted_or_throw, sightline::tests::counted_release;

void* operator new(std::size_t size) {
  return counted_or_throw(size);
}
void* operator new[](std::size_t size) {
  return counted_or_throw(size);
}
// A sanitizer has forms of its own of these, which would not go with our delete.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return counted_allocation(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return counted_allocation(size);
}
void operator delete(void* p) noexcept {
  counted_release(p);
}
void operator delete[](void* p) noexcept {
  counted_release(p);
}
void operator delete(void* p, std::size_t) noexcept {
  counted_release(p);
}
void operator delete[](void* p, std::size_t) noexcept {
  counted_release(p);
}
