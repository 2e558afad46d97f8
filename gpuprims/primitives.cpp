#include "sightline/gpuprims/primitives.h"

#include <type_traits>

#include "sightline/gpuprims/box.h"
#include "sightline/gpuprims/circular_torus.h"
#include "sightline/gpuprims/cylinder.h"
#include "sightline/gpuprims/elliptical_dish.h"
#include "sightline/gpuprims/pyramid.h"
#include "sightline/gpuprims/rectangular_torus.h"
#include "sightline/gpuprims/snout.h"
#include "sightline/gpuprims/sphere.h"
#include "sightline/gpuprims/spherical_dish.h"

namespace sightline::gpuprims {

template <class Real>
Hits intersect(const core::Primitive& primitive, const Ray& ray, Caps caps) {
  return std::visit(
      [&](const auto& p) -> Hits {
        if constexpr (std::is_same_v<std::decay_t<decltype(p)>, core::Line>) {
          return {};
        } else {
          return intersect<Real>(p, ray, caps);
        }
      },
      primitive);
}
template Hits intersect<double>(const core::Primitive&, const Ray&, Caps);
template Hits intersect<float>(const core::Primitive&, const Ray&, Caps);

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
