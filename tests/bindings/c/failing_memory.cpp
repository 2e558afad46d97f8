#include "failing_memory.h"

#include <cstdlib>
#include <new>

#include <malloc.h>

namespace sightline::tests {
namespace {

thread_local int successes_left = -1;  // below 0: none fails
thread_local bool any_failed = false;

bool may_allocate() noexcept {
  if (successes_left == 0) {
    any_failed = true;
    return false;
  }
  if (successes_left > 0) --successes_left;
  return true;
}

void* allocate(std::size_t size) noexcept {
  return may_allocate() ? std::malloc(size ? size : 1) : nullptr;
}

#if __has_include(<sys/mman.h>)
void* allocate_aligned(std::size_t size, std::size_t alignment) noexcept {
  void* p = nullptr;
  return posix_memalign(&p, alignment, size) == 0 ? p : nullptr;
}
void release_aligned(void* p) noexcept {
  std::free(p);
}
#else
void* allocate_aligned(std::size_t size, std::size_t alignment) noexcept {
  return _aligned_malloc(size, alignment);
}
void release_aligned(void* p) noexcept {
  _aligned_free(p);
}
#endif

void* allocate_or_throw(std::size_t size) {
  if (void* p = allocate(size)) return p;
  throw std::bad_alloc();
}

}  // namespace

FailingMemory::FailingMemory(int successes) {
  any_failed = false;
  successes_left = successes;
}
FailingMemory::~FailingMemory() {
  successes_left = -1;
}
bool FailingMemory::failed() const {
  return any_failed;
}

}  // namespace sightline::tests

void* operator new(std::size_t size) {
  return sightline::tests::allocate_or_throw(size);
}
void* operator new[](std::size_t size) {
  return sightline::tests::allocate_or_throw(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return sightline::tests::allocate(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return sightline::tests::allocate(size);
}
/// Serves the arrays of scenes and snapshots.
void* operator new(std::size_t size, std::align_val_t alignment) {
  void* const p = sightline::tests::may_allocate()
                      ? sightline::tests::allocate_aligned(size ? size : 1, std::size_t(alignment))
                      : nullptr;
  if (p) return p;
  throw std::bad_alloc();
}
void operator delete(void* p, std::align_val_t) noexcept {
  sightline::tests::release_aligned(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  sightline::tests::release_aligned(p);
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete[](void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}
void operator delete[](void* p, std::size_t) noexcept {
  std::free(p);
}
