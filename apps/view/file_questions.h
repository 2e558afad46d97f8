// What the viewer asks files for, and what it does with them.
#pragma once

#include <string>
#include <vector>

#include "sightline/apps/view/file_browser.h"
#include "sightline/apps/view/workspace.h"

namespace sightline::apps {

struct FileQuestion {
  Dialog dialog;
  const char *title, *button;
  bool models;  ///< begins in the folder of the last model, else of the last other file
  FileRequest (*request)(Workspace& work);
  Done (*answer)(Workspace& work, const std::vector<std::string>& files);
  void (*options)(Workspace& work) = nullptr;  ///< draws what else is asked
  Dialog then = Dialog::kNone;                 ///< shown afterwards
};

/// Null where the dialog asks for no file.
const FileQuestion* file_question(Dialog dialog);

}  // namespace sightline::apps
