// The GPU scene's own GLSL, embedded.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace sightline::gpuscene {

/// Name (without folder) and text of each file of gpuscene/shaders.
std::span<const std::pair<std::string_view, std::string_view>> shaders();

}  // namespace sightline::gpuscene
