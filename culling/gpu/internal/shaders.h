// The GPU culler's GLSL, embedded.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace sightline::culling {

/// Name (without folder) and text of each file of culling/gpu/shaders.
std::span<const std::pair<std::string_view, std::string_view>> shaders();

}  // namespace sightline::culling
