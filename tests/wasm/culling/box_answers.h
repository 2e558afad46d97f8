// Calls of the JavaScript package with the answers of the library in this process, in a file for replay.js.
#pragma once

#include <filesystem>

namespace sightline::tests {

/// Boxes, views, occluders and queries: random ones, and those at the limits of numbers. False where the file cannot be
/// written.
bool write_box_answers(const std::filesystem::path& file);
/// A generated plant, from the bytes of a model and of a scene cache beside `file`.
bool write_scene_answers(const std::filesystem::path& file);

}  // namespace sightline::tests
