// What a pick finds. Only builds with SIGHTLINE_RAYTRACE have picks.
#pragma once

#include "sightline/core/scene.h"
#include "sightline/raytrace/exact_visibility.h"
#include "sightline/raytrace/tracer.h"

namespace sightline::engine {

/// The item hit, and the node that holds it. Both are as of the engine's last commit(): the scene may have removed them
/// since.
struct Pick : raytrace::Hit {
  core::NodeId node = {};
};

}  // namespace sightline::engine
