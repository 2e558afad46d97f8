#include "sightline/culling/hybrid/cost_table.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace sightline::culling {

CostTable::Place CostTable::place(double x) {
  const double position = std::clamp(x / kOctavesPerKnot, 0.0, double(kKnots - 1));
  const int below = std::min(int(position), kKnots - 2);
  return {below, position - below};
}

int CostTable::nearest(double position) const {
  int best = -1;
  for (int i = 0; i < kKnots; ++i)
    if (knots_[std::size_t(i)].samples > 0.0f && (best < 0 || std::abs(i - position) < std::abs(best - position)))
      best = i;
  return best;
}

double CostTable::predict(double x) const {
  const Place at = place(x);
  const Knot& below = knots_[std::size_t(at.below)];
  const Knot& above = knots_[std::size_t(at.below) + 1];
  if (below.samples > 0.0f && above.samples > 0.0f)
    return double(below.log_cost) + at.above * (double(above.log_cost) - double(below.log_cost));
  return double(knots_[std::size_t(nearest(at.below + at.above))].log_cost);
}

double CostTable::samples(double x) const {
  if (empty_) return 0.0;
  const Place at = place(x);
  const Knot& below = knots_[std::size_t(at.below)];
  const Knot& above = knots_[std::size_t(at.below) + 1];
  if (below.samples > 0.0f && above.samples > 0.0f)
    return double(below.samples) + at.above * (double(above.samples) - double(below.samples));
  const double away = distance(x);
  return double(knots_[std::size_t(nearest(at.below + at.above))].samples) / ((1.0 + away) * (1.0 + away));
}

double CostTable::distance(double x) const {
  const Place at = place(x);
  const double position = at.below + at.above;
  return kOctavesPerKnot * std::max(0.0, std::abs(nearest(position) - position) - 1.0);
}

void CostTable::settle(const Place& at, double log_cost) {
  for (int i = at.below; i <= at.below + 1; ++i)
    if (knots_[std::size_t(i)].samples == 0.0f) knots_[std::size_t(i)].log_cost = float(log_cost);
  empty_ = false;
}

void CostTable::learn(double x, double residual) {
  const Place at = place(x);
  const double known = samples(x);
  settle(at, empty_ ? 0.0 : predict(x));
  // Normalised least mean squares over the two knots.
  const double weights[2] = {1.0 - at.above, at.above};
  const double norm = weights[0] * weights[0] + weights[1] * weights[1];
  const double rate = std::max(1.0 / (known + 1.0), 1.0 / kMostSamples);
  for (int i = 0; i < 2; ++i) {
    Knot& knot = knots_[std::size_t(at.below) + std::size_t(i)];
    knot.log_cost += float(rate * residual * (known > 0.0 ? weights[i] / norm : 1.0));
    knot.samples = std::min(float(kMostSamples), knot.samples + float(std::max(weights[i] / norm, 1e-3)));
  }
}

void CostTable::shift(double x, double residual) {
  const Place at = place(x);
  settle(at, predict(x));
  doubt(2.0);
  for (int i = at.below; i <= at.below + 1; ++i) {
    knots_[std::size_t(i)].log_cost += float(residual);
    knots_[std::size_t(i)].samples = 2.0f;
  }
}

void CostTable::doubt(double most_samples) {
  for (Knot& knot : knots_) knot.samples = std::min(knot.samples, float(most_samples));
}

}  // namespace sightline::culling
