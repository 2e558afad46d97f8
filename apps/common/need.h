// How tools end with an error of the library: they throw it, and CommandLine::run() prints it.
#pragma once

#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "sightline/core/error.h"

namespace sightline::apps {

struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

[[noreturn]] inline void fail(const std::string& message) {
  throw Failure(message);
}

/// The value, or a Failure with the error's message.
template <class T>
T need(core::Expected<T> expected) {
  if (!expected) fail(expected.error().message);
  if constexpr (!std::is_void_v<T>) return std::move(*expected);
}

/// What `body` returns, or the error of its Failure: for processes that tell others of it.
template <class Body>
core::Expected<std::invoke_result_t<const Body&>> attempt(const Body& body) {
  try {
    return body();
  } catch (const Failure& failure) {
    return core::fail(failure.what());
  }
}

}  // namespace sightline::apps
