// The primitives' GLSL, embedded. Programs that draw primitives include this table.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace sightline::gpuprims {

/// Name (without folder) and text of each file of gpuprims/shaders.
std::span<const std::pair<std::string_view, std::string_view>> shaders();

}  // namespace sightline::gpuprims
