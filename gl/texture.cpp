#include "sightline/gl/internal/texture.h"

#include <algorithm>
#include <array>
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
  if (gl.workarounds[Workaround::kFourSamples]) max_samples = std::min(max_samples, 4);
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

/// GL's state for pixel transfers in one direction. Parameters of image stacks are among it, although two-dimensional
/// transfers ignore them: a driver of NVIDIA's counts them when it checks whether the memory suffices.
struct Transfer {
  GLenum buffer, buffer_binding;
  std::array<GLenum, 7> parameters;  // the first one is the alignment
};
constexpr Transfer kPack = {GL_PIXEL_PACK_BUFFER,
                            GL_PIXEL_PACK_BUFFER_BINDING,
                            {GL_PACK_ALIGNMENT, GL_PACK_ROW_LENGTH, GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_ROWS,
                             GL_PACK_SWAP_BYTES, GL_PACK_IMAGE_HEIGHT, GL_PACK_SKIP_IMAGES}};
constexpr Transfer kUnpack = {GL_PIXEL_UNPACK_BUFFER,
                              GL_PIXEL_UNPACK_BUFFER_BINDING,
                              {GL_UNPACK_ALIGNMENT, GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_ROWS,
                               GL_UNPACK_SWAP_BYTES, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_IMAGES}};

/// While it lives, pixels lie in the caller's memory without gaps. Its destructor restores GL's former values, which
/// may be an application's.
class TightPixels {
 public:
  TightPixels(const Functions& gl, const Transfer& transfer) : gl_(gl), transfer_(transfer) {
    gl.GetIntegerv(transfer.buffer_binding, &buffer_before_);
    gl.BindBuffer(transfer.buffer, 0);
    for (std::size_t i = 0; i < transfer.parameters.size(); ++i) {
      gl.GetIntegerv(transfer.parameters[i], &before_[i]);
      gl.PixelStorei(transfer.parameters[i], i == 0 ? 1 : 0);
    }
  }
  TightPixels(const TightPixels&) = delete;
  TightPixels& operator=(const TightPixels&) = delete;
  ~TightPixels() {
    gl_.BindBuffer(transfer_.buffer, static_cast<GLuint>(buffer_before_));
    for (std::size_t i = 0; i < before_.size(); ++i) gl_.PixelStorei(transfer_.parameters[i], before_[i]);
  }

 private:
  const Functions& gl_;
  const Transfer& transfer_;
  GLint buffer_before_ = 0;
  std::array<GLint, 7> before_{};
};

}  // namespace

core::Expected<Texture2D> Texture2D::create(const Functions& gl, int width, int height, GLenum format,
                                            std::string_view what, int samples, int levels) {
  assert(levels >= 1 && (samples == 1 || levels == 1));
  if (auto sized = check_size(gl, width, height, what, samples); !sized) return tl::unexpected(sized.error());
  discard_errors(gl);
  const GLuint name =
      create_name<&Functions::CreateTextures>(gl, samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D);
  if (auto made = check_names(gl, {name}, fmt::format("texture '{}'", what)); !made)
    return tl::unexpected(made.error());
  Texture2D texture;
  texture.handle_ = Handle<&Functions::DeleteTextures>(gl, name);
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
  texture.samples_ = samples;  // or more: the next number that the context can do
  if (samples > 1) gl.GetTextureLevelParameteriv(name, 0, GL_TEXTURE_SAMPLES, &texture.samples_);
  texture.levels_ = levels;
  texture.format_ = format;
  return texture;
}

void Texture2D::write(GLenum format, GLenum type, std::span<const std::byte> pixels) const {
  assert(id() && samples_ == 1);
  const TightPixels tight(handle_.gl(), kUnpack);
  handle_.gl().TextureSubImage2D(id(), 0, 0, 0, width_, height_, format, type, pixels.data());
}

void Texture2D::read(int level, GLenum format, GLenum type, std::span<std::byte> pixels) const {
  assert(id() && samples_ == 1 && level >= 0 && level < levels_);
  assert(pixels.size() <= static_cast<std::size_t>(std::numeric_limits<GLsizei>::max()));
  const TightPixels tight(handle_.gl(), kPack);
  handle_.gl().GetTextureImage(id(), level, format, type, static_cast<GLsizei>(pixels.size()), pixels.data());
}

}  // namespace sightline::gl
