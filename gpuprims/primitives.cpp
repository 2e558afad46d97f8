#include "sightline/gpuprims/internal/primitives.h"

#include <type_traits>

#include "sightline/gpuprims/internal/box.h"
#include "sightline/gpuprims/internal/circular_torus.h"
#include "sightline/gpuprims/internal/cylinder.h"
#include "sightline/gpuprims/internal/elliptical_dish.h"
#include "sightline/gpuprims/internal/pyramid.h"
#include "sightline/gpuprims/internal/rectangular_torus.h"
#include "sightline/gpuprims/internal/snout.h"
#include "sightline/gpuprims/internal/sphere.h"
#include "sightline/gpuprims/internal/spherical_dish.h"

namespace sightline::gpuprims {

Hits intersect(const core::Primitive& primitive, const Ray& ray, Caps caps) {
  return std::visit(
      [&](const auto& p) -> Hits {
        if constexpr (std::is_same_v<std::decay_t<decltype(p)>, core::Line>) {
          return {};
        } else {
          return intersect(p, ray, caps);
        }
      },
      primitive);
}

core::Mesh tessellate(const core::Primitive& primitive, const Tessellation& config, Caps caps) {
  return std::visit(
      [&](const auto& p) -> core::Mesh {
        if constexpr (std::is_same_v<std::decay_t<decltype(p)>, core::Line>) {
          return {};
        } else {
          return tessellate(p, config, caps);
        }
      },
      primitive);
}

}  // namespace sightline::gpuprims
