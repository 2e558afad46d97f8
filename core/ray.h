// A ray, for queries of boxes and for the ray tracer.
#pragma once

#include <limits>

#include "sightline/core/conventions.h"

namespace sightline::core {

/// Points origin + t * direction, t_min <= t <= t_max, in world metres. Either end may be infinite; t_min > t_max is a
/// ray without points, which meets nothing. With a direction of unit length t is in metres. Components are below 1e150.
struct Ray {
  dvec3 origin{0.0};
  dvec3 direction{0.0, 1.0, 0.0};
  double t_min = 0.0;
  double t_max = std::numeric_limits<double>::infinity();
};

}  // namespace sightline::core
