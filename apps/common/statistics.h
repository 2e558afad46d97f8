// Summaries of measured times.
#pragma once

#include <vector>

namespace sightline::apps {

struct Summary {
  double mean = 0.0, median = 0.0, p99 = 0.0, max = 0.0;
};

/// Of any number of samples; all zero for none. Percentiles are nearest-rank.
Summary summarise(std::vector<double> samples);

}  // namespace sightline::apps
