// Internal: the inner loops of surface_deviation.h, one form per instruction set, behind plain pointers. The files that
// define them are compiled for their instruction set. So they must not call inline functions of other headers: the
// linker might use their copy in code for every processor. All forms compute with the same roundings.
#pragma once

#include <cstdint>

#include "sightline/core/conventions.h"

namespace sightline::lod {

inline constexpr double kBeside = 1e-13;  // of barycentric coordinates: less than that is rounding
inline constexpr int kLanes = 4;

/// A triangle that distances are measured from.
struct FaceShape {
  core::dvec3 corners[3];
  core::dvec3 normal;        // of unit length, or 0
  core::dvec3 gradients[2];  // of the barycentric coordinates of corners 1 and 2; not numbers for slivers
  double heights[3];         // squares of them, of corners 1, 2 and 0
  double per_square[3];      // 1 / square length of the edge from corner k to the next; 0: it has none
};

/// Two registers of two numbers, which all forms write and read as such: what is read wider than it was just written
/// waits for the cache.
struct alignas(16) Corner {
  double x, y, z, unused;
};

/// A convex one. Unused corners up to the next multiple of kLanes are the first one.
struct Polygon {
  static constexpr int kMostCorners = 10;
  Corner corners[12];
  int count = 0;

  Polygon() = default;
  Polygon(const Polygon& other) { *this = other; }
  /// Copies what is used, which is most often a third.
  Polygon& operator=(const Polygon& other) {
    count = other.count;
    for (int i = 0; i < count; i += kLanes)
      for (int k = i; k < i + kLanes; ++k) corners[k] = other.corners[k];
    return *this;
  }
  core::dvec3 corner(int i) const { return {corners[i].x, corners[i].y, corners[i].z}; }
  void add(const core::dvec3& p) { corners[count++] = {p.x, p.y, p.z, 0.0}; }
  void fill_up() {
    for (int i = count; i % kLanes != 0; ++i) corners[i] = corners[0];
  }
};

enum class Side { kInside, kOutside, kBoth };

/// Around faces, for quick tests of many.
inline constexpr std::uint32_t kBalls = 16;
struct Balls {
  float x[kBalls], y[kBalls], z[kBalls], radius[kBalls];
};

inline constexpr unsigned kAnyEdge = 7;
struct Farthest {
  double square;    ///< of the distance, or anything that is more than allowed
  unsigned beyond;  ///< a bit for each edge of the face that some corner may lie beyond
};

struct DeviationKernels {
  /// The point of the polygon that is farthest from a face, where all are at most so far. Not for slivers.
  Farthest (*farthest)(const FaceShape& face, const Polygon& polygon, double most);
  /// Where the polygon lies by the plane of this unit normal through this point, and its parts where that is on both
  /// sides. Corners at the plane are in both. Says inside, too, where rounding has made a polygon that a plane would
  /// cut more than twice.
  Side (*split)(const Polygon& polygon, const core::dvec3& normal, const core::dvec3& point, double rounding,
                Polygon& inside, Polygon& outside);
  /// A bit for each ball whose surface is nearer to the point than that, or that holds it.
  std::uint32_t (*near_ones)(const Balls& balls, const float* point, float most);
};

const DeviationKernels& deviation_kernels();
const DeviationKernels& scalar_deviation_kernels();
const DeviationKernels& neon_deviation_kernels();
const DeviationKernels& avx2_deviation_kernels();

}  // namespace sightline::lod
