#include "sightline/apps/common/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sightline::apps {

Summary summarise(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const auto rank = [&](double share) {
    const auto i = std::size_t(std::ceil(share * double(samples.size())));
    return samples[std::clamp<std::size_t>(i, 1, samples.size()) - 1];
  };
  return {std::accumulate(samples.begin(), samples.end(), 0.0) / double(samples.size()), rank(0.5), rank(0.99),
          samples.back()};
}

}  // namespace sightline::apps
