// The subcommands of sightline-bench. Each function adds the subcommand's options and examples to `app`.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "sightline/apps/common/cli.h"
#include "sightline/core/error.h"

namespace sightline::bench {

/// Runs after the options are parsed; returns the program's exit code.
using Run = std::function<core::Expected<int>()>;

Run add_controller(CLI::App& app);
Run add_cull(CLI::App& app);
Run add_edit(CLI::App& app);
Run add_import(CLI::App& app);
Run add_start(CLI::App& app);
Run add_compare(CLI::App& app);
Run add_measure(CLI::App& app);
Run add_occlusion(CLI::App& app);
Run add_recognise(CLI::App& app);
Run add_views(CLI::App& app);

// Built if the C API is.
Run add_capi(CLI::App& app);

// Built if the ray tracer is.
Run add_calls(CLI::App& app);
Run add_scaling(CLI::App& app);
Run add_trace(CLI::App& app);

// Built if Google Benchmark is found.
Run add_intersect(CLI::App& app);
Run add_queries(CLI::App& app);

// Built if the ray tracer and pictures are.
Run add_supersampling(CLI::App& app);

// Built if GL is.
Run add_budget(CLI::App& app);
Run add_contribution(CLI::App& app);
Run add_embedding(CLI::App& app);
Run add_error_time(CLI::App& app);
Run add_gpu_cull(CLI::App& app);
Run add_hybrid(CLI::App& app);
Run add_limit(CLI::App& app);
Run add_overrides(CLI::App& app);
Run add_proxies(CLI::App& app);
Run add_transparency(CLI::App& app);

// Built if the viewer is.
Run add_tree(CLI::App& app);

/// Implements such a function: the options live as long as the parser and the run.
template <class Options>
Run add_subcommand(CLI::App& app, void (*add_options)(CLI::App&, Options&),
                   core::Expected<int> (*run)(const Options&)) {
  const auto options = std::make_shared<Options>();
  add_options(app, *options);
  return [options, run] { return run(*options); };
}

/// End of a run: writes its figures to the file of --json.
template <class Json>
core::Expected<int> finish(const std::string& json_file, const Json& json) {
  if (auto written = apps::write_json(json_file, json); !written) return tl::unexpected(written.error());
  return apps::kExitOk;
}

/// The same after print_table(json, stream), where the table does not get into the JSON.
template <class Json, class Print>
core::Expected<int> finish(const std::string& json_file, const Json& json, const Print& print_table) {
  print_table(json, apps::table_stream(json_file));
  return finish(json_file, json);
}

}  // namespace sightline::bench
