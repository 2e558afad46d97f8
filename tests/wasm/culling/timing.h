// How long the library takes in this process: beside what the JavaScript package takes.
#pragma once

#include <cstdint>
#include <filesystem>

namespace sightline::tests {

/// Writes the boxes of a generated plant.
bool write_plant_boxes(const std::filesystem::path& file, std::uint64_t items);

/// Reads boxes and views and prints, as JSON, an array with the median milliseconds of each view over so many calls of
/// BoxCuller::visible(), and how many boxes it finds. SIGHTLINE_ISA chooses the instruction set.
bool time_culling(const std::filesystem::path& file, int calls);

}  // namespace sightline::tests
