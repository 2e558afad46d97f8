#include "failing_memory.h"

#include <cstdlib>
#include <new>

namespace sightline::tests {
namespace {

thread_local int successes_left = -1;  // below 0: none fails
thread_local bool any_failed = false;

void* allocate(std::size_t size) noexcept {
  if (successes_left == 0) {
    any_failed = true;
    return nullptr;
  }
  if (successes_left > 0) --successes_left;
  return std::malloc(size ? size : 1);
}

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
