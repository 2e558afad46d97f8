#include "sightline/study/parts/parts.h"

namespace sightline::bench {
namespace {

constexpr Subcommand kParts[] = {
    {"controller", "how close the hybrid culler's controller comes to the best choice of every frame", add_controller},
    {"recognise", "error against time of primitives recognised in triangles", add_recognise},
#if SIGHTLINE_HAS_SUPERSAMPLING
    {"supersampling", "error of traced images against their time: uniform and edge-adaptive samples",
     add_supersampling},
#endif
#if SIGHTLINE_HAS_GL
    {"budget", "what a frame budget leaves of the image while the camera moves, and until the image is full at rest",
     add_budget},
    {"transparency", "error of blended and dithered transparency against exact sorting, and their time",
     add_transparency},
#endif
};

}  // namespace

std::span<const Subcommand> parts() {
  return kParts;
}

}  // namespace sightline::bench
