#include "sightline/gpuprims/surroundings.h"

#include <array>

#include <glm/glm.hpp>

namespace sightline::gpuprims {
namespace {

/// A light of Lighting::kStudio, in eye space: x right, y up, z towards the viewer.
struct StudioLight {
  dvec3 towards;
  double strength;
};
constexpr std::array<StudioLight, kMostDistantLights> kStudio{
    {{{-0.45, 0.60, 0.66}, 0.95}, {{0.80, 0.05, 0.60}, 0.40}}};

}  // namespace

core::FixedList<DistantLight, kMostDistantLights> distant_lights(const core::View& view, Lighting lighting,
                                                                 const dvec3& sun) {
  core::FixedList<DistantLight, kMostDistantLights> lights;
  if (lighting == Lighting::kSun) lights.push_back({glm::normalize(sun), 1.0});
  if (lighting == Lighting::kStudio) {
    const core::dmat3 world_from_eye = glm::inverse(core::dmat3(view.eye_from_world()));
    for (const StudioLight& light : kStudio)
      lights.push_back({glm::normalize(world_from_eye * light.towards), light.strength});
  }
  return lights;
}

}  // namespace sightline::gpuprims
