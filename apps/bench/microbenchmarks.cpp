#include "sightline/apps/bench/microbenchmarks.h"

#include <array>
#include <iostream>
#include <sstream>
#include <vector>

#include <benchmark/benchmark.h>

#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/output.h"

namespace sightline::bench {
namespace {

/// Writes the library's table and its JSON at once. The library's own way to write a file ends the process on failure.
class Reporter : public benchmark::BenchmarkReporter {
 public:
  explicit Reporter(std::ostream& table) {
    table_.SetOutputStream(&table);
    table_.SetErrorStream(&table);
    json_.SetOutputStream(&text_);
    json_.SetErrorStream(&text_);
  }
  bool ReportContext(const Context& context) override {
    return table_.ReportContext(context) && json_.ReportContext(context);
  }
  void ReportRuns(const std::vector<Run>& runs) override {
    table_.ReportRuns(runs);
    json_.ReportRuns(runs);
  }
  void Finalize() override {
    table_.Finalize();
    json_.Finalize();
  }
  std::string json() const { return text_.str(); }

 private:
  benchmark::ConsoleReporter table_{benchmark::ConsoleReporter::OO_Tabular};
  benchmark::JSONReporter json_;
  std::ostringstream text_;
};

}  // namespace

void add_microbenchmark_options(apps::CommandLine& line, MicrobenchmarkOptions& options) {
  line.add("--filter", options.filter, "Those alone whose names match this regular expression");
  line.add("--min-time", options.min_time, "Seconds that each is run for at least").in_range(1e-3, 1e3).shows_default();
  line.add("--repetitions", options.repetitions, "Of each; from 2 on with mean, median and deviation")
      .in_range(1, 1000)
      .shows_default();
  apps::add_json_option(line, options.json);
}

core::Expected<int> run_microbenchmarks(const MicrobenchmarkOptions& options) {
  std::array<std::string, 3> arguments{"sightline-bench", "--benchmark_min_time=" + std::to_string(options.min_time),
                                       "--benchmark_repetitions=" + std::to_string(options.repetitions)};
  std::array argv{arguments[0].data(), arguments[1].data(), arguments[2].data()};
  int argc = int(argv.size());
  benchmark::Initialize(&argc, argv.data());
  Reporter reporter(options.json == "-" ? std::cerr : std::cout);
  const std::size_t count = benchmark::RunSpecifiedBenchmarks(&reporter, options.filter);
  benchmark::ClearRegisteredBenchmarks();
  if (count == 0) return core::fail("--filter " + options.filter + ": matches no benchmark");
  if (!options.json.empty())
    if (auto written = apps::write_text(options.json, reporter.json()); !written)
      return tl::unexpected(written.error());
  return apps::kExitOk;
}

}  // namespace sightline::bench
