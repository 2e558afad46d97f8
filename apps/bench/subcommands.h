// The subcommands of sightline-bench. Each function adds the subcommand's options and examples to `line`.
#pragma once

#include "sightline/apps/bench/subcommand.h"

namespace sightline::bench {

Run add_cull(apps::CommandLine& line);
Run add_edit(apps::CommandLine& line);
Run add_import(apps::CommandLine& line);
Run add_queries(apps::CommandLine& line);
Run add_start(apps::CommandLine& line);

// Built if the ray tracer is.
Run add_scaling(apps::CommandLine& line);
Run add_trace(apps::CommandLine& line);

// Built if GL is.
Run add_contribution(apps::CommandLine& line);
Run add_error_time(apps::CommandLine& line);
Run add_frames(apps::CommandLine& line);
Run add_hybrid(apps::CommandLine& line);
Run add_lod(apps::CommandLine& line);
Run add_motion(apps::CommandLine& line);
Run add_passes(apps::CommandLine& line);
Run add_prepare(apps::CommandLine& line);

}  // namespace sightline::bench
