// The subcommands of sightline-bench. Each function adds the subcommand's options and examples to `line`.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/output.h"
#include "sightline/core/error.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench {

/// Runs after the options are parsed; returns the program's exit code.
using Run = std::function<core::Expected<int>()>;

Run add_controller(apps::CommandLine& line);
Run add_cull(apps::CommandLine& line);
Run add_edit(apps::CommandLine& line);
Run add_import(apps::CommandLine& line);
Run add_start(apps::CommandLine& line);
Run add_compare(apps::CommandLine& line);
Run add_measure(apps::CommandLine& line);
Run add_occlusion(apps::CommandLine& line);
Run add_recognise(apps::CommandLine& line);
Run add_views(apps::CommandLine& line);

// Built if the C API is.
Run add_capi(apps::CommandLine& line);

// Built if the ray tracer is.
Run add_calls(apps::CommandLine& line);
Run add_scaling(apps::CommandLine& line);
Run add_trace(apps::CommandLine& line);

// Built if Google Benchmark is found.
Run add_intersect(apps::CommandLine& line);
Run add_queries(apps::CommandLine& line);

// Built if the ray tracer and pictures are.
Run add_supersampling(apps::CommandLine& line);

// Built if GL is.
Run add_budget(apps::CommandLine& line);
Run add_context(apps::CommandLine& line);
Run add_contribution(apps::CommandLine& line);
Run add_embedding(apps::CommandLine& line);
Run add_error_time(apps::CommandLine& line);
Run add_gpu_cull(apps::CommandLine& line);
Run add_hybrid(apps::CommandLine& line);
Run add_limit(apps::CommandLine& line);
Run add_overrides(apps::CommandLine& line);
Run add_proxies(apps::CommandLine& line);
Run add_stream(apps::CommandLine& line);
Run add_transparency(apps::CommandLine& line);

// Built if the viewer is.
Run add_tree(apps::CommandLine& line);

/// Implements such a function: the options live as long as the parser and the run.
template <class Options>
Run add_subcommand(apps::CommandLine& line, void (*add_options)(apps::CommandLine&, Options&),
                   core::Expected<int> (*run)(const Options&)) {
  const auto options = std::make_shared<Options>();
  add_options(line, *options);
  return [options, run] { return run(*options); };
}

/// End of a run: writes its figures to the file of --json.
inline core::Expected<int> finish(const std::string& json_file, const json::Value& json) {
  if (auto written = apps::write_json(json_file, json); !written) return tl::unexpected(written.error());
  return apps::kExitOk;
}

/// The same after print_table(json, stream), where the table does not get into the JSON.
template <class Print>
core::Expected<int> finish(const std::string& json_file, const json::Value& json, const Print& print_table) {
  print_table(json, apps::table_stream(json_file));
  return finish(json_file, json);
}

}  // namespace sightline::bench
