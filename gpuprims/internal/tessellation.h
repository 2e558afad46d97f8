// How finely the analytic primitives become triangles. All per-kind tessellate() functions promise:
//   - positions and normals in the primitive's local units; smooth normals on curved parts, flat ones on caps and faces
//   - triangles counter-clockwise from outside; none has two corners at one position
//   - a capped primitive gives a closed surface: every edge meets its reverse, compared by positions. Creases and seams
//     have two vertices per point, one for each normal, at positions that are equal to the bit
//   - a degenerate primitive gives what it shows: a disc of no thickness has two sides, a cylinder of radius 0 is
//     empty; a primitive with a parameter that is not finite is empty, too
#pragma once

#include "sightline/core/mesh.h"
#include "sightline/core/primitive.h"
#include "sightline/gpuprims/internal/ray.h"

namespace sightline::gpuprims {

/// Full circles get a whole number of segments; arcs get their share of it, rounded up.
struct Tessellation {
  /// Largest distance between the triangles and the true surface, in the primitive's local units; > 0 (otherwise
  /// max_segments is used). Divide a tolerance in metres by the placement's largest scale first.
  double chord_tolerance = 1.0;
  int min_segments = 8;    ///< per full circle; below 3 it counts as 3
  int max_segments = 256;  ///< per full circle; limits the count even where the tolerance asks for more
  int fixed_segments = 0;  ///< > 0: this many per full circle, whatever the tolerance
};

/// Number of segments for an arc (radians, > 0 and at most 2 pi) of a radius: ceil(arc / acos(1 - tolerance / radius)),
/// clamped to the limits of Tessellation. For tolerance << radius such a segment is a quarter of the tolerance away
/// from its arc, which leaves room for surfaces curved in two directions. A tolerance beyond the diameter counts as the
/// diameter.
int segment_count(const Tessellation& config, double radius, double arc);

}  // namespace sightline::gpuprims
