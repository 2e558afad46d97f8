#include "sightline/gl/texture.h"

#include <cassert>
#include <limits>

#include <fmt/format.h>

namespace sightline::gl {
namespace {

core::Expected<void> check_size(const Functions& gl, int width, int height, std::string_view what, int samples) {
  GLint max_size = 0;
  GLint max_samples = 0;
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &max_size);
  gl.GetIntegerv(GL_MAX_SAMPLES, &max_samples);
  if (width <= 0 || height <= 0 || width > max_size || height > max_size) {
    return core::fail(fmt::format("GL texture '{}': {}x{} pixels wanted, the context's range is 1 to {} each way", what,
                                  width, height, max_size));
  }
  if (samples < 1 || samples > max_samples) {
    return core::fail(
        fmt::format("GL texture '{}': {} samples wanted, the context's range is 1 to {}", what, samples, max_samples));
  }
  return {};
}

/// Rows without padding for the life of the object; then GL's value from before, which may be an application's.
class TightRows {
 public:
  TightRows(const Functions& gl, GLenum parameter) : gl_(gl), parameter_(parameter) {
    gl.GetIntegerv(parameter, &before_);
    gl.PixelStorei(parameter, 1);
  }
  TightRows(const TightRows&) = delete;
  TightRows& operator=(const TightRows&) = delete;
  ~TightRows() { gl_.PixelStorei(parameter_, before_); }

 private:
  const Functions& gl_;
  GLenum parameter_;
  GLint before_ = 4;
};

}  // namespace

core::Expected<Texture2D> Texture2D::create(const Functions& gl, int width, int height, GLenum format,
                                            std::string_view what, int samples, int levels) {
  assert(levels >= 1 && (samples == 1 || levels == 1));
  if (auto sized = check_size(gl, width, height, what, samples); !sized) return tl::unexpected(sized.error());
  discard_errors(gl);
  GLuint name = 0;
  gl.CreateTextures(samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D, 1, &name);
  Texture2D texture;
  texture.handle_ = Handle<detail::delete_texture>(gl, name);
  if (samples > 1) {
    gl.TextureStorage2DMultisample(name, samples, format, width, height, GL_TRUE);
  } else {
    gl.TextureStorage2D(name, levels, format, width, height);
    gl.TextureParameteri(name, GL_TEXTURE_MIN_FILTER, levels > 1 ? GL_NEAREST_MIPMAP_NEAREST : GL_NEAREST);
    gl.TextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl.TextureParameteri(name, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TextureParameteri(name, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }
  if (const GLenum error = check_error(gl); error != GL_NO_ERROR) {
    return core::fail(fmt::format("GL texture '{}': {}x{} pixels of format {:#06x}, {} samples, {} levels wanted: {}",
                                  what, width, height, format, samples, levels, error_name(error)));
  }
  if (!what.empty()) gl.ObjectLabel(GL_TEXTURE, name, static_cast<GLsizei>(what.size()), what.data());
  texture.width_ = width;
  texture.height_ = height;
  texture.samples_ = samples;
  texture.levels_ = levels;
  texture.format_ = format;
  return texture;
}

void Texture2D::write(GLenum format, GLenum type, std::span<const std::byte> pixels) const {
  assert(id() && samples_ == 1);
  const TightRows rows(handle_.gl(), GL_UNPACK_ALIGNMENT);
  handle_.gl().TextureSubImage2D(id(), 0, 0, 0, width_, height_, format, type, pixels.data());
}

void Texture2D::read(int level, GLenum format, GLenum type, std::span<std::byte> pixels) const {
  assert(id() && samples_ == 1 && level >= 0 && level < levels_);
  assert(pixels.size() <= static_cast<std::size_t>(std::numeric_limits<GLsizei>::max()));
  const TightRows rows(handle_.gl(), GL_PACK_ALIGNMENT);
  handle_.gl().GetTextureImage(id(), level, format, type, static_cast<GLsizei>(pixels.size()), pixels.data());
}

}  // namespace sightline::gl
