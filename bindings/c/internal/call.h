// What every function of the C API runs in: exceptions become a status and a message of the thread.
#pragma once

#include <string>
#include <utility>

#include "sightline/core/error.h"
#include "sightline/sightline.h"

namespace sightline::capi {

/// Thrown within the C API, and never out of it.
struct Failure {
  sl_status status;
  std::string message;
  bool by_caller = false;  ///< a mistake in the call: the message then begins with the function's name
};

/// A mistake of the caller's.
[[noreturn]] void refuse(sl_status status, std::string message);

inline void require(bool holds, const char* expected) {
  if (!holds) refuse(SL_ERROR_ARGUMENT, std::string("expected ") + expected);
}

/// The value, or a Failure with the library's message.
template <class T>
T value_of(core::Expected<T> expected) {
  if (!expected) throw Failure{SL_ERROR_FAILED, std::move(expected.error().message)};
  if constexpr (!std::is_void_v<T>) return std::move(*expected);
}

/// Within a catch block: sets the thread's message, and returns the status.
sl_status fail_call(const char* function) noexcept;

/// Runs the body of a function of the C API, which is named `function`.
template <class Body>
sl_status call(const char* function, const Body& body) noexcept {
  try {
    body();
    return SL_OK;
  } catch (...) {
    return fail_call(function);
  }
}

}  // namespace sightline::capi
