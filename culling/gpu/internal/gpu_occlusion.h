// Occlusion on the GPU: the pyramid of a depth texture, and what its tests are told. Internal to culling/gpu.
#pragma once

#include <array>
#include <cstdint>

#include "sightline/core/view.h"
#include "sightline/culling/gpu/internal/gpu_bounds.h"
#include "sightline/culling/occlusion/occlusion_test.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/texture.h"

namespace sightline::culling {

/// OcclusionBlock of occlusion_test.glsl (std140).
struct OcclusionBlock {
  std::uint32_t levels[kMaxLevels][4];
  std::int32_t level_count;
  float error;
  std::uint32_t this_frame, unused;
};
static_assert(sizeof(OcclusionBlock) == 16 * (kMaxLevels + 1));

/// The twin of DepthPyramid: the same levels, of the same sizes, in one buffer.
class GpuDepthPyramid {
 public:
  static core::Expected<GpuDepthPyramid> create(const gl::Functions& gl);
  static std::vector<gl::PipelineDescription> all_programs();

  /// Builds the pyramid of a reverse-Z depth texture that `view` was drawn with, one sample per pixel. Submits the work
  /// and returns. Changes the program, texture unit 0 and storage block 0. Fails when the GPU has too little memory.
  core::Expected<void> build(const gl::Texture2D& depth, const core::View& view);

  /// R32F; the levels say where in it each begins. 3.4e38 where nothing is drawn.
  const gl::TextureBuffer& texels() const { return array_.texels; }
  const gl::Buffer& buffer() const { return array_.buffer; }
  std::span<const DepthPyramid::Level> levels() const { return levels_; }
  std::size_t memory_bytes() const { return array_.buffer.size(); }

 private:
  core::Expected<void> resize(int width, int height);

  const gl::Functions* gl_ = nullptr;
  gl::Program pixels_, blocks_;  // the first level, and each other one
  gl::TexelArray array_;
  std::vector<DepthPyramid::Level> levels_;
};

}  // namespace sightline::culling
