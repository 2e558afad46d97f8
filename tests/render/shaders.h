// The shaders below tests/render/shaders that the test program embeds.
#pragma once

#include <span>
#include <string_view>
#include <utility>

namespace sightline::tests {

std::span<const std::pair<std::string_view, std::string_view>> shaders();

}  // namespace sightline::tests
