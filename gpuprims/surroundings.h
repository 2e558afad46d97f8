// What surrounds a scene in its images: lights, and what is behind everything.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "sightline/core/api.h"
#include "sightline/core/conventions.h"
#include "sightline/core/fixed_list.h"
#include "sightline/core/view.h"

namespace sightline::gpuprims {

using core::dvec3;
using core::vec3;

/// All of them have a share of the sky beside: more on what faces up.
enum class Lighting : std::uint8_t {
  kHeadLight,  ///< one light at the eye
  kStudio,     ///< a key light over the viewer's left shoulder, and a fainter one from the right that fills its
               ///< shadows; black is lit as a dark grey, so that it shows shapes
  kSun,        ///< one light infinitely far away, which stays where it is in the world
};

constexpr std::string_view name_of(Lighting lighting) {
  constexpr std::array<std::string_view, 3> kNames{"head-light", "studio", "sun"};
  return std::size_t(lighting) < kNames.size() ? kNames[std::size_t(lighting)] : std::string_view();
}

/// A light infinitely far away. It lights the side of a surface that the viewer sees, if the light is on that side.
struct DistantLight {
  dvec3 towards{0.0};     ///< the light, in the world; of length 1
  double strength = 1.0;  ///< 1 is as bright as the head-light
};

/// At most so many lights are far away.
inline constexpr std::size_t kMostDistantLights = 2;

/// The lights of an image of `view`, none where it has the head-light alone. `sun`: the direction to it in the world,
/// finite and of any length but 0; for Lighting::kSun alone.
SIGHTLINE_API core::FixedList<DistantLight, kMostDistantLights> distant_lights(const core::View& view,
                                                                               Lighting lighting, const dvec3& sun);

/// What is behind everything in an image: two colours, sRGB, and an even change between them from border to border.
struct Background {
  vec3 bottom{0.86f, 0.88f, 0.91f}, top = bottom;
  friend bool operator==(const Background&, const Background&) = default;
};

}  // namespace sightline::gpuprims
