// All functions of the module are exported, answer and fail in one way. Numbers and addresses come in; arrays lie in
// the module's memory, of which js/objects.js makes views. One thread of JavaScript calls at a time.
//
// A function that can fail returns whether it succeeded, or an address that is 0 otherwise, and leaves a message for
// sl_error(). A function that answers with an array leaves its place for sl_answer(). The array belongs to the object
// that was asked, until it is asked again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "sightline/core/error.h"

/// A function of the module, by its name.
#define SIGHTLINE_EXPORT extern "C" __attribute__((used, visibility("default")))

namespace sightline::wasm {

void set_error(std::string_view message);

void answer(const void* data, std::size_t count);
template <class T>
void answer(const std::vector<T>& values) {
  answer(values.data(), values.size());
}

/// Calls `work`, which returns an Expected. False, or a null pointer, when it fails or memory ends.
template <class Work>
typename std::invoke_result_t<Work>::value_type attempt(const Work& work) {
  try {
    auto result = work();
    if (result) return std::move(*result);
    set_error(result.error().message);
  } catch (const std::bad_alloc&) {
    set_error("not enough memory");
  } catch (const std::exception& error) {
    set_error(error.what());
  }
  return {};
}
inline core::Expected<bool> done(const core::Expected<void>& result) {
  if (!result) return tl::unexpected(result.error());
  return true;
}

/// As attempt(), for work that fails only where memory ends.
template <class Work>
bool attempt_all(const Work& work) {
  return attempt([&]() -> core::Expected<bool> {
    work();
    return true;
  });
}

}  // namespace sightline::wasm
