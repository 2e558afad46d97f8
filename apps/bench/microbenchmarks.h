// Times of a function over many inputs, by Google Benchmark.
#pragma once

#include <string>

#include "sightline/core/error.h"

namespace sightline::apps {
class CommandLine;
}

namespace sightline::bench {

struct MicrobenchmarkOptions {
  std::string filter = ".", json;
  double min_time = 0.5;  ///< seconds
  int repetitions = 1;
};

/// --filter, --min-time, --repetitions, --json.
void add_microbenchmark_options(apps::CommandLine& line, MicrobenchmarkOptions& options);

/// Runs everything registered with benchmark::RegisterBenchmark(), and unregisters it. Prints a table, and writes the
/// library's JSON if the options request it. Fails when the filter matches nothing.
core::Expected<int> run_microbenchmarks(const MicrobenchmarkOptions& options);

}  // namespace sightline::bench
