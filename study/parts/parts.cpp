#include "sightline/study/parts/parts.h"

namespace sightline::bench {
namespace {

constexpr Subcommand kParts[] = {
    {"views", "what several views at once, section planes and layers cost the culler", add_views},
    {"controller", "how close the hybrid culler's controller comes to the best choice of every frame", add_controller},
    {"occlusion", "occlusion culling without a renderer: occluder raster and test", add_occlusion},
    {"recognise", "error against time of primitives recognised in triangles", add_recognise},
    {"compare", "what it takes to tell two revisions of a plant apart", add_compare},
    {"measure", "what a distance between two items and a snap cost", add_measure},
#if SIGHTLINE_HAS_PCRE2
    {"tree", "what the viewer's tree panel and search take per operation", add_tree},
#endif
#if SIGHTLINE_HAS_CAPI
    {"capi", "what calls cost through the C API beside the same calls in C++", add_capi},
#endif
#if SIGHTLINE_HAS_GOOGLE_BENCHMARK
    {"intersect", "what a ray against one analytic primitive costs on the CPU", add_intersect},
#endif
#if SIGHTLINE_HAS_RAYTRACE
    {"calls", "what calls take that do little: a frame that is only culled, a pick, a query of boxes", add_calls},
#endif
#if SIGHTLINE_HAS_SUPERSAMPLING
    {"supersampling", "error of traced images against their time: uniform and edge-adaptive samples",
     add_supersampling},
#endif
#if SIGHTLINE_HAS_GL
    {"embedding", "what frames cost more in the context of an application", add_embedding},
    {"budget", "what a frame budget leaves of the image while the camera moves, and until the image is full at rest",
     add_budget},
    {"overrides", "what it costs to override or hide items of a model", add_overrides},
    {"stream", "what the worst frame takes while meshes come and go", add_stream},
    {"proxies", "pixels that ray-cast primitives run shaders for, beside those they show", add_proxies},
    {"transparency", "error of blended and dithered transparency against exact sorting, and their time",
     add_transparency},
#endif
};

}  // namespace

std::span<const Subcommand> parts() {
  return kParts;
}

}  // namespace sightline::bench
