// The shaders below tests/culling/shaders.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace sightline::tests::culling_shaders {

std::span<const std::pair<std::string_view, std::string_view>> shaders();

}  // namespace sightline::tests::culling_shaders
