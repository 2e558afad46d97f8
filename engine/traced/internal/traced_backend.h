// Makes the backend whose images rays make. Internal to engine.
#pragma once

#include <memory>
#include <string>

#include "sightline/engine/internal/backend.h"

namespace sightline::engine {

/// Fails in builds without the ray tracer. `why`: for the plan. `overrides` are borrowed.
core::Expected<std::unique_ptr<Backend>> make_traced_backend(const EngineConfig& config, const Overrides& overrides,
                                                             const std::string& why);

}  // namespace sightline::engine
