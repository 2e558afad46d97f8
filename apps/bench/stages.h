// How stages of work scale with threads. Shared by subcommands.
//
// Each stage runs with 1, 2, 4 … threads, interleaved; the least wall time counts, with the processor time of that
// pass. Amdahl's law, T(n) = T(1) (s + (1 - s) / n), is fitted by least squares over all n: s is the serial share. From
// it follows what more processors would bring at best. (G. M. Amdahl, "Validity of the single processor approach to
// achieving large scale computing capabilities", 1967.) Processor time that grows with the threads is what they wait
// for one another or for memory; the fit counts that as serial, too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/model.h"
#include "sightline/core/error.h"

namespace sightline::bench {

/// Something that `run` does with a number of threads.
struct TimedStage {
  std::string name;
  std::function<void(int threads)> run;
  int count = 1;  ///< of the times that it does so; figures are of one
};

struct StageOptions {
  apps::ModelOptions model;
  std::uint64_t items = 1'000'000;
  int threads = 0, passes = 5;
  std::string json;
};
void add_stage_options(apps::CommandLine& line, StageOptions& o);

/// Times the stages and writes a row for each. `items`: of the scene.
core::Expected<int> report_stages(std::span<const TimedStage> stages, std::size_t items, const StageOptions& options);

}  // namespace sightline::bench
