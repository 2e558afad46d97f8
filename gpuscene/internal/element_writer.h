// Writes scattered elements of a buffer without a GL call for each. Internal to gpuscene and culling/gpu.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/gl/context.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/program.h"

namespace sightline::gpuscene {

class ElementWriter {
 public:
  ElementWriter() = default;
  explicit ElementWriter(const gl::Context& context)
      : gl_(&context.functions()), largest_block_(std::size_t(context.capabilities().max_storage_block_bytes)) {}

  /// Writes element i of `data`, `bytes` long, to place `places[i]` of `buffer`, an array of such elements. Places must
  /// rise; `bytes` must be a multiple of 4. Writes up to kMostRuns runs of neighbours with one GL call each. More runs
  /// are uploaded together, and a compute shader puts them in their places; the first such call compiles it. That
  /// changes: program, shader storage blocks 0 to 2. If this is not possible (storage blocks too small, no memory), the
  /// runs are written one by one.
  void write(const gl::Buffer& buffer, std::size_t bytes, std::span<const std::uint32_t> places, const void* data);

  static constexpr std::size_t kMostRuns = 32;

  static std::vector<gl::PipelineDescription> all_programs();

 private:
  bool scatter(const gl::Buffer& buffer, std::size_t bytes, std::span<const std::uint32_t> places, const void* data);
  const gl::Program* prepare(bool wide);  ///< null when it cannot be compiled

  const gl::Functions* gl_ = nullptr;
  std::size_t largest_block_ = 0;
  gl::Program programs_[2];  // for words of 4 bytes, of 16 bytes
};

}  // namespace sightline::gpuscene
