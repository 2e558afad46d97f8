// The sixteen traversals in GLSL compute shaders. They do what those of traversals.h do, operation by operation: a ray
// finds the same hit bit for bit, and visits the same nodes.
//
// Two things GL leaves to the driver, on which this depends: that the one division of the triangle test rounds
// correctly (else hits differ by units in the last place, and ties may go to another triangle), and that subnormal
// floats are kept (else counts may differ). Everything else is exact by the language's `precise`. And llvmpipe leaves
// every loop once those of an invocation have gone round 65,535 times in all: no ray may need more.
#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "sightline/apps/study/rays/gpu/ray_batch.h"
#include "sightline/apps/study/rays/gpu/structures.h"
#include "sightline/core/error.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/program.h"

namespace sightline::study::rays {

enum class Ask : std::uint8_t { kNearest, kAny, kCount };  ///< as Traversal's three functions
inline constexpr std::size_t kAsks = 3;

/// How rays go to work groups of 32 invocations, the size of a warp.
struct Launch {
  bool tiles = false;  ///< 8 x 4 rays of the image to a group, instead of 32 of a row
  /// Persistent threads: that many groups take one tile after the other from a counter. 0: a group for each tile. On
  /// software rasterisers, which run one group after the other, a group ends after a few tiles for the sake of
  /// llvmpipe's loops, and there are more groups.
  std::uint32_t persistent_groups = 0;
};

/// Compiles the program of a traversal when it is first wanted, and keeps it. Any structure of its kind serves.
class GpuTracer {
 public:
  /// Borrows the context, which must be current at every call.
  explicit GpuTracer(const gl::Context& context) : context_(&context) {}
  static std::vector<gl::PipelineDescription> all_programs();

  /// Searches for each ray of the batch, which then has the answers. `structure` is of the kind that the traversal
  /// wants, and of `triangles`. Does not wait for the GPU. Fails where the program does not compile, with the driver's
  /// log.
  core::Expected<void> trace(const Traversal& traversal, Ask ask, const GpuTriangles& triangles,
                             const GpuStructure& structure, const RayBatch& batch, const Launch& launch = {});

 private:
  struct Program {
    gl::Program program;
    GLint image, tile, ray_count, most_tiles;
  };
  core::Expected<const Program*> program_of(const Traversal& traversal, Ask ask, bool persistent);

  const gl::Context* context_;
  std::map<std::tuple<const char*, Ask, bool>, Program> programs_;  // by Traversal::name
  gl::Buffer next_tile_;
};

}  // namespace sightline::study::rays
