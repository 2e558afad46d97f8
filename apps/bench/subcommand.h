// A subcommand of sightline-bench or sightline-study: its name, help and options.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sightline/apps/common/command_line.h"
#include "sightline/apps/common/output.h"
#include "sightline/core/error.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench {

/// Runs after the options are parsed; returns the program's exit code.
using Run = std::function<core::Expected<int>()>;

/// Name, description, and what adds the options and examples to the line of the subcommand.
struct Subcommand {
  const char *name, *description;
  Run (*add)(apps::CommandLine&);
};

/// Implements Subcommand::add: the options live as long as the parser and the run.
template <class Options>
Run add_subcommand(apps::CommandLine& line, void (*add_options)(apps::CommandLine&, Options&),
                   core::Expected<int> (*run)(const Options&)) {
  const auto options = std::make_shared<Options>();
  add_options(line, *options);
  return [options, run] { return run(*options); };
}

/// Parses the command line and runs the subcommand that it names. Returns the program's exit code.
inline int run_subcommands(apps::CommandLine& line, std::span<const Subcommand> all, int argc, char** argv) {
  line.require_subcommand();
  std::vector<std::pair<apps::CommandLine, Run>> subcommands;
  for (const auto& [name, description, add] : all) {
    apps::CommandLine subcommand = line.subcommand(name, description);
    subcommands.emplace_back(subcommand, add(subcommand));
  }
  return line.run(argc, argv, [&]() -> core::Expected<int> {
    for (const auto& [subcommand, run] : subcommands)
      if (subcommand.chosen()) return run();
    return core::fail("no subcommand");
  });
}

/// End of a run: writes its figures to the file of --json.
inline core::Expected<int> finish(const std::string& json_file, const json::Value& json) {
  if (auto written = apps::write_json(json_file, json); !written) return tl::unexpected(written.error());
  return apps::kExitOk;
}

/// Writes the JSON after print_table(json, stream), whose table is not part of it.
template <class Print>
core::Expected<int> finish(const std::string& json_file, const json::Value& json, const Print& print_table) {
  print_table(json, apps::table_stream(json_file));
  return finish(json_file, json);
}

}  // namespace sightline::bench
