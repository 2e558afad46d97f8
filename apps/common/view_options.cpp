#include "sightline/apps/common/view_options.h"

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/importers/view_json.h"

namespace sightline::apps {

void add_view_options(CommandLine& to, ViewOptions& options) {
  CommandLine line = to.group(OptionGroup::kGeneral);
  ViewOptions& o = options;
  line.add("--size", o.size, "Pixels").shows_default().accepted_by(parse_size);
  const Option view = line.add("--view", o.view, "View JSON file");
  const Option path = line.add("--path", o.path, "Camera path JSON file; see --frame").excludes(view);
  line.add("--frame", o.frame, "Frame of the path, of --frames in all").needs(path).not_negative();
  line.add("--frames", o.frames, "Frames that the path is sampled into").shows_default().needs(path).positive();
  line.check([&o]() -> core::Expected<void> {
    if (o.frame >= o.frames) return core::fail("--frame: must be below --frames");
    return {};
  });
  line.add_flag("--fit", o.fit, "Fit the whole model (the default without --view and --path)")
      .excludes(view)
      .excludes(path);
}

core::Expected<core::View> choose_view(const ViewOptions& options, const Model& model, const core::Snapshot& snapshot,
                                       double aspect) {
  const bool whole = options.view.empty() && options.path.empty();
  return choose_view(options, model.offset, whole ? snapshot.bounds().fitted_bounds() : core::FittedBounds(), aspect);
}

core::Expected<core::View> choose_view(const ViewOptions& options, const core::dvec3& offset,
                                       const core::FittedBounds& fitted, double aspect) {
  if (!options.view.empty()) {
    auto view = importers::read_view(options.view, aspect);
    return view ? importers::translated(*view, offset) : view;
  }
  if (!options.path.empty()) {
    auto path = importers::read_path(options.path);
    if (path) path = importers::translated(*path, offset);
    if (!path) return tl::unexpected(path.error());
    return path->view(path->time_of(options.frame, options.frames), aspect);
  }
  if (!options.quiet) warn_of_outliers(fitted);
  return core::View::fit(fitted.bounds, core::kOverviewDirection, kFovy, aspect);
}

}  // namespace sightline::apps
