#include "sightline/tests/support/places.h"

namespace sightline::tests {

std::filesystem::path in_checkout(const std::string& name) {
  return std::filesystem::path(SIGHTLINE_SOURCE_DIR) / name;
}

std::filesystem::path in_bin(const std::string& name) {
  return std::filesystem::path(SIGHTLINE_BIN_DIR) / name;
}

}  // namespace sightline::tests
