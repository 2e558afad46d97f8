#include "sightline/tests/support/places.h"

#include <cstdlib>

namespace sightline::tests {
namespace {

std::filesystem::path folder(const char* variable, const char* built_with) {
  const char* moved = std::getenv(variable);
  return moved && *moved ? moved : built_with;
}

}  // namespace

std::filesystem::path in_checkout(const std::string& name) {
  return folder("SIGHTLINE_CHECKOUT", SIGHTLINE_SOURCE_DIR) / name;
}

std::filesystem::path in_bin(const std::string& name) {
  return folder("SIGHTLINE_BIN", SIGHTLINE_BIN_DIR) / name;
}

bool names_ignore_case() {
  return std::filesystem::exists(in_checkout("license"));
}

}  // namespace sightline::tests
