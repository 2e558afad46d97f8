// Internal to the importers: what sightline-cad-reader gets as arguments and answers.
//
// Arguments: the file, the scene cache to write, and "NAME=VALUE" as below. Messages are lines: a kind, a space, text.
// A program that ends with 0 has written the scene cache.
#pragma once

#include <filesystem>
#include <string>

#include "sightline/importers/internal/extension.h"

namespace sightline::importers::cad {

inline constexpr const char* kProgram = "sightline-cad-reader";

inline constexpr char kProgress = 'p';  ///< share, 0 to 1
inline constexpr char kSideFile = 's';  ///< a path
inline constexpr char kError = 'e';

inline constexpr const char *kTolerance = "tolerance", *kAngle = "angle", *kLenient = "lenient", *kThreads = "threads",
                            *kMemory = "memory", *kSeconds = "seconds", *kShapesAlone = "shapes_alone";

/// The end of the warning of a file at which Open CASCADE fails, and which is read once more for its shapes alone.
inline std::string shapes_alone(const std::filesystem::path& file) {
  const std::string extension = lower_case_extension(file);
  const bool iges = extension == ".igs" || extension == ".iges";
  return std::string("; read again as triangles") +
         (extension == ".brep" ? ""
          : iges               ? " without names, colours and layers"
                               : " without names, colours, layers, properties and parts in other files");
}

}  // namespace sightline::importers::cad
