#include "sightline/bindings/wasm/call.h"

#include <cstdlib>

namespace sightline::wasm {
namespace {

struct Answer {
  const void* data;
  std::uint32_t count;
};
Answer g_answer{};
std::string g_error;

}  // namespace

void set_error(std::string_view message) {
  g_error.assign(message);
}

void answer(const void* data, std::size_t count) {
  g_answer = {data, std::uint32_t(count)};
}

/// Where the last answer lies: address and count of its elements.
SIGHTLINE_EXPORT const Answer* sl_answer() {
  return &g_answer;
}
/// Answers with the last failure's message, in UTF-8.
SIGHTLINE_EXPORT void sl_error() {
  answer(g_error.data(), g_error.size());
}

/// 0 where memory ends.
SIGHTLINE_EXPORT void* sl_allocate(std::size_t bytes) {
  constexpr std::size_t kAlignment = 16;
  if (bytes > std::size_t(-1) - kAlignment) return nullptr;
  return std::aligned_alloc(kAlignment, (bytes + kAlignment) / kAlignment * kAlignment);
}
SIGHTLINE_EXPORT void sl_free(void* memory) {
  std::free(memory);
}

}  // namespace sightline::wasm
