// Shared by benchmarks that draw: their engines, and the machine in words.
#pragma once

#include <string>

#include "sightline/engine/engine.h"
#include "sightline/gl/context.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench {

/// Images with ids. Culled by the CPU, so that no frame is culled another way than the one before.
inline engine::EngineConfig drawing_config(int width, int height, gl::ContextPlatform platform) {
  engine::EngineConfig config;
  config.draw = config.drawing.ids = true;
  config.culling.culler = engine::CullerChoice::kCpu;
  config.width = width;
  config.height = height;
  config.context.platform = platform;
  config.context.gl_state = engine::GlState::kLeave;  // no other context is current here
  return config;
}

inline std::string renderer_line(const gl::Context& context) {
  return "renderer " + context.renderer() + ", " + context.version();
}

inline json::Value renderer_json(const gl::Context& context) {
  return {{"renderer", context.renderer()}, {"version", context.version()}};
}

}  // namespace sightline::bench
