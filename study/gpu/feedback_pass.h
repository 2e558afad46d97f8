// Points through a program with the rasteriser off, and what came of them read back: how one computed on a GPU before
// compute shaders.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/query.h"
#include "sightline/gl/internal/transform_feedback.h"
#include "sightline/gl/internal/vertex_array.h"

namespace sightline::study {

/// A program of the study's shaders and of those in culling/gpu, without stages and varyings.
gl::ProgramDescription describe_feedback(std::string name, std::vector<std::string> defines = {});

class FeedbackPass {
 public:
  /// Room for `capacity` > 0 records of `record_bytes`, a multiple of 4. Fails with the driver's log, or when the GPU
  /// has not the memory.
  static core::Expected<FeedbackPass> create(const gl::Functions& gl, const gl::ProgramDescription& description,
                                             std::size_t record_bytes, std::size_t capacity);

  /// One vertex for each of `points`, without attributes. Submits and returns. Textures are the caller's. Leaves
  /// changed: program, vertex array, framebuffer.
  void run(std::uint32_t points) const;
  /// Records of the last run. Waits for the GPU.
  std::uint32_t written() const { return written_.result(); }
  /// Copies the first `count` records. Waits for the GPU.
  void read(std::size_t count, void* records) const { output_.read(0, count * record_bytes_, records); }

  const gl::Buffer& output() const { return output_; }

 private:
  const gl::Functions* gl_ = nullptr;
  std::size_t record_bytes_ = 0;
  gl::Program program_;
  gl::Buffer output_;
  gl::VertexArray array_;
  gl::Framebuffer framebuffer_;  // draws need one in a context without a surface
  gl::TransformFeedback feedback_;
  gl::Query written_;
};

}  // namespace sightline::study
