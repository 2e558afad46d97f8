// The cases of the stability suite: families, each swept over many orders of magnitude, with the limits of each case.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sightline/apps/bench/stability/shapes.h"
#include "sightline/core/affine.h"
#include "sightline/gpuprims/internal/ray.h"

namespace sightline::bench {

/// One ray at one primitive.
struct Sample {
  core::Primitive primitive;
  core::Affine world_from_item;  ///< linear part representable in float, as records hold it
  core::Ray ray;                 ///< in the world
  double radius = 1.0;           ///< unit of errors, in the item's units
};

/// Limits of a path, lengths in radii.
struct Limits {
  double t = 0.0;       ///< largest error of a crossing
  double normal = 0.0;  ///< of its normal, radians
  double band = 0.0;    ///< rays nearer to a tie than this are not judged
  double wrong = 0.0;   ///< average share of rays that may hit or miss wrongly outside the band
};

struct Case {
  core::Kind kind = core::Kind::kCylinder;
  std::string family;      ///< "eye-distance"
  double magnitude = 1.0;  ///< of the quantity that the family sweeps; may be 0
  Limits wide, single;     ///< for computations in double, and in the shaders' float
  std::function<Sample(Random&)> sample;

  std::string name() const;  ///< "eye-distance 1e+05"
};

/// The cases of every kind, grouped by families and by rising magnitude.
std::vector<Case> stability_cases();

/// Names of all families, in the order of stability_cases().
std::vector<std::string> stability_families();

}  // namespace sightline::bench
