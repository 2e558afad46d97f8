#include "sightline/apps/common/view_options.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include <fmt/format.h>

#include "sightline/apps/common/arguments.h"
#include "sightline/apps/common/command_line.h"
#include "sightline/core/fitting.h"
#include "sightline/core/internal/platform/files.h"
#include "sightline/importers/view_json.h"

namespace sightline::apps {
namespace {

/// Names of views of the whole, in the order of help.
struct Standard {
  const char* name;
  core::dvec3 direction;
};
constexpr Standard kStandard[] = {{"front", {0, 1, 0}},  {"back", {0, -1, 0}}, {"left", {1, 0, 0}},
                                  {"right", {-1, 0, 0}}, {"top", {0, 0, -1}},  {"bottom", {0, 0, 1}}};

core::dvec3 direction_of(const std::string& name) {
  for (const Standard& view : kStandard)
    if (view.name == name) return view.direction;
  return core::kOverviewDirection;
}

}  // namespace

core::Expected<core::Plane> parse_section(const std::string& text) {
  const auto refused = [&] {
    return core::fail(
        "expected an axis, < or >, and a number with a unit or metres, such as \"z<12.3\" or \"x>250mm\"; found \"" +
        text + "\"");
  };
  char axis = 0, side = 0, unit[4] = {};
  double at = 0.0;
  int used = 0;
  if (std::sscanf(text.c_str(), " %c %c%lf%n", &axis, &side, &at, &used) != 3 || !std::isfinite(at)) return refused();
  int end = used;
  if (std::sscanf(text.c_str() + used, " %3[a-z]%n", unit, &end) == 1) used += end;
  const auto metres = unit[0] == 0 ? std::optional(1.0) : metres_of(unit);
  if (axis < 'x' || axis > 'z' || (side != '<' && side != '>') || !metres || used != int(text.size())) return refused();
  const double sign = side == '>' ? 1.0 : -1.0;
  core::Plane plane{core::dvec3(0.0), -sign * at * *metres};
  plane.normal[axis - 'x'] = sign;
  return plane;
}

void add_view_options(CommandLine& to, ViewOptions& options) {
  CommandLine line = to.group(OptionGroup::kGeneral);
  ViewOptions& o = options;
  line.add("--size", o.size, "Pixels").metavar("WxH").shows_default().accepted_by(parse_size);
  std::vector<std::string> names;
  for (const Standard& standard : kStandard) names.emplace_back(standard.name);
  names.emplace_back("iso");
  const Option from =
      line.add("--from", o.from, "See the whole from front, back, left, right, top, bottom or iso, which is above")
          .one_of(names)
          .usage_text("SIDE (iso)");
  const Option parallel = line.add_flag("--ortho", o.parallel, "Parallel projection of the whole");
  const Option fit = line.add_flag("--fit", o.fit, "Fit what is shown: the default").advanced();
  line.add("--section", o.sections, "Keep one side of a plane, such as \"z<12.3\" or \"x>250mm\"; up to eight")
      .metavar("PLANE")
      .one_value_each()
      .accepted_by(parse_section);
  line.add_flag("--allow-empty", o.allow_empty, "Draw an image also where sections leave nothing").advanced();
  const Option view =
      line.add("--view", o.view, "View JSON file").metavar("FILE").excludes(from).excludes(parallel).excludes(fit);
  const Option path = line.add("--path", o.path, "Camera path JSON file; see --frame")
                          .metavar("FILE")
                          .excludes(view)
                          .excludes(from)
                          .excludes(parallel)
                          .excludes(fit)
                          .advanced();
  line.add("--frame", o.frame, "Frame of the path, of --frames in all").needs(path).not_negative().advanced();
  line.add("--frames", o.frames, "Frames that the path is sampled into")
      .shows_default()
      .needs(path)
      .positive()
      .advanced();
  line.check([&o]() -> core::Expected<void> {
    if (o.frame >= o.frames)
      return core::fail("--frame: " + std::to_string(o.frame) + " must be below --frames, " + std::to_string(o.frames));
    if (o.sections.size() > core::kMaxSectionPlanes)
      return core::fail("--section: at most " + std::to_string(core::kMaxSectionPlanes) + " planes, found " +
                        std::to_string(o.sections.size()));
    return {};
  });
}

namespace {

/// Planes of a model that was moved by `offset`.
std::vector<core::Plane> planes_of(const ViewOptions& options, const core::dvec3& offset) {
  std::vector<core::Plane> planes;
  for (const std::string& text : options.sections) {
    core::Plane plane = parse_section(text).value();
    plane.offset -= glm::dot(plane.normal, offset);
    planes.push_back(plane);
  }
  return planes;
}

/// The view of the whole, or of what sections keep of it.
core::Expected<core::View> fitted_view(const ViewOptions& options, const std::vector<core::Plane>& sections,
                                       const core::ItemBounds& items, const core::AabbD& bounds, double aspect) {
  const core::Fitting fitting = core::fitting_of(items, bounds, direction_of(options.from), kFovy, aspect, sections);
  return options.parallel ? fitting.parallel() : fitting.perspective();
}

core::Expected<core::View> chosen_view(const ViewOptions& options, const std::vector<core::Plane>& sections,
                                       const core::dvec3& offset, const core::ItemBounds& items,
                                       const core::FittedBounds& fitted, double aspect) {
  if (!options.view.empty()) {
    auto view = importers::read_view(core::platform::path_of(options.view), aspect);
    return view ? importers::translated(*view, offset) : view;
  }
  if (!options.path.empty()) {
    auto path = importers::read_path(core::platform::path_of(options.path));
    if (path) path = importers::translated(*path, offset);
    if (!path) return tl::unexpected(path.error());
    return path->view(path->time_of(options.frame, options.frames), aspect);
  }
  if (!options.quiet) warn_of_outliers(fitted);
  return fitted_view(options, sections, items, fitted.bounds, aspect);
}

}  // namespace

core::Expected<core::View> choose_view(const ViewOptions& options, const Model& model, const core::Snapshot& snapshot,
                                       double aspect) {
  const bool fits = options.view.empty() && options.path.empty();
  return choose_view(options, model.offset, snapshot.bounds(),
                     fits ? snapshot.bounds().fitted_bounds() : core::FittedBounds(), aspect);
}

core::Expected<core::View> choose_view(const ViewOptions& options, const core::dvec3& offset,
                                       const core::ItemBounds& items, const core::FittedBounds& fitted, double aspect) {
  auto view = chosen_view(options, planes_of(options, offset), offset, items, fitted, aspect);
  return view ? with_sections(std::move(*view), options, offset, items) : view;
}

core::Expected<core::View> with_sections(core::View view, const ViewOptions& options, const core::dvec3& offset,
                                         const core::ItemBounds& items) {
  const std::vector<core::Plane> sections = planes_of(options, offset);
  if (!sections.empty() && view.section_mode == core::SectionMode::kUnion && !view.sections.empty())
    return core::fail("--section: the sections of " + options.view + " unite, so that no plane can be added");
  if (view.sections.size() + sections.size() > core::kMaxSectionPlanes)
    return core::fail("--section: more than " + std::to_string(core::kMaxSectionPlanes) + " planes with those of " +
                      options.view);
  view.sections.insert(view.sections.end(), sections.begin(), sections.end());
  if (options.allow_empty) return view;
  const auto kept = check_sections(view, items, offset);
  return kept ? core::Expected<core::View>(std::move(view)) : tl::unexpected(kept.error());
}

core::Expected<void> check_sections(const core::View& view, const core::ItemBounds& items, const core::dvec3& offset) {
  if (view.sections.empty()) return {};
  const bool all = view.section_mode == core::SectionMode::kIntersection;
  core::AabbD bounds;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items.vacant(i) || (items.layers(i) & view.layers) == 0) continue;
    const core::AabbD box = items.in_world(items.box(i));
    const auto reaches = [&](const core::Plane& plane) {
      const core::dvec3 farthest = glm::mix(box.min, box.max, glm::greaterThan(plane.normal, core::dvec3(0.0)));
      return glm::dot(plane.normal, farthest) + plane.offset >= 0.0;
    };
    if (all ? std::all_of(view.sections.begin(), view.sections.end(), reaches)
            : std::any_of(view.sections.begin(), view.sections.end(), reaches))
      return {};
    bounds.grow(box);
  }
  if (bounds.empty()) return {};  // without sections there would be nothing, either
  const auto millimetres = [&](const core::dvec3& p) { return 1e-3 * glm::round(1e3 * (p - offset)) + 0.0; };  // no -0
  const core::dvec3 low = millimetres(bounds.min), high = millimetres(bounds.max);
  return core::fail(
      fmt::format("the sections leave nothing of the model, from {:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g} m", low.x,
                  low.y, low.z, high.x, high.y, high.z));
}

}  // namespace sightline::apps
