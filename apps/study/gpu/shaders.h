// The study's GLSL, embedded.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace sightline::study {

/// Name (without folder) and text of each file of apps/study/gpu/shaders.
std::span<const std::pair<std::string_view, std::string_view>> shaders();

}  // namespace sightline::study
