// Images, camera paths and frames of videos, as the viewer's commands and dialogs ask for them. All need an open
// model.
#pragma once

#include <string>

#include "sightline/apps/view/viewer.h"

namespace sightline::apps {

/// "FILE [WxH]", both optional: in the window's size at once, or in any size in steps.
core::Expected<void> write_image(Viewer& viewer, const std::string& argument);
/// "FILE", or nothing for the path that was played or recorded last.
core::Expected<void> play_path(Viewer& viewer, const std::string& file);
core::Expected<void> set_path_speed(Viewer& viewer, const std::string& factor);
/// "FOLDER [FPS] [WxH]": frames of the path that was played or recorded last.
core::Expected<void> write_frames(Viewer& viewer, const std::string& argument);

/// The path that was played or recorded last, in the model's own frame. Without a name the dialog asks for one.
core::Expected<void> save_path(Viewer& viewer, const std::string& file);

void image_options(Viewer& viewer);  ///< size of the image
/// In the sizes that dialogs have asked for.
core::Expected<void> write_sized_image(Viewer& viewer, const std::string& file);
core::Expected<void> write_sized_frames(Viewer& viewer, const std::string& folder);
void path_window(Viewer& viewer);       ///< plays a path, and writes its frames
void exporting_window(Viewer& viewer);  ///< progress, and a button that cancels

}  // namespace sightline::apps
