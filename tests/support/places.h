// Where the checkout and the built programs lie. Only places.cpp knows, so that all other objects of the tests are the
// same in every folder and a compiler cache finds them.
#pragma once

#include <filesystem>
#include <string>

namespace sightline::tests {

/// A file or folder of the checkout, such as "tests/data/box.stl".
std::filesystem::path in_checkout(const std::string& name);
/// A built program, such as "sightline-info".
std::filesystem::path in_bin(const std::string& name);

}  // namespace sightline::tests
