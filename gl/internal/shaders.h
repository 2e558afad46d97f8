// The self-test's GLSL, embedded.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace sightline::gl {

/// Name (without folder) and text of each file of gl/shaders.
std::span<const std::pair<std::string_view, std::string_view>> shaders();

}  // namespace sightline::gl
