// Walks through a model: gravity, steps, ladders, walls. Pure logic: something else answers its rays.
#pragma once

#include <functional>
#include <optional>

#include "sightline/core/aabb.h"
#include "sightline/core/conventions.h"

namespace sightline::apps {

/// A body that stands upright, Z up: a cylinder, felt for by rays. What is thinner than a tenth of a metre and lies
/// between its rays may be missed, but its axis crosses nothing that is as high as the body.
class Walker {
 public:
  static constexpr double kEyeHeight = 1.7, kRadius = 0.3, kHighestStep = 0.4;  // metres
  static constexpr double kSpeed = 1.5, kClimb = 0.7;                           // metres per second

  /// The distance of what a ray hits first, if that is at most `reach`. The direction has unit length.
  using Trace =
      std::function<std::optional<double>(const core::dvec3& origin, const core::dvec3& direction, double reach)>;
  explicit Walker(Trace trace) : trace_(std::move(trace)) {}

  /// Where the eye gets to from `eye` in some seconds with a velocity over the ground, metres per second. Walls stop
  /// it or make it slide along; what is no higher than a step is walked up. Whoever walks against a ladder, rungs of at
  /// most kHighestStep from each other, climbs it, and down again with their back to the way; whoever stands still
  /// stays on it. Where nothing is below it stays at its height.
  core::dvec3 move(core::dvec3 eye, const core::dvec2& velocity, double seconds);
  /// Where the eye of somebody is who stands on the nearest floor: the one below, or else the nearest of those that
  /// rays meet in rings around it and in 96 by 96 places of the model, from its height down or else from above the
  /// model. None where there is none.
  std::optional<core::dvec3> nearest_floor(const core::dvec3& eye, const core::AabbD& model) const;
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
  std::optional<core::dvec3> stand_at(const core::dvec3& eye) const;
  bool is_ladder(const core::dvec3& eye, const core::dvec2& direction, double lowest) const;
  bool finds_ladder(const core::dvec3& eye);
  bool climbs(core::dvec3& eye, const core::dvec2& by, double seconds);
  double fall(const core::dvec3& eye, double seconds);

  Trace trace_;
  double speed_ = 0.0;  // downwards, metres per second
  bool falling_ = false;
  bool hangs_ = false;                 // on a ladder over a floor that is farther down
  std::optional<core::dvec2> ladder_;  // the direction to one that is in reach
};

}  // namespace sightline::apps
