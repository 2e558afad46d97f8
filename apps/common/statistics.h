// Summaries of measured times.
#pragma once

#include <vector>

namespace sightline::apps {

struct Summary {
  double mean = 0.0, median = 0.0, p99 = 0.0, max = 0.0;
};

/// Of any number of samples; all zero for none. Percentiles are nearest-rank.
Summary summarise(std::vector<double> samples);

template <class Json>
Json to_json(const Summary& s) {
  return {{"mean", s.mean}, {"median", s.median}, {"p99", s.p99}, {"max", s.max}};
}

}  // namespace sightline::apps
