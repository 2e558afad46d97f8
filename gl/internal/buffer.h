// Buffer objects with immutable storage, and texture buffers, through which every shader stage can read them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "sightline/core/error.h"
#include "sightline/gl/functions.h"
#include "sightline/gl/internal/handle.h"

namespace sightline::gl {

/// A buffer of fixed size. Move-only; a default-made one is empty (id 0, size 0).
///
/// With Functions::pinned_memory, large ones lie in memory of ours, in huge pages that exist from when they are written
/// to. A software rasteriser's own buffers are zeroed first, in small pages, headroom and all: that took half of the
/// time until the first image of 5 million items.
class Buffer {
 public:
  Buffer() = default;
  Buffer(Buffer&&) noexcept = default;
  Buffer& operator=(Buffer&& other) noexcept {
    Buffer old(std::move(*this));  // freed on return: the object before its memory
    memory_ = std::move(other.memory_);
    handle_ = std::move(other.handle_);
    bytes_ = other.bytes_;
    return *this;
  }

  /// Allocates `bytes` > 0 with glNamedBufferStorage. `data` is copied; null leaves the contents undefined. `flags` are
  /// GL's: GL_DYNAMIC_STORAGE_BIT for write(), GL_MAP_…_BIT for map(). `what` names the contents in errors and debug
  /// output. Fails for 0 bytes, and when the driver has not enough memory.
  static core::Expected<Buffer> create(const Functions& gl, std::size_t bytes, const void* data, GLbitfield flags,
                                       std::string_view what);
  /// A buffer that holds these values.
  template <class T, std::size_t N>
  static core::Expected<Buffer> create(const Functions& gl, std::span<T, N> values, GLbitfield flags,
                                       std::string_view what) {
    static_assert(std::is_trivially_copyable_v<T>);
    return create(gl, values.size_bytes(), values.data(), flags, what);
  }

  /// A buffer of `bytes`, at least size(), that begins with what this one holds, which may be nothing. The GPU copies.
  core::Expected<Buffer> enlarged(const Functions& gl, std::size_t bytes, GLbitfield flags,
                                  std::string_view what) const;

  GLuint id() const { return handle_.name(); }
  std::size_t size() const { return bytes_; }  ///< bytes
  /// The contents, where they lie in memory of ours; else null. May be written to while nothing that was submitted
  /// reads there.
  void* memory() const { return memory_.get(); }

  /// Copies into [offset, offset + bytes), which must lie inside. Needs GL_DYNAMIC_STORAGE_BIT.
  void write(std::size_t offset, std::size_t bytes, const void* data) const;
  /// Sets every byte of [offset, offset + bytes), which must lie inside, on the GPU.
  void fill(std::size_t offset, std::size_t bytes, std::uint8_t value) const;
  /// Copies out of [offset, offset + bytes), which must lie inside. Waits for the GPU: for tests and final results.
  void read(std::size_t offset, std::size_t bytes, void* data) const;
  /// A persistent mapping, by glMapNamedBufferRange, that ends with the buffer; null when the driver refuses.
  void* map(std::size_t offset, std::size_t bytes, GLbitfield access) const;

 private:
  struct ReleasePinned {
    const Functions* gl;
    std::size_t bytes;
    void operator()(void* memory) const;
  };
  bool pin(const Functions& gl, std::size_t bytes, const void* data);

  std::unique_ptr<void, ReleasePinned> memory_{nullptr, {}};  ///< outlives the object
  Handle<&Functions::DeleteBuffers> handle_;
  std::size_t bytes_ = 0;
};

/// A buffer as a one-dimensional array of texels (samplerBuffer and similar). Borrows the buffer, which must outlive
/// it. Move-only.
class TextureBuffer {
 public:
  TextureBuffer() = default;

  /// Views the whole buffer. `format` is a sized format that texture buffers allow (GL_R32UI, GL_RGB32F, …). Fails for
  /// other formats and for more texels than the context can address, which GL itself would silently cut off.
  static core::Expected<TextureBuffer> create(const Functions& gl, const Buffer& buffer, GLenum format,
                                              std::string_view what);

  GLuint id() const { return handle_.name(); }
  std::int64_t texels() const { return texels_; }

 private:
  Handle<&Functions::DeleteTextures> handle_;
  std::int64_t texels_ = 0;
};

/// A buffer that shaders read as texels.
struct TexelArray {
  Buffer buffer;
  TextureBuffer texels;

  /// See Buffer::create() and TextureBuffer::create().
  static core::Expected<TexelArray> create(const Functions& gl, std::size_t bytes, const void* data, GLenum format,
                                           std::string_view what, GLbitfield flags = GL_DYNAMIC_STORAGE_BIT);
};

}  // namespace sightline::gl
