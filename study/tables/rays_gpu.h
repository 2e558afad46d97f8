// The subcommand rays on the GPU (--gpu), and the subcommand grids.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "sightline/core/error.h"
#include "sightline/gl/context.h"
#include "sightline/study/rays/benchmark.h"

namespace sightline::apps {
class CommandLine;
}

namespace sightline::study {

/// Adds to benchmarks what the traversals take in GLSL.
class RaysOnGpu {
 public:
  explicit RaysOnGpu(int passes) : passes_(passes) {}

  /// Makes a context, and prints its name if wanted.
  core::Expected<void> begin(bool print);
  /// A rays::BenchmarkHook. What does not fit the GPU is left out, with a line on stderr.
  void run(const rays::Structures& structures, const rays::BenchmarkRays& searched, rays::Benchmark& benchmark);
  const core::Expected<void>& done() const { return done_; }  ///< the last run's error, if it failed

 private:
  int passes_;
  std::optional<gl::Context> context_;
  core::Expected<void> done_;
};

void print_gpu(const rays::Benchmark& benchmark);
/// rays_glsl.csv. The directory must exist.
core::Expected<void> write_gpu_csv(const std::vector<rays::Benchmark>& all, const std::filesystem::path& directory);

/// Adds the options of the subcommand grids to `line`, and returns what runs it: an exit code, or an error.
std::function<core::Expected<int>()> add_grids(apps::CommandLine& line);

}  // namespace sightline::study
