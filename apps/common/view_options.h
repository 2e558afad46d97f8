// Options for the view of an image, the same for every tool that makes one.
#pragma once

#include <string>
#include <vector>

#include "sightline/apps/common/model.h"

namespace sightline::apps {

class CommandLine;

struct ViewOptions {
  std::string size = "1280x720", view, path;
  std::string from = "iso";  ///< of the whole, without a view or path
  bool parallel = false;     ///< the same
  bool fit = false;
  std::vector<std::string> sections;  ///< as parse_section() reads them
  int frame = 0, frames = 300;
  bool allow_empty = false;  ///< sections may leave nothing
  bool quiet = false;        ///< choose_view() prints nothing
};

/// A section plane as "z<12.3" or "x>250mm": an axis, the side that stays, and where; metres without a unit.
core::Expected<core::Plane> parse_section(const std::string& text);

/// Fails where the sections of a view leave nothing of the boxes that it may show. `offset`: by which the model was
/// moved, for the message.
core::Expected<void> check_sections(const core::View& view, const core::ItemBounds& items,
                                    const core::dvec3& offset = core::dvec3(0.0));

/// --size, --from, --ortho, --section, --view, --path with --frame and --frames
void add_view_options(CommandLine& line, ViewOptions& options);

/// The view of an image whose width is `aspect` times its height; by default of all that is shown, with a warning on
/// stderr of what that leaves out. Fails where sections leave nothing, unless that is allowed.
core::Expected<core::View> choose_view(const ViewOptions& options, const Model& model, const core::Snapshot& snapshot,
                                       double aspect);
/// Overload where the model's boxes are known, and which of them its views of the whole should show.
core::Expected<core::View> choose_view(const ViewOptions& options, const core::dvec3& offset,
                                       const core::ItemBounds& items, const core::FittedBounds& fitted, double aspect);
/// A view, with the sections of the options; fails as choose_view() does.
core::Expected<core::View> with_sections(core::View view, const ViewOptions& options, const core::dvec3& offset,
                                         const core::ItemBounds& items);

}  // namespace sightline::apps
