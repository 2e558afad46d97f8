// The subcommands of sightline-study. Each function adds the subcommand's options and examples to `line`.
#pragma once

#include "sightline/apps/bench/subcommand.h"

namespace sightline::study {

bench::Run add_controller(apps::CommandLine& line);
bench::Run add_cull(apps::CommandLine& line);
namespace rays {
bench::Run add_rays(apps::CommandLine& line);
}

// Built if the ray tracer and images are.
bench::Run add_supersampling(apps::CommandLine& line);

// Built with STUDY_GPU.
bench::Run add_cull_gpu(apps::CommandLine& line);
namespace rays {
bench::Run add_grids(apps::CommandLine& line);
}

}  // namespace sightline::study
