// The GLSL of the traversals, embedded, and how many groups a dispatch takes.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

namespace sightline::study::rays {

/// Name (without folder) and text of each file of apps/study/rays/gpu/shaders.
std::span<const std::pair<std::string_view, std::string_view>> shaders();

/// Groups of b that hold a invocations.
constexpr std::uint32_t divided_up(std::uint32_t a, std::uint32_t b) {
  return a / b + (a % b != 0);
}

}  // namespace sightline::study::rays
