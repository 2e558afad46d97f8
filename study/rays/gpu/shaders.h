// The GLSL of the traversals and of the grid's build, embedded.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace sightline::study::rays {

/// Name (without folder) and text of each file of study/rays/gpu/shaders.
std::span<const std::pair<std::string_view, std::string_view>> shaders();

}  // namespace sightline::study::rays
