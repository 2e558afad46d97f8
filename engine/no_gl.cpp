// The functions of backend.h that make backends, for builds without GL.
#include "sightline/engine/internal/backend.h"

namespace sightline::engine {

core::Expected<std::unique_ptr<Backend>> make_backend(const EngineConfig&, const Overrides&) {
  return core::fail("drawing and the GPU culler need OpenGL, and this build was made without it (SIGHTLINE_GL)");
}

std::unique_ptr<KeptState> keep_current_context() {
  return nullptr;
}

void plan_programs(Plan&, const core::Snapshot&, bool, const char*) {}

}  // namespace sightline::engine
