// sightline-study: reproduces the tables and figures of three dissertations, each beside what the library does. One
// subcommand each.
#include "sightline/apps/common/command_line.h"
#include "sightline/apps/study/tables/subcommands.h"

namespace {

using namespace sightline;

constexpr bench::Subcommand kSubcommands[] = {
    {"cull", "frustum culling techniques of 2009 and before, beside production: error and time", study::add_cull},
    {"controller", "how close the hybrid culler's controller comes to the best choice of every frame",
     study::add_controller},
    {"rays", "structures and traversals of ray tracing", study::rays::add_rays},
#if SIGHTLINE_HAS_SUPERSAMPLING
    {"supersampling", "error of traced images against their time: uniform and edge-adaptive samples",
     study::add_supersampling},
#endif
#if SIGHTLINE_STUDY_HAS_GPU
    {"cull-gpu", "frustum culling techniques on the GPU: figures 5.14 and 5.15", study::add_cull_gpu},
    {"grids", "uniform grids of all sizes on CPU and GPU", study::rays::add_grids},
#endif
};

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line("The tables of three dissertations, measured beside the library", "sightline-study",
                         "  sightline-study cull --scale 0.05 --frames 30\n"
                         "  sightline-study rays --scan 100000");
  return bench::run_subcommands(line, kSubcommands, argc, argv);
}
