// Places to come back to: camera and sections, as the view files that all tools read (importers/view_json.h).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/core/view.h"

namespace sightline::apps {

struct Viewpoint {
  core::Pose pose;
  double fovy = 1.0;  ///< radians; of orthographic views as Camera has it
  bool orthographic = false;
  double near = 0.1;  ///< of perspective views
  std::vector<core::Plane> sections;
};

std::string format_viewpoint(const Viewpoint& viewpoint);
/// Fails as importers::parse_view() does. `source` names the text in errors.
core::Expected<Viewpoint> parse_viewpoint(const std::string& json, const std::string& source);

core::Expected<Viewpoint> read_viewpoint(const std::filesystem::path& file);
/// The same for a model that was moved by `offset`.
Viewpoint translated(const Viewpoint& viewpoint, const core::dvec3& offset);

}  // namespace sightline::apps
