// Where models lie, for tests that need one: tests/data/small_plant.rvm is always there, real ones may be.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "sightline/tests/support/places.h"

namespace sightline::tests {

/// Path of a file of tests/data, or below SIGHTLINE_DATA, or below ../shared/data beside the sources. May not exist.
inline std::filesystem::path data_path(const std::string& name) {
  const auto own = in_checkout("tests/data") / name;
  if (std::filesystem::exists(own)) return own;
  if (const char* root = std::getenv("SIGHTLINE_DATA")) return std::filesystem::path(root) / name;
  return in_checkout("../shared/data") / name;
}

inline bool have_data(const std::string& name) {
  return std::filesystem::exists(data_path(name));
}

}  // namespace sightline::tests

/// Skips the running test, saying which file is missing.
#define SIGHTLINE_NEED_DATA(name)         \
  if (!sightline::tests::have_data(name)) \
  GTEST_SKIP() << "needs " << (name) << " below SIGHTLINE_DATA or ../shared/data (not found)"
