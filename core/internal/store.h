// Results of functions that may fail, put where they belong.
#pragma once

#include <utility>

#include "sightline/core/error.h"

namespace sightline::core {

/// Moves a result to its place, or returns its error.
template <class T, class Place>
Expected<void> store(Expected<T> made, Place& place) {
  if (!made) return tl::unexpected(std::move(made.error()));
  place = std::move(*made);
  return {};
}

}  // namespace sightline::core
