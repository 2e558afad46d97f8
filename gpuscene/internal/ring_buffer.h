// A buffer that the CPU writes anew for each frame. Internal to gpuscene.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "sightline/gl/internal/buffer.h"

namespace sightline::gpuscene {

/// Frames in flight use one region each, in turn, so that no upload waits until the GPU has finished reading.
template <class Element>
class RingBuffer {
 public:
  /// `what` names the contents, as in gl::Buffer::create(). Regions hold at least so many elements; when they grow,
  /// they get so many halves of what is needed then.
  RingBuffer(const char* what, std::size_t least, std::size_t halves) : what_(what), least_(least), halves_(halves) {}

  /// Makes each region hold so many elements. Where they did not, the buffer is another one without contents, and the
  /// result is true.
  core::Expected<bool> reserve(const gl::Functions& gl, std::size_t count) {
    if (count <= capacity_) return false;
    const std::size_t capacity = std::max(least_, count * halves_ / 2);
    auto made = gl::Buffer::create(gl, bytes(capacity), nullptr, GL_DYNAMIC_STORAGE_BIT, what_);
    if (!made) return tl::unexpected(made.error());
    buffer_ = std::move(*made);
    capacity_ = capacity;
    return true;
  }
  /// Frees the buffer; the next reserve() makes one for what is needed then.
  void trim() { buffer_ = {}, capacity_ = 0; }
  /// The next frame uses the next region.
  void advance() { region_ = (region_ + 1) % kRegions; }
  /// Number of elements before the region of this frame.
  std::size_t begin() const { return region_ * capacity_; }
  /// Writes to the region of this frame, from its element `first` on.
  void write(std::size_t first, std::span<const Element> elements) const {
    buffer_.write((begin() + first) * sizeof(Element), elements.size_bytes(), elements.data());
  }
  const gl::Buffer& buffer() const { return buffer_; }
  /// Bytes of a buffer whose regions hold so many elements.
  static constexpr std::size_t bytes(std::size_t count) { return kRegions * count * sizeof(Element); }

 private:
  static constexpr std::size_t kRegions = 3;

  const char* what_;
  std::size_t least_, halves_, capacity_ = 0;  // elements of a region
  std::size_t region_ = 0;
  gl::Buffer buffer_;
};

}  // namespace sightline::gpuscene
