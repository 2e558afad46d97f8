// Export of the model and of the selection, as the viewer's commands and dialogs ask for it. All need an open model.
#pragma once

#include <string>

#include "sightline/apps/view/viewer.h"

namespace sightline::apps {

/// Without a name, asks for a file.
core::Expected<void> export_model(Viewer& viewer, const std::string& file);
core::Expected<void> export_selection(Viewer& viewer, const std::string& file);

/// What the dialogs say beside the file.
void export_model_options(Viewer& viewer);
void export_selection_options(Viewer& viewer);
/// "plant" or "selection" in the format of what is open where that can be written.
std::string export_name(const Viewer& viewer, const char* stem);

}  // namespace sightline::apps
