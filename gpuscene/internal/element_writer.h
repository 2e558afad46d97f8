// Writes scattered elements of a buffer without a GL call for each. Internal to gpuscene and culling/gpu.
#pragma once

#include <cstdint>
#include <span>

#include "sightline/gl/context.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/program.h"

namespace sightline::gpuscene {

class ElementWriter {
 public:
  ElementWriter() = default;
  explicit ElementWriter(const gl::Context& context)
      : gl_(&context.functions()), largest_block_(std::size_t(context.capabilities().max_storage_block_bytes)) {}

  /// Element i of `data`, `bytes` long, goes to place `places[i]` of `buffer`, which holds such elements from its
  /// begin. Places rise; `bytes` is a multiple of 4. Up to kMostRuns runs of neighbours are written one by one. More
  /// are uploaded together, and a compute shader, compiled for the first such call, puts them in their places; that
  /// leaves changed: program, shader storage blocks 0 to 2. Where that cannot be had (storage blocks too small, no
  /// memory) they are written one by one, too.
  void write(const gl::Buffer& buffer, std::size_t bytes, std::span<const std::uint32_t> places, const void* data);

  static constexpr std::size_t kMostRuns = 32;

 private:
  bool scatter(const gl::Buffer& buffer, std::size_t bytes, std::span<const std::uint32_t> places, const void* data);
  const gl::Program* prepare(bool wide);  ///< null where it cannot be had

  const gl::Functions* gl_ = nullptr;
  std::size_t largest_block_ = 0;
  gl::Program programs_[2];  // words of 4 bytes, of 16
};

}  // namespace sightline::gpuscene
