// The request of an image by rays, and the light in it, as renderers have it. Internal to raytrace and engine.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "sightline/core/view.h"
#include "sightline/gpuprims/internal/studio_black.h"
#include "sightline/gpuprims/surroundings.h"
#include "sightline/raytrace/internal/surface.h"
#include "sightline/raytrace/internal/traced_scene.h"

namespace sightline::raytrace {

/// The scene, the view and the looks of an image. Borrows everything.
struct ImageRequest {
  TracedScene scene;
  const core::View& view;
  int width, height;                                             ///< pixels
  gpuprims::Lighting lighting = gpuprims::Lighting::kHeadLight;  ///< and the rest as render::Renderer has them
  core::dvec3 sun{0.0, 0.0, 1.0};
  gpuprims::Background background = {};
  bool ghosts = false;  ///< surfaces let most of what is behind them through, and there is no background
};

/// Bayer's matrix of order 4.
inline std::uint32_t place_of(std::uint32_t x, std::uint32_t y) {
  const std::uint32_t across = x ^ y;
  return (across & 1u) << 3 | (y & 1u) << 2 | (across & 2u) | (y & 2u) >> 1;
}

/// Twin of dithered_away() in render/shaders/shading.glsl.
inline bool dithered_away(float alpha, std::uint32_t x, std::uint32_t y, std::uint32_t id) {
  return alpha < 1.0f && alpha < (float(place_of(x + 7u * id, y + 3u * id)) + 0.5f) / 16.0f;
}

/// Replaces a hit by the first one that dithering leaves in the pixel.
inline void pass_dithered(const SceneRays& scene, const core::Ray& ray, const glm::uvec2& pixel,
                          SceneRays::PartHit& hit) {
  const auto shows = [&](const SceneRays::PartHit& one) {
    const float alpha = material_of(*one.snapshot, one.hit.slot).a;
    return !dithered_away(alpha, pixel.x, pixel.y, to_index(one.hit.item));
  };
  if (hit.snapshot && !shows(hit)) scene.first_that(ray, hit, shows);
}

/// Twin of ghost_alpha() in render/shaders/shading.glsl.
inline float ghost_alpha(float alpha, float head) {
  const float edge = 1.0f - head;
  return alpha * (0.12f + 0.88f * edge * edge);
}

/// Twin of write_surface() in render/shaders/shading.glsl.
class Lit {
 public:
  explicit Lit(const ImageRequest& looks)
      : black_(looks.lighting == gpuprims::Lighting::kStudio ? gpuprims::kStudioBlack : 0.0f) {
    for (const gpuprims::DistantLight& light : gpuprims::distant_lights(looks.view, looks.lighting, looks.sun))
      lights_[std::size_t(count_++)] = {core::vec3(light.towards), float(light.strength)};
  }

  /// The colour of a surface whose normal points to the viewer.
  core::vec3 colour(const core::vec3& n, const core::vec3& to_viewer, const glm::vec4& material) const {
    const float head = glm::dot(n, to_viewer);
    float diffuse = head, gloss = power_24(head);
    if (count_ > 0) diffuse = gloss = 0.0f;
    for (int i = 0; i < count_; ++i) {
      const auto& [towards, strength] = lights_[std::size_t(i)];
      const float cosine = glm::dot(n, towards);
      if (cosine <= 0.0f) continue;
      diffuse += strength * cosine;
      gloss += strength * power_24(std::max(0.0f, glm::dot(n, glm::normalize(towards + to_viewer))));
    }
    const float light = 0.30f + 0.50f * diffuse + 0.25f * (0.5f + 0.5f * n.z);
    return glm::min(gpuprims::lit_colour(core::vec3(material), black_) * light + 0.12f * gloss, core::vec3(1.0f));
  }

 private:
  struct Light {
    core::vec3 towards;
    float strength;
  };
  static float power_24(float x) {
    const float square = x * x, eighth = square * square * square * square;
    return eighth * eighth * eighth;
  }
  float black_;
  int count_ = 0;
  std::array<Light, gpuprims::kMostDistantLights> lights_{};
};

}  // namespace sightline::raytrace
