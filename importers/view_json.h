// Views and camera paths as JSON files. Coordinates are metres in the model's world frame, angles degrees.
//
//   view  {"eye":[x,y,z], "target":[x,y,z], "up":[x,y,z], "fovy_deg":60, "near":0.1, "far":1000,
//          "sections":[{"n":[x,y,z],"d":0}], "section_mode":"intersection"|"union", "layers":mask}
//         or "ortho_height":metres instead of "fovy_deg"
//   path  {"keys":[{"t":seconds,"eye":…,"target":…,"up":…,"fovy_deg":…},…], "near":…, "far":…}
//
// These keys are optional, with the default in parentheses: "up" of a view and of the first key (z); "up" and
// "fovy_deg" of later keys (as in the key before); "far" (infinite; for "ortho_height", whose far plane must be finite,
// near + max(10 km, 10 times the distance from eye to target)); the section keys; "layers" (core::kDefaultLayerMask).
// All other keys above are required. Unknown keys are ignored.
//
// Errors read "file: /json/pointer: expected …, found …" or, for malformed JSON, give its line and column. Any bytes
// are safe to read; objects and arrays may nest 64 deep and a file may hold 256 MiB.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "sightline/core/api.h"
#include "sightline/core/camera_path.h"
#include "sightline/core/error.h"
#include "sightline/core/view.h"

namespace sightline::importers {

/// `aspect` = width / height of the image, > 0. `source` names the text in errors.
SIGHTLINE_API core::Expected<core::View> parse_view(std::string_view json, double aspect,
                                                    std::string_view source = "view");
SIGHTLINE_API core::Expected<core::View> read_view(const std::filesystem::path& file, double aspect);

SIGHTLINE_API core::Expected<core::CameraPath> parse_path(std::string_view json, std::string_view source = "path");
SIGHTLINE_API core::Expected<core::CameraPath> read_path(const std::filesystem::path& file);

/// Reading the text back gives the same keys: times and distances to the bit, fields of view to the last few bits.
SIGHTLINE_API std::string format_path(const core::CameraPath& path);
/// Replaces `file`. Its folder must exist.
SIGHTLINE_API core::Expected<void> write_path(const std::filesystem::path& file, const core::CameraPath& path);

/// The view or path of a model that was moved by `offset`, sections included.
SIGHTLINE_API core::Expected<core::View> translated(const core::View& view, const core::dvec3& offset);
SIGHTLINE_API core::Expected<core::CameraPath> translated(const core::CameraPath& path, const core::dvec3& offset);

}  // namespace sightline::importers
