#include "sightline/gpuprims/internal/primitives.h"

#include <type_traits>

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
