// The primitives' GLSL, embedded. Whoever draws them puts this table into its programs.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace sightline::gpuprims {

/// Name (without folder) and text of each file of gpuprims/shaders.
std::span<const std::pair<std::string_view, std::string_view>> shaders();

}  // namespace sightline::gpuprims
