// Summaries of measured times and other samples.
#pragma once

#include <vector>

#include "sightline/importers/json/internal/json.h"

namespace sightline::apps {

/// For an even number of samples, the mean of the middle two. 0 for none.
double median(std::vector<double> samples);

/// Nearest-rank percentile: the least sample such that at least `share` (0 … 1) of all are not above it. 0 for none.
double percentile(std::vector<double> samples, double share);

struct Summary {
  double mean = 0.0, median = 0.0, p99 = 0.0, max = 0.0;
};

/// Summarises any number of samples; all zero for none.
Summary summarise(const std::vector<double>& samples);

json::Value to_json(const Summary& s);

}  // namespace sightline::apps
