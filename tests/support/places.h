// Where the checkout and the built programs lie. Only places.cpp knows, so that all other objects of the tests are the
// same in every folder and a compiler cache finds them. The environment variables SIGHTLINE_CHECKOUT and SIGHTLINE_BIN
// name other folders, for test programs that run elsewhere than where they were built (scripts/gpu_kit.sh).
#pragma once

#include <filesystem>
#include <string>

namespace sightline::tests {

/// A file or folder of the checkout, such as "tests/data/box.stl".
std::filesystem::path in_checkout(const std::string& name);
/// A built program, such as "sightline-info".
std::filesystem::path in_bin(const std::string& name);
/// Whether files are found by names in any case, as on Windows.
bool names_ignore_case();

}  // namespace sightline::tests
