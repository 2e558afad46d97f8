// The tour of a report: a camera path that shows something of the model in every frame.
#pragma once

#include "sightline/core/camera_path.h"
#include "sightline/core/item_bounds.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::apps {

/// Share of an image that shows items, 0 … 1, of a small grid of rays; 0 where one item alone fills it, since the eye
/// is then inside of it or against it. `aspect`: width / height.
core::Expected<double> covered_share(const raytrace::Tracer& tracer, const core::View& view, double aspect);

/// engine::make_tour() for the tracer's items, except where they would cover less of the image than half of what they
/// cover in the first view (at least 0.2 %, at most 5 %), by covered_share(): there the camera turns towards items, and
/// rises where that does not help. It moves smoothly between. Where nothing helps, it stays. `fitted`: of the same
/// items.
core::Expected<core::CameraPath> tour_in_sight(const raytrace::Tracer& tracer, const core::FittedBounds& fitted,
                                               double aspect);

}  // namespace sightline::apps
