// sightline-bench: speed and quality of Sightline's parts. One subcommand each.
#include <utility>
#include <vector>

#include "sightline/apps/bench/subcommands.h"
#include "sightline/apps/common/command_line.h"

namespace {

using namespace sightline;

struct Subcommand {
  const char *name, *description;
  bench::Run (*add)(apps::CommandLine&);
};

constexpr Subcommand kSubcommands[] = {
    {"cull", "frustum culling alone, on boxes and views from files", bench::add_cull},
    {"views", "what several views at once, section planes and layers cost the culler", bench::add_views},
    {"edit", "what edits cost, and what they leave of culling speed", bench::add_edit},
    {"controller", "how close the hybrid culler's controller comes to the best choice of every frame",
     bench::add_controller},
    {"occlusion", "occlusion culling without a renderer: occluder raster and test", bench::add_occlusion},
    {"import", "how fast model files are imported", bench::add_import},
    {"recognise", "error against time of primitives recognised in triangles", bench::add_recognise},
    {"start", "how long from a model file to the first cull or picture, and the memory then", bench::add_start},
    {"compare", "what it takes to tell two revisions of a plant apart", bench::add_compare},
    {"measure", "what a distance between two items and a snap cost", bench::add_measure},
#if SIGHTLINE_HAS_CAPI
    {"capi", "what calls cost through the C API beside the same calls in C++", bench::add_capi},
#endif
#if SIGHTLINE_HAS_RAYTRACE
    {"calls", "what calls take that do little: a frame that is only culled, a pick, a query of boxes",
     bench::add_calls},
    {"scaling", "how stages that use several threads scale, and what more processors would bring", bench::add_scaling},
    {"trace", "rays of a picture through the ray tracer, beside Embree where there is one", bench::add_trace},
#endif
#if SIGHTLINE_HAS_GOOGLE_BENCHMARK
    {"queries", "spatial queries through the hierarchy against a loop over all boxes", bench::add_queries},
    {"intersect", "what a ray against one analytic primitive costs on the CPU", bench::add_intersect},
#endif
#if SIGHTLINE_HAS_SUPERSAMPLING
    {"supersampling", "error of traced pictures against their time: uniform and edge-adaptive samples",
     bench::add_supersampling},
#endif
#if SIGHTLINE_HAS_GL
    {"context", "what a context without a window offers: driver, limits, extensions", bench::add_context},
    {"gpu-cull", "the forms of the GPU culler against each other", bench::add_gpu_cull},
    {"limit", "frames of a tour beside drawing nothing but what owns a pixel", bench::add_limit},
    {"hybrid", "frames culled by the CPU, the GPU and the hybrid, in turns: rendering off and on", bench::add_hybrid},
    {"embedding", "what frames cost more in the context of an application", bench::add_embedding},
    {"error-time", "error of tessellated and ray-cast primitives against their run time", bench::add_error_time},
    {"contribution", "error of pictures without small items against the time of a frame, for several rules",
     bench::add_contribution},
    {"budget",
     "what a frame budget leaves of the picture while the camera moves, and until the picture is full at rest",
     bench::add_budget},
    {"overrides", "what it costs to override or hide items of a model", bench::add_overrides},
    {"stream", "what the worst frame takes while meshes come and go", bench::add_stream},
    {"proxies", "pixels that ray-cast primitives run shaders for, beside those they show", bench::add_proxies},
    {"transparency", "error of blended and dithered transparency against exact sorting, and their time",
     bench::add_transparency},
#endif
#if SIGHTLINE_HAS_VIEW_MODEL
    {"tree", "what the viewer's tree panel and search take per operation", bench::add_tree},
#endif
};

}  // namespace

int main(int argc, char** argv) {
  apps::CommandLine line("What Sightline's parts cost, and how well they do", "sightline-bench",
                         "  sightline-bench cull --help\n"
                         "  sightline-bench cull --generate 713000 --views views.f64 --verify");
  line.require_subcommand();
  std::vector<std::pair<apps::CommandLine, bench::Run>> subcommands;
  for (const auto& [name, description, add] : kSubcommands) {
    apps::CommandLine subcommand = line.subcommand(name, description);
    subcommands.emplace_back(subcommand, add(subcommand));
  }
  return line.run(argc, argv, [&]() -> core::Expected<int> {
    for (const auto& [subcommand, run] : subcommands)
      if (subcommand.chosen()) return run();
    return core::fail("no subcommand");
  });
}
