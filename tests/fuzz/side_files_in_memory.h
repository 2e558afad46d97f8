// Side files out of the fuzz input. Takes the place of importers/side_files.cpp when a fuzz target is linked.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace sightline::fuzz {

/// What the next side files asked for hold, in order; those beyond are not found. Must outlive the reading.
void set_side_files(std::span<const std::span<const std::byte>> files);

}  // namespace sightline::fuzz
