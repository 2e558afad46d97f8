// The stability suite's GLSL, embedded.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace sightline::bench {

/// Name (without folder) and text of each file of apps/bench/stability/shaders.
std::span<const std::pair<std::string_view, std::string_view>> shaders();

}  // namespace sightline::bench
