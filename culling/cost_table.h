// What a path costs against the number of visible items, learnt from samples.
#pragma once

#include <array>

namespace sightline::culling {

/// A piecewise-linear curve of log(cost) over log2(1 + visible), one knot per octave: power laws are exact, and the
/// CPU's cost, which rises with what is visible and falls again where whole subtrees are inside, is followed. Each knot
/// knows how many samples it stands for; where there are none, the nearest knot speaks.
class CostTable {
 public:
  /// log(cost) at a number of visible items, >= 0. Precondition: !empty().
  double predict(double visible) const;
  /// How many samples the prediction rests on, 0 … kMostSamples; less where they are octaves away.
  double samples(double visible) const;
  /// How many octaves of visible items lie between the prediction and what it rests on; 0 where it was learnt.
  double octaves_away(double visible) const;
  bool empty() const { return empty_; }

  /// Moves the curve towards a sample `residual` above predict(visible) by the share that a running mean would: the
  /// first sample wholly, the n-th by 1/n, later ones by 1/kMostSamples. Into an empty table, residual is log(cost).
  void learn(double visible, double residual);
  /// Moves the curve by `residual` at `visible`, as after a change of what frames cost; all knots become guesses.
  void shift(double visible, double residual);
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
  static constexpr int kKnots = 26;  // up to 2^25 items

  static Place place(double visible);
  int nearest(double position) const;
  /// Gives both knots of the place a value, if they have none.
  void settle(const Place& at, double log_cost);

  std::array<Knot, kKnots> knots_;
  bool empty_ = true;
};

}  // namespace sightline::culling
