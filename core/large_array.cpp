#include "sightline/core/internal/large_array.h"

#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace sightline::core {
namespace {

constexpr std::size_t kHugePage = std::size_t(2) << 20;

bool large(std::size_t bytes) {
  return bytes >= kHugePage;
}

std::align_val_t alignment_of(std::size_t bytes) {
  return std::align_val_t(large(bytes) ? kHugePage : 64);
}

}  // namespace

void* allocate_lines(std::size_t bytes) {
  // Whole pages, so that the last one is the array's alone.
  const std::size_t whole = large(bytes) ? (bytes + kHugePage - 1) / kHugePage * kHugePage : bytes;
  void* memory = ::operator new(whole, alignment_of(bytes));
#if defined(__linux__) && defined(MADV_HUGEPAGE)
  if (large(bytes)) (void)madvise(memory, whole, MADV_HUGEPAGE);  // a refusal changes nothing but speed
#endif
  return memory;
}

void release_lines(void* memory, std::size_t bytes) {
  ::operator delete(memory, alignment_of(bytes));
}

}  // namespace sightline::core
