// The viewer's comparison with an older revision, as its tab and its commands use it. All need an open model.
#pragma once

#include <string>

#include "sightline/apps/view/viewer.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

/// Without a name, asks for a file.
core::Expected<void> compare_with(Viewer& viewer, const std::string& file);
core::Expected<void> end_comparison(Viewer& viewer, const std::string&);
/// Shows or hides items that are "added", "removed", …
core::Expected<void> toggle_changes(Viewer& viewer, const std::string& state);
core::Expected<void> next_change(Viewer& viewer, const std::string&);
core::Expected<void> previous_change(Viewer& viewer, const std::string&);

/// "0.3", of the image's width, or "off"; without an argument the other of both. Fails while somebody reads the scene.
core::Expected<void> set_slider(Viewer& viewer, const std::string& argument);

/// For Viewer::state(); null while nothing is compared.
json::Value compare_json(const Session& session);

}  // namespace sightline::apps
