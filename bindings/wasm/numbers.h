// Numbers in arrays of JavaScript, as the library's types.
#pragma once

#include <cstdint>
#include <span>

#include <glm/gtc/type_ptr.hpp>

#include "sightline/core/aabb.h"
#include "sightline/core/affine.h"
#include "sightline/core/ray.h"

namespace sightline::wasm {

/// Six numbers each: the least corner, the greatest.
inline std::span<const core::AabbD> boxes_at(const double* numbers, std::uint32_t count) {
  static_assert(sizeof(core::AabbD) == 6 * sizeof(double));
  return {reinterpret_cast<const core::AabbD*>(numbers), count};
}
inline core::dvec3 point_at(const double* numbers) {
  return glm::make_vec3(numbers);
}
/// Sixteen numbers in columns, of which the last row is left out.
inline core::Affine affine_at(const double* matrix) {
  return {core::dmat3(point_at(matrix), point_at(matrix + 4), point_at(matrix + 8)), point_at(matrix + 12)};
}
/// Origin, direction, the least and the greatest t.
inline core::Ray ray_at(const double* numbers) {
  return {.origin = point_at(numbers), .direction = point_at(numbers + 3), .t_min = numbers[6], .t_max = numbers[7]};
}

}  // namespace sightline::wasm
