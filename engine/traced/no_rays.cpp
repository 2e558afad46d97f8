// For builds without the ray tracer.
#include "sightline/engine/traced/internal/traced_backend.h"

namespace sightline::engine {

core::Expected<std::unique_ptr<Backend>> make_traced_backend(const EngineConfig&, const Overrides&,
                                                             const std::string&) {
  return core::fail(
      "engine: images by rays need the ray tracer, and this build was made without it (SIGHTLINE_RAYTRACE)");
}

}  // namespace sightline::engine
