// Rays in GPU memory, and what a search answered.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/apps/study/rays/triangle_set.h"
#include "sightline/core/error.h"
#include "sightline/gl/context.h"
#include "sightline/gl/internal/buffer.h"

namespace sightline::study::rays {

/// As the shaders write it.
struct GpuAnswer {
  double t;
  std::uint32_t triangle;          ///< core::kNone: no hit, and t means nothing
  std::uint32_t nodes, triangles;  ///< Counters, where they were wanted
  std::uint32_t unused;

  Hit hit() const { return triangle == core::kNone ? Hit{} : Hit{t, triangle}; }
};

/// Rays made ready on the CPU: there every division rounds as IEEE 754 has it, which GL does not promise, so a ray is
/// the same in both. Each is made ready once for all traversals; those that hit nothing by definition are marked.
class RayBatch {
 public:
  /// Rays of an image, row by row, `width` (>= 1) each; the last row may be shorter. Of a batch without image any
  /// width serves. Split where one storage block cannot hold all. Fails when the GPU has not the memory.
  static core::Expected<RayBatch> create(const gl::Context& context, const TriangleSet& triangles,
                                         std::span<const Ray> rays, std::uint32_t width = 1024);

  struct Part {  ///< whole rows
    gl::Buffer rays, answers;
    std::uint32_t count = 0;
  };
  const std::vector<Part>& parts() const { return parts_; }
  std::uint32_t width() const { return width_; }
  std::size_t size() const;

  /// The last search's, in the order of the rays. Waits for the GPU.
  std::vector<GpuAnswer> read() const;

 private:
  std::vector<Part> parts_;
  std::uint32_t width_ = 1;
};

}  // namespace sightline::study::rays
