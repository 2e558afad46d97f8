#include "sightline/apps/common/view_options.h"

#include <CLI/CLI.hpp>

#include "sightline/importers/view_json.h"

namespace sightline::apps {

void add_view_options(CLI::App& app, ViewOptions& options) {
  ViewOptions& o = options;
  app.add_option("--size", o.size, "Pixels")->capture_default_str()->check(accepted_by(parse_size));
  auto* view = app.add_option("--view", o.view, "View JSON file");
  auto* path = app.add_option("--path", o.path, "Camera path JSON file; see --frame")->excludes(view);
  app.add_option("--frame", o.frame, "Frame of the path, of --frames in all")
      ->needs(path)
      ->check(CLI::NonNegativeNumber);
  app.add_option("--frames", o.frames, "Frames that the path is sampled into")
      ->capture_default_str()
      ->needs(path)
      ->check(CLI::PositiveNumber);
  app.final_callback([&o] {
    if (o.frame >= o.frames) throw CLI::ValidationError("--frame", "must be below --frames");
  });
  app.add_flag("--fit", o.fit, "Fit the whole model (the default without --view and --path)")
      ->excludes(view)
      ->excludes(path);
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
