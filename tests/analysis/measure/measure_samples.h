// Random items of all kinds, ordinary and adversarial, and their points: what the tests of measure compare with.
#pragma once

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "sightline/core/primitive.h"
#include "sightline/tests/core/primitive_samples.h"

namespace sightline::tests {

inline constexpr core::Kind kSolidKinds[] = {core::Kind::kPyramid,
                                             core::Kind::kBox,
                                             core::Kind::kRectangularTorus,
                                             core::Kind::kCircularTorus,
                                             core::Kind::kEllipticalDish,
                                             core::Kind::kSphericalDish,
                                             core::Kind::kSnout,
                                             core::Kind::kCylinder,
                                             core::Kind::kSphere,
                                             core::Kind::kLine};
inline constexpr core::Kind kConvexKinds[] = {
    core::Kind::kPyramid, core::Kind::kBox,      core::Kind::kEllipticalDish, core::Kind::kSphericalDish,
    core::Kind::kSnout,   core::Kind::kCylinder, core::Kind::kSphere,         core::Kind::kLine};

template <std::size_t N>
core::Kind random_of(const core::Kind (&kinds)[N], Random& random) {
  return kinds[random() % N];
}

/// Lengths 0.1 to 2; circular tori have a hole.
inline core::Primitive ordinary_primitive(core::Kind kind, Random& random) {
  const auto length = [&] { return float(uniform(random, 0.1, 2.0)); };
  const auto shift = [&] { return float(uniform(random, -1.0, 1.0)); };
  const float turn = float(uniform(random, 0.2, 6.4));
  if (kind == core::Kind::kCircularTorus) {
    const float tube = 0.5f * length();
    return core::CircularTorus{tube + length(), tube, turn};
  }
  return primitive_of(kind, length, shift, [turn] { return turn; });
}

/// Rotation and scale; every fourth also sheared, every fifth mirrored.
inline core::Affine placement(Random& random, double scale, double distance) {
  core::Affine a{scale * random_rotation(random), {}};
  if (random() % 4 == 0) a.linear = a.linear * core::dmat3(1, 0, 0, uniform(random, -1, 1), 1, 0, 0.5, 0.3, 0.7);
  if (random() % 5 == 0) a.linear[0] = -a.linear[0];
  for (int i = 0; i < 3; ++i) a.origin[i] = uniform(random, -distance, distance);
  return a;
}

inline std::string text_of(const core::Primitive& primitive, const core::Affine& a) {
  std::ostringstream out;
  out.precision(17);
  out << core::name_of(core::kind_of(primitive));
  for (const float value : core::parameters(primitive)) out << ' ' << value;
  out << " at";
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) out << ' ' << a.linear[c][r];
  for (int r = 0; r < 3; ++r) out << ' ' << a.origin[r];
  return out.str();
}

/// Largest dot(direction, p - origin) over the placed primitive, by core's support function.
inline double placed_support(const core::Primitive& primitive, const core::Affine& a, const core::dvec3& direction,
                             const core::dvec3& origin) {
  return core::support(primitive, direction * a.linear) + glm::dot(direction, a.origin - origin);
}

/// About how far a placed primitive reaches from its origin.
inline double size_of(const core::Primitive& primitive, const core::Affine& a) {
  double size = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      core::dvec3 direction(0.0);
      direction[axis] = sign;
      size = std::max(size, placed_support(primitive, a, direction, a.origin));
    }
  return size;
}

}  // namespace sightline::tests
