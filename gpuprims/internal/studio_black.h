// How Lighting::kStudio shows dark materials. Internal: for renderers; render/shaders/shading.glsl has the twin.
#pragma once

#include <algorithm>

#include "sightline/core/conventions.h"

namespace sightline::gpuprims {

/// The grey, sRGB, as which the studio's light shows black. A black that reflects nothing is a silhouette without edges
/// or shading, whatever the lights. The largest value for which darker materials are never shown lighter.
inline constexpr float kStudioBlack = 0.25f;

/// The colour that is lit in place of a material's: lighter by `black`, times the fourth power of how far its largest
/// channel is from 1, so that colours which show their shape anyway stay what they are.
inline core::vec3 lit_colour(const core::vec3& colour, float black) {
  const float dark = 1.0f - std::max({colour.r, colour.g, colour.b}), square = dark * dark;
  return colour + black * square * square;
}

}  // namespace sightline::gpuprims
