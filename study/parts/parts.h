// Internal to sightline-study: subcommands about parts of the library, beside other ways to do the same.
#pragma once

#include <span>

#include "sightline/apps/bench/subcommand.h"

namespace sightline::bench {

/// The subcommands that this build has.
std::span<const Subcommand> parts();

Run add_compare(apps::CommandLine& line);
Run add_controller(apps::CommandLine& line);
Run add_measure(apps::CommandLine& line);
Run add_occlusion(apps::CommandLine& line);
Run add_recognise(apps::CommandLine& line);
Run add_views(apps::CommandLine& line);

// Built if PCRE2 is found.
Run add_tree(apps::CommandLine& line);

// Built if the C API is.
Run add_capi(apps::CommandLine& line);

// Built if Google Benchmark is found.
Run add_intersect(apps::CommandLine& line);

// Built if the ray tracer is.
Run add_calls(apps::CommandLine& line);
Run add_supersampling(apps::CommandLine& line);

// Built if the library draws.
Run add_budget(apps::CommandLine& line);
Run add_embedding(apps::CommandLine& line);
Run add_overrides(apps::CommandLine& line);
Run add_proxies(apps::CommandLine& line);
Run add_stream(apps::CommandLine& line);
Run add_transparency(apps::CommandLine& line);

}  // namespace sightline::bench
