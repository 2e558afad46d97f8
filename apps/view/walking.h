// Walks through a model: gravity, steps, walls. Pure logic: something else answers its rays.
#pragma once

#include <functional>
#include <optional>

#include "sightline/core/conventions.h"

namespace sightline::apps {

/// A body that stands upright, Z up: a cylinder, felt for by rays. What is thinner than a tenth of a metre and lies
/// between its rays may be missed, but its axis crosses nothing that is as high as the body.
class Walker {
 public:
  static constexpr double kEyeHeight = 1.7, kRadius = 0.3, kHighestStep = 0.4;  // metres
  static constexpr double kSpeed = 1.5;                                         // metres per second

  /// The distance of what a ray hits first, if that is at most `reach`. The direction has unit length.
  using Trace =
      std::function<std::optional<double>(const core::dvec3& origin, const core::dvec3& direction, double reach)>;
  explicit Walker(Trace trace) : trace_(std::move(trace)) {}

  /// Where the eye gets to from `eye` in some seconds with a velocity over the ground, metres per second. Walls stop
  /// it or make it slide along; what is no higher than a step is walked up. Where nothing is below it stays at its
  /// height.
  core::dvec3 move(core::dvec3 eye, const core::dvec2& velocity, double seconds);
  /// Whether move() would go on without a velocity.
  bool falling() const { return falling_; }

 private:
  bool free(const core::dvec3& from, const core::dvec3& direction, double reach) const {
    return !trace_(from, direction, reach);
  }
  core::dvec3 walk(const core::dvec3& eye, const core::dvec2& by) const;
  core::dvec2 kept_off(const core::dvec3& eye, core::dvec2 by) const;
  bool passes(const core::dvec3& eye, const core::dvec2& by) const;
  bool fits(const core::dvec3& eye) const;
  std::optional<double> floor_below(const core::dvec3& eye) const;
  double fall(const core::dvec3& eye, double seconds);

  Trace trace_;
  double speed_ = 0.0;  // downwards, metres per second
  bool falling_ = false;
};

}  // namespace sightline::apps
