// gpuprims: analytic primitives. The files of a kind share one stem: reference intersection in double, tessellation by
// chord tolerance, its GLSL twin in shaders/, and the packing of its parameters for the GPU.
//
// This header holds what the reference intersections share.
#pragma once

#include <array>

#include "sightline/core/conventions.h"

namespace sightline::gpuprims {

using core::dvec3;

/// origin + t * direction, in a primitive's local units. The direction need not have unit length: an affine map of a
/// ray keeps its t, so t may be metres, eye depth, or anything the caller chose.
struct Ray {
  dvec3 origin{0.0};
  dvec3 direction{0.0, 0.0, 1.0};
};

/// Faces by number; the first three as in the shaders.
enum Face : int {
  kLateral,      ///< round or conical; the dome of a dish, the tube of a torus, the outer wall of a rectangular one
  kBottom,       ///< at z = -height/2, the base of a dish, or the start of a sweep
  kTop,          ///< at z = +height/2, or the end of a sweep
  kBottomLevel,  ///< of a snout: replaces an end plane that does not close it
  kTopLevel,
  kInner,  ///< of a rectangular torus: its inner wall, and its level sides
  kBelow,
  kAbove,
  kMinX,  ///< sides of boxes and pyramids
  kMaxX,
  kMinY,
  kMaxY,
};

/// One crossing of a surface. The normal points out of the solid, in local space, not normalised; it is a gradient, so
/// it transforms by the inverse transpose.
struct Hit {
  double t;
  dvec3 normal;
  int face;
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
