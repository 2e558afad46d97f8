// gpuprims: analytic primitives. The files of a kind share one stem: reference intersection in double, tessellation by
// chord tolerance, its GLSL twin in shaders/, and the packing of its parameters for the GPU.
//
// This header holds what the reference intersections share.
#pragma once

#include <array>

#include "sightline/core/primitive.h"
#include "sightline/core/ray.h"

namespace sightline::gpuprims {

using core::dvec3;
using core::Ray;  // in a primitive's local units; its ends are ignored
using enum core::Face;

/// One crossing of a surface. The normal points out of the solid, in local space, not normalised; it is a gradient, so
/// it transforms by the inverse transpose.
struct Hit {
  double t;
  dvec3 normal;
  int face;  ///< core::Face
};

/// All crossings of a ray with one primitive over -inf < t < inf, in rising t. The caller picks the first one that its
/// interval and its section planes keep. So the eye may be inside, and a section opens the view into the solid.
struct Hits {
  static constexpr int kCapacity = 8;
  std::array<Hit, kCapacity> hit;  ///< undefined from `count` on
  int count = 0;

  /// Inserts in order of t. Drops the hit when the capacity is reached, which no primitive here can do.
  void insert(const Hit& h) {
    if (count == kCapacity) return;
    int i = count++;
    for (; i > 0 && hit[i - 1].t > h.t; --i) hit[i] = hit[i - 1];
    hit[i] = h;
  }
};

/// Which ends of a cylinder, snout or torus slice are closed. "Bottom" is z = -height/2, or the start of a sweep.
struct Caps {
  bool bottom = true, top = true;
};

}  // namespace sightline::gpuprims
