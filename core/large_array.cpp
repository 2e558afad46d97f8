#include "sightline/core/large_array.h"

#include <cstdint>
#include <cstring>
#include <new>

// AddressSanitizer watches the bounds of what `new` returns, not of pages.
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
#define SIGHTLINE_MAPS_LARGE_ARRAYS 1
#include <sys/mman.h>
#endif

namespace sightline::core {
namespace {

constexpr std::align_val_t kLine{64};

#ifdef SIGHTLINE_MAPS_LARGE_ARRAYS

constexpr std::size_t kHugePage = std::size_t(2) << 20;

bool mapped(std::size_t bytes) {
  return bytes >= kHugePage;
}

std::size_t in_pages(std::size_t bytes) {
  return (bytes + kHugePage - 1) / kHugePage * kHugePage;
}

/// Memory of whole huge pages, which takes none before it is touched.
void* map_pages(std::size_t bytes) {
  const std::size_t whole = in_pages(bytes), wide = whole + kHugePage;
  if (wide < bytes) throw std::bad_alloc();
  void* const memory = mmap(nullptr, wide, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  const std::size_t before = (kHugePage - std::uintptr_t(memory) % kHugePage) % kHugePage;
  auto* const first = static_cast<std::byte*>(memory) + before;
  if (before > 0) munmap(memory, before);
  munmap(first + whole, kHugePage - before);
  (void)madvise(first, whole, MADV_HUGEPAGE);  // a refusal changes nothing but speed
  return first;
}

#endif

}  // namespace

void* allocate_lines(std::size_t bytes) {
#ifdef SIGHTLINE_MAPS_LARGE_ARRAYS
  if (mapped(bytes)) return map_pages(bytes);
#endif
  return ::operator new(bytes, kLine);
}

void release_lines(void* memory, [[maybe_unused]] std::size_t bytes) {
#ifdef SIGHTLINE_MAPS_LARGE_ARRAYS
  if (mapped(bytes)) {
    munmap(memory, in_pages(bytes));
    return;
  }
#endif
  ::operator delete(memory, kLine);
}

void* grow_lines(void* memory, [[maybe_unused]] std::size_t bytes, std::size_t used, std::size_t more) {
  void* const larger = allocate_lines(more);
#ifdef SIGHTLINE_MAPS_LARGE_ARRAYS
  if (mapped(bytes)) {
    // Where this fails, some kernels have unmapped `larger` and others have not, so that it must not be touched again.
    if (mremap(memory, in_pages(bytes), in_pages(more), MREMAP_MAYMOVE | MREMAP_FIXED, larger) == MAP_FAILED)
      throw std::bad_alloc();
    return larger;
  }
#endif
  if (used > 0) std::memcpy(larger, memory, used);
  if (memory != nullptr) release_lines(memory, bytes);
  return larger;
}

void spare_lines([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t used, [[maybe_unused]] std::size_t bytes) {
#ifdef SIGHTLINE_MAPS_LARGE_ARRAYS
  if (!mapped(bytes) || in_pages(used) >= bytes) return;
  (void)madvise(static_cast<std::byte*>(memory) + in_pages(used), in_pages(bytes) - in_pages(used), MADV_NOHUGEPAGE);
#endif
}

}  // namespace sightline::core
