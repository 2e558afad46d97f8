// Describes the machine in benchmarks that draw.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "sightline/gl/context.h"

namespace sightline::bench {

inline std::string renderer_line(const gl::Context& context) {
  return "renderer " + context.renderer() + ", " + context.version();
}

inline nlohmann::ordered_json renderer_json(const gl::Context& context) {
  return {{"renderer", context.renderer()}, {"version", context.version()}};
}

}  // namespace sightline::bench
