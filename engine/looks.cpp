#include "sightline/engine/internal/looks.h"

#include <cmath>

#include "sightline/core/affine.h"

namespace sightline::engine {

core::Expected<void> check(const Looks& looks) {
  const auto share = [](float x) { return x >= 0.0f && x <= 1.0f; };
  if (!share(looks.depth_shading.strength) || !share(looks.depth_shading.edge_lines))
    return core::fail("engine: strength and edge_lines of depth_shading must be between 0 and 1");
  if (!share(looks.hatching.strength)) return core::fail("engine: strength of hatching must be between 0 and 1");
  if (!(looks.hatching.spacing >= 2.0f) || !std::isfinite(looks.hatching.spacing))
    return core::fail("engine: spacing of hatching must be 2 or more pixels");
  if (!core::is_finite(looks.sun) || looks.sun == core::dvec3(0.0))
    return core::fail("engine: sun must be a finite direction, and not zero");
  for (const core::vec3& colour : {looks.background.bottom, looks.background.top})
    if (!share(colour.r) || !share(colour.g) || !share(colour.b))
      return core::fail("engine: colours of background must be between 0 and 1");
  return {};
}

}  // namespace sightline::engine
