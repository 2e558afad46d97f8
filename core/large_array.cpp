#include "sightline/core/large_array.h"

#include <cstdint>
#include <cstring>
#include <new>

#include "sightline/core/internal/platform/memory.h"

namespace sightline::core {
namespace {

constexpr std::align_val_t kLine{64};

/// Large arrays lie in huge pages, where there are any.
bool mapped(std::size_t bytes) {
  return platform::kHasHugePages && bytes >= platform::kHugePage;
}

std::size_t in_pages(std::size_t bytes) {
  return (bytes + platform::kHugePage - 1) / platform::kHugePage * platform::kHugePage;
}

}  // namespace

void* allocate_lines(std::size_t bytes) {
  if constexpr (platform::kHasHugePages) {
    if (mapped(bytes)) {
      void* const memory = in_pages(bytes) < bytes ? nullptr : platform::reserve_huge_pages(in_pages(bytes));
      if (!memory) throw std::bad_alloc();
      return memory;
    }
  }
  return ::operator new(bytes, kLine);
}

void release_lines(void* memory, std::size_t bytes) {
  if (mapped(bytes))
    platform::release_pages(memory, in_pages(bytes));
  else
    ::operator delete(memory, kLine);
}

void* grow_lines(void* memory, std::size_t bytes, std::size_t used, std::size_t more) {
  void* const larger = allocate_lines(more);
  if constexpr (platform::kHasHugePages) {
    if (mapped(bytes)) {
      // Where this fails, some kernels have unmapped `larger` and others have not, so that it must not be touched
      // again.
      if (!platform::move_huge_pages(memory, in_pages(bytes), larger, in_pages(more))) throw std::bad_alloc();
      return larger;
    }
  }
  if (used > 0) std::memcpy(larger, memory, used);
  if (memory != nullptr) release_lines(memory, bytes);
  return larger;
}

void spare_lines([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t used, [[maybe_unused]] std::size_t bytes) {
  if constexpr (platform::kHasHugePages) {
    if (!mapped(bytes) || in_pages(used) >= bytes) return;
    platform::prefer_small_pages(static_cast<std::byte*>(memory) + in_pages(used), in_pages(bytes) - in_pages(used));
  }
}

}  // namespace sightline::core
