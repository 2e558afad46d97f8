// Internal to sightline-study: subcommands about parts of the library, beside other ways to do the same.
#pragma once

#include <span>

#include "sightline/apps/bench/subcommand.h"

namespace sightline::bench {

/// The subcommands that this build has.
std::span<const Subcommand> parts();

Run add_controller(apps::CommandLine& line);
Run add_recognise(apps::CommandLine& line);

// Built if the ray tracer and images are.
Run add_supersampling(apps::CommandLine& line);

// Built if the library draws.
Run add_budget(apps::CommandLine& line);
Run add_transparency(apps::CommandLine& line);

}  // namespace sightline::bench
