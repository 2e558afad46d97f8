// Two-dimensional textures with immutable storage, mostly render targets.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "sightline/core/error.h"
#include "sightline/gl/functions.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/handle.h"

namespace sightline::gl {

/// A 2D texture, multisampled when made with more than one sample. Move-only; a default-made one is empty (id 0).
/// Filters are nearest, edges clamped.
class Texture2D {
 public:
  Texture2D() = default;

  /// Allocates `width` x `height` pixels of a sized format with `levels` mip levels (1 when multisampled). Fails for
  /// sizes or samples that the context does not support, and without enough memory. `what` names the texture in errors
  /// and debug output.
  static core::Expected<Texture2D> create(const Functions& gl, int width, int height, GLenum format,
                                          std::string_view what, int samples = 1, int levels = 1);

  GLuint id() const { return handle_.name(); }
  int width() const { return width_; }      ///< pixels
  int height() const { return height_; }    ///< pixels
  int samples() const { return samples_; }  ///< at least as many as were asked for
  int levels() const { return levels_; }
  GLenum format() const { return format_; }

  /// Replaces level 0. `pixels` are rows bottom to top without padding, as `format` and `type` say.
  void write(GLenum format, GLenum type, std::span<const std::byte> pixels) const;
  /// Reads a level, rows bottom to top without padding; `pixels` must have room for all of it. Waits for the GPU. Not
  /// for multisampled textures: blit to a single-sampled one first.
  void read(int level, GLenum format, GLenum type, std::span<std::byte> pixels) const;

 private:
  Handle<&Functions::DeleteTextures> handle_;
  int width_ = 0;
  int height_ = 0;
  int samples_ = 1;
  int levels_ = 1;
  GLenum format_ = GL_NONE;
};

}  // namespace sightline::gl
