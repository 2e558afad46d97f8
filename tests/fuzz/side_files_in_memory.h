// Side files out of the fuzz input. Takes the place of importers/side_files.cpp when a fuzz target is linked.
#pragma once

#include <cstddef>
#include <span>

namespace sightline::fuzz {

/// What side files hold: the first for the first name that is asked for, the second for the next other name, and so
/// on. What is beyond, or empty, is not found. Must outlive the reading.
void set_side_files(std::span<const std::span<const std::byte>> files);

}  // namespace sightline::fuzz
