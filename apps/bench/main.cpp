// sightline-bench: speed and quality of Sightline's parts. One subcommand each.
#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"

namespace {

using namespace sightline;

constexpr bench::Subcommand kSubcommands[] = {
    {"cull", "frustum culling alone, on boxes and views from files", bench::add_cull},
    {"edit", "what edits cost, and what they leave of culling speed", bench::add_edit},
    {"import", "how fast model files are imported", bench::add_import},
    {"queries", "spatial queries through the hierarchy against a loop over all boxes", bench::add_queries},
    {"start", "how long from a model file to the first cull or image, and the memory then", bench::add_start},
#if SIGHTLINE_HAS_RAYTRACE
    {"scaling", "how stages that use several threads scale, and what more processors would bring", bench::add_scaling},
    {"trace", "rays of an image through the ray tracer, beside Embree where there is one", bench::add_trace},
#endif
#if SIGHTLINE_HAS_GL
    {"frames", "frames of a tour with and without tests beside drawing nothing but what is visible", bench::add_frames},
    {"hybrid", "frames culled by the CPU, the GPU and the hybrid, in turns: rendering off and on", bench::add_hybrid},
    {"error-time", "error of tessellated and ray-cast primitives against their run time", bench::add_error_time},
    {"contribution", "error of images without small items against the time of a frame, for several rules",
     bench::add_contribution},
    {"lod", "error of meshes drawn by levels of detail against the time of a frame, beside other ways to draw less",
     bench::add_lod},
    {"motion", "images of a moving camera within a time: error and gaps against what they take", bench::add_motion},
    {"passes", "the passes of an image on the GPU's clock, kind by kind, and how much of their work shows",
     bench::add_passes},
    {"prepare", "what is done for a frame before GL draws it, by step and by threads", bench::add_prepare},
#endif
};

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line("What Sightline's parts cost, and how well they do", "sightline-bench",
                         "  sightline-bench cull --help\n"
                         "  sightline-bench cull --generate 713000 --views views.f64 --verify");
  return bench::run_subcommands(line, kSubcommands, argc, argv);
}
