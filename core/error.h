// Errors of files, memory and GL are returned as values; broken contracts assert.
#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace sightline::core {

/// A message for a person: where it happened, what was expected, what was found. One line, no trailing newline.
struct Error {
  std::string message;
};

template <class T>
using Expected = tl::expected<T, Error>;

inline tl::unexpected<Error> fail(std::string message) {
  return tl::unexpected<Error>(Error{std::move(message)});
}

}  // namespace sightline::core
