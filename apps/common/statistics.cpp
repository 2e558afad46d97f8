#include "sightline/apps/common/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sightline::apps {

double median(std::vector<double> samples) {
  if (samples.empty()) return 0.0;
  const auto middle = samples.begin() + std::ptrdiff_t(samples.size() / 2);
  std::nth_element(samples.begin(), middle, samples.end());
  if (samples.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(samples.begin(), middle));
}

double percentile(std::vector<double> samples, double share) {
  if (samples.empty()) return 0.0;
  const auto rank = std::size_t(std::ceil(share * double(samples.size())));
  const auto at = samples.begin() + std::ptrdiff_t(std::clamp<std::size_t>(rank, 1, samples.size()) - 1);
  std::nth_element(samples.begin(), at, samples.end());
  return *at;
}

Summary summarise(const std::vector<double>& samples) {
  if (samples.empty()) return {};
  return {std::accumulate(samples.begin(), samples.end(), 0.0) / double(samples.size()), median(samples),
          percentile(samples, 0.99), *std::max_element(samples.begin(), samples.end())};
}

json::Value to_json(const Summary& s) {
  return {{"mean", s.mean}, {"median", s.median}, {"p99", s.p99}, {"max", s.max}};
}

}  // namespace sightline::apps
