// Options for the view of an image, the same for every tool that makes one.
#pragma once

#include <string>

#include "sightline/apps/common/model.h"

namespace sightline::apps {

class CommandLine;

struct ViewOptions {
  std::string size = "1280x720", view, path;
  int frame = 0, frames = 300;
  bool fit = false;
  bool quiet = false;  ///< choose_view() prints nothing
};

/// --size, --view, --path with --frame and --frames, --fit
void add_view_options(CommandLine& line, ViewOptions& options);

/// The view of an image whose width is `aspect` times its height; by default of the whole model, with a warning on
/// stderr of what that leaves out.
core::Expected<core::View> choose_view(const ViewOptions& options, const Model& model, const core::Snapshot& snapshot,
                                       double aspect);
/// The same where that is known of the model: what its views of the whole should show.
core::Expected<core::View> choose_view(const ViewOptions& options, const core::dvec3& offset,
                                       const core::FittedBounds& fitted, double aspect);

}  // namespace sightline::apps
