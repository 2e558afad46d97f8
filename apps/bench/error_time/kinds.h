// The cost and the errors of one kind of primitive, as triangles and as the engine's ray-cast GLSL.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/apps/bench/error_time/field.h"
#include "sightline/gl/context.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench {

struct KindConfig {
  int width = 640, height = 480;  ///< of the timed frames, pixels
  int samples = 3;                ///< samples per pixel and axis for errors
  int passes = 7;                 ///< number of timed passes; their median counts
  std::uint32_t seed = 1;
  std::vector<int> segments;  ///< of triangles, per full circle
};

/// Measures random items of a kind (the seed gives shape and orientation) in perspective. The context must be current.
/// A row for each form, as bench/error_time/comparison.h has them: "ms" a frame, "bytes_per_item" on the GPU, and
/// against the C++ intersections in double over all images "depth" (relative), "normal" (degrees), "silhouette"
/// (pixels), "hits", which are samples that the reference hits, and "wrong", samples where only one of both hits.
json::Value measure_kind(const gl::Context& context, core::Kind kind, const FieldSize& size, const KindConfig& config);

}  // namespace sightline::bench
