// Random primitives of every kind, and points on them to aim rays at. Points have only the precision of double, since
// they only choose the rays.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "sightline/core/primitive.h"

namespace sightline::bench {

inline constexpr double kPi = std::numbers::pi;
inline constexpr float kWhole = 6.2831855f;  ///< the float next above 2 pi
inline constexpr core::Kind kSolids[] = {core::Kind::kCylinder,         core::Kind::kSnout,  core::Kind::kCircularTorus,
                                         core::Kind::kRectangularTorus, core::Kind::kSphere, core::Kind::kSphericalDish,
                                         core::Kind::kEllipticalDish,   core::Kind::kBox,    core::Kind::kPyramid};

/// Random numbers that are equal on every platform, unlike those of the standard's distributions.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double unit() { return double(engine_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * unit(); }
  double log_uniform(double low, double high) { return std::pow(10.0, uniform(low, high)); }
  int below(int n) { return int(engine_() % std::uint64_t(n)); }
  double sign() { return below(2) ? 1.0 : -1.0; }
  std::uint64_t bits() { return engine_(); }
  core::dvec3 direction() {
    const double z = uniform(-1.0, 1.0), angle = uniform(0.0, 2.0 * std::numbers::pi), across = std::sqrt(1.0 - z * z);
    return {across * std::cos(angle), across * std::sin(angle), z};
  }

 private:
  std::mt19937_64 engine_;
};

/// A primitive whose lengths are all within a factor of ten.
core::Primitive plain_shape(core::Kind kind, Random& random);

/// The length that is the unit of errors: radius of a cylinder, sphere or dish's base, the larger radius of a snout,
/// tube radius of a circular torus; half the larger side of a box's or pyramid's base; half the larger side of a
/// rectangular torus's profile.
double radius_of(const core::Primitive& primitive);

struct SurfacePoint {
  core::dvec3 point{0.0};
  core::dvec3 normal{0.0};  ///< outward, unit length
  core::dvec3 along{0.0};   ///< a unit tangent; on an edge its direction
};

/// A point on any face.
SurfacePoint surface_point(const core::Primitive& primitive, Random& random);
/// A point on the curved face; on a plane side for boxes and pyramids.
SurfacePoint lateral_point(const core::Primitive& primitive, Random& random);
/// A point on a rim, seam or edge, with the normal between its two faces. On a sphere any point.
SurfacePoint edge_point(const core::Primitive& primitive, Random& random);

}  // namespace sightline::bench
