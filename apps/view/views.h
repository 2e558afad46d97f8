// The viewer's list of viewpoints, as its tab and its commands use it. All need an open model. An empty name or number
// stands for the current view.
#pragma once

#include <string>

#include "sightline/apps/view/viewer.h"

namespace sightline::apps {

core::Expected<void> add_view(Viewer& viewer, const std::string& name);
core::Expected<void> show_view(Viewer& viewer, const std::string& which);
core::Expected<void> update_view(Viewer& viewer, const std::string&);
core::Expected<void> rename_view(Viewer& viewer, const std::string& name);
core::Expected<void> comment_view(Viewer& viewer, const std::string& text);
core::Expected<void> delete_view(Viewer& viewer, const std::string& which);
/// Without a name, these two ask for one.
core::Expected<void> save_views(Viewer& viewer, const std::string& file);
/// Adds the views of a file to the list, which stays as it is where that fails.
core::Expected<void> load_views(Viewer& viewer, const std::string& file);

}  // namespace sightline::apps
