// Affine maps in double precision: p -> linear * p + origin.
#pragma once

#include <cmath>

#include "sightline/core/conventions.h"

namespace sightline::core {

/// World-from-node, node-from-item and the like. Any linear part is allowed: scale, shear, mirror, singular.
struct Affine {
  dmat3 linear{1.0};
  dvec3 origin{0.0};
};

inline dvec3 transform_point(const Affine& a, const dvec3& p) {
  return a.linear * p + a.origin;
}

/// (a * b)(p) = a(b(p)): c_from_a reads c_from_b * b_from_a.
inline Affine operator*(const Affine& a, const Affine& b) {
  return {a.linear * b.linear, transform_point(a, b.origin)};
}

inline Affine translation(const dvec3& t) {
  return {dmat3(1.0), t};
}

inline bool is_finite(const dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

inline bool is_finite(const Affine& a) {
  return is_finite(a.linear[0]) && is_finite(a.linear[1]) && is_finite(a.linear[2]) && is_finite(a.origin);
}

}  // namespace sightline::core
