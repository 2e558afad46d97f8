// How finely the analytic primitives become triangles. What the per-kind tessellate() functions share and promise:
//   - positions and normals in the primitive's local units; smooth normals on curved parts, flat ones on caps and faces
//   - triangles counter-clockwise from outside; none has two corners at one position
//   - a capped primitive gives a closed surface: every edge meets its reverse, compared by positions. Vertices at
//     creases and seams are doubled for their normals, at positions that are equal to the bit
//   - a degenerate primitive gives what it shows: a disc of no thickness has two sides, a cylinder of radius 0 is
//   empty,
//     and so is anything with a parameter that is not finite
#pragma once

#include "sightline/core/mesh.h"
#include "sightline/core/primitive.h"
#include "sightline/gpuprims/internal/ray.h"

namespace sightline::gpuprims {

/// Full circles get a whole number of segments, arcs their share of it, rounded up.
struct Tessellation {
  /// Largest distance between the triangles and the true surface, in the primitive's local units; > 0 (otherwise
  /// max_segments is taken). Divide a tolerance in metres by the placement's largest scale first.
  double chord_tolerance = 1.0;
  int min_segments = 8;    ///< per full circle, counts as at least 3
  int max_segments = 256;  ///< per full circle; limits the count even where the tolerance asks for more
  int fixed_segments = 0;  ///< > 0: this many per full circle instead of what the tolerance asks for
};

/// Segments for an arc (radians, > 0 and at most 2 pi) of a radius: ceil(arc / acos(1 - tolerance / radius)), clamped
/// as Tessellation says. One such segment is a quarter of the tolerance away from its arc for tolerance << radius,
/// which leaves the room that surfaces curved in two directions need. A tolerance beyond the diameter counts as the
/// diameter.
int segment_count(const Tessellation& config, double radius, double arc);

}  // namespace sightline::gpuprims
