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

}  // namespace sightline::apps
