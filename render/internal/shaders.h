// The renderer's own GLSL, embedded.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace sightline::render {

/// Name (without folder) and text of each file of render/shaders.
std::span<const std::pair<std::string_view, std::string_view>> shaders();

}  // namespace sightline::render
