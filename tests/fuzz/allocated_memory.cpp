#include "sightline/tests/fuzz/allocated_memory.h"

#include <algorithm>
#include <atomic>

#include <sanitizer/allocator_interface.h>

namespace sightline::fuzz {
namespace {

std::atomic<std::ptrdiff_t> live{0}, peak{0};

void on_malloc(const volatile void*, std::size_t size) {
  const std::ptrdiff_t now = live += std::ptrdiff_t(size);
  if (now > peak) peak = now;  // readers run on one thread
}

void on_free(const volatile void* block) {
  if (block) live -= std::ptrdiff_t(__sanitizer_get_allocated_size(block));
}

}  // namespace

PeakMemory::PeakMemory() {
  static const bool installed = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free) != 0;
  static_cast<void>(installed);
  live = 0;
  peak = 0;
}

std::size_t PeakMemory::bytes() const {
  return std::size_t(std::max<std::ptrdiff_t>(peak, 0));
}

}  // namespace sightline::fuzz
