// A curve of cost that is learnt from samples.
#pragma once

#include <array>

#include "sightline/core/api.h"

namespace sightline::culling {

/// A piecewise-linear curve of log(cost) over a coordinate x >= 0. x counts octaves of what the cost depends on, so
/// that power laws are exact. Each knot knows how many samples it stands for. Where there are none, the nearest knot
/// decides.
class SIGHTLINE_API CostTable {
 public:
  /// log(cost) at x. Precondition: !empty().
  double predict(double x) const;
  /// How many samples the prediction rests on, 0 … kMostSamples; less where they are octaves away.
  double samples(double x) const;
  /// How far from x the samples of the prediction lie; 0 where it was learnt.
  double distance(double x) const;
  bool empty() const { return empty_; }

  /// Moves the curve towards a sample `residual` above predict(x) by the share that a running mean would: the
  /// first sample wholly, the n-th by 1/n, later ones by 1/kMostSamples. Into an empty table, residual is log(cost).
  void learn(double x, double residual);
  /// Moves the curve by `residual` at x, as after a change of what frames cost; all knots become guesses.
  void shift(double x, double residual);
  /// Keeps the curve, but lets it stand for at most so many samples.
  void doubt(double most_samples);

  static constexpr double kMostSamples = 64.0;

 private:
  struct Knot {
    float log_cost = 0.0f, samples = 0.0f;
  };
  struct Place {
    int below;     // knot
    double above;  // weight of the next one, 0 … 1
  };
  static constexpr double kOctavesPerKnot = 2.0;
  static constexpr int kKnots = 26;  // up to 2^25 visible items, and as many hidden ones

  static Place place(double x);
  int nearest(double position) const;
  /// Gives both knots of the place a value, if they have none.
  void settle(const Place& at, double log_cost);

  std::array<Knot, kKnots> knots_;
  bool empty_ = true;
};

}  // namespace sightline::culling
