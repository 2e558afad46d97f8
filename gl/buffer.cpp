#include "sightline/gl/internal/buffer.h"

#include <bit>
#include <cassert>
#include <cstring>
#include <limits>
#include <new>

#include <fmt/format.h>

#include "sightline/core/internal/store.h"
#include "sightline/core/large_array.h"

namespace sightline::gl {
namespace {

constexpr GLenum kExternalMemory = 0x9160;  // GL_EXTERNAL_VIRTUAL_MEMORY_BUFFER_AMD, which glcorearb.h does not have
constexpr std::size_t kLeastPinned = std::size_t(4) << 20, kMostPinned = std::size_t(1) << 36;  // bytes
constexpr std::size_t kOverRead = 256;  // bytes after the end that a rasteriser may read in vain

/// Bytes of a texel of the formats that texture buffers allow (OpenGL 4.5 core, table 8.23); 0 for others.
std::size_t texel_bytes(GLenum format) {
  switch (format) {
    case GL_R8:
    case GL_R8I:
    case GL_R8UI:
      return 1;
    case GL_R16:
    case GL_R16F:
    case GL_R16I:
    case GL_R16UI:
    case GL_RG8:
    case GL_RG8I:
    case GL_RG8UI:
      return 2;
    case GL_R32F:
    case GL_R32I:
    case GL_R32UI:
    case GL_RG16:
    case GL_RG16F:
    case GL_RG16I:
    case GL_RG16UI:
    case GL_RGBA8:
    case GL_RGBA8I:
    case GL_RGBA8UI:
      return 4;
    case GL_RG32F:
    case GL_RG32I:
    case GL_RG32UI:
    case GL_RGBA16:
    case GL_RGBA16F:
    case GL_RGBA16I:
    case GL_RGBA16UI:
      return 8;
    case GL_RGB32F:
    case GL_RGB32I:
    case GL_RGB32UI:
      return 12;
    case GL_RGBA32F:
    case GL_RGBA32I:
    case GL_RGBA32UI:
      return 16;
    default:
      return 0;
  }
}

/// The size to allocate for so many bytes. llvmpipe compiles a program for what it takes for properties of its
/// textures, those of buffers included: whether their size is a power of two, and whether its second byte is 0, where
/// textures have their number of levels. With sizes that are neither, one scene's programs serve all.
std::size_t ordinary_size(std::size_t bytes) {
  while (std::has_single_bit(bytes) || (bytes >> 8 & 0xff) == 0) bytes += 256;
  return bytes;
}

void label(const Functions& gl, GLenum kind, GLuint name, std::string_view what) {
  if (!what.empty()) gl.ObjectLabel(kind, name, static_cast<GLsizei>(what.size()), what.data());
}

}  // namespace

/// What was submitted may still read the memory.
void Buffer::ReleasePinned::operator()(void* memory) const {
  if (gl->pinned_memory) gl->Finish();
  core::release_lines(memory, bytes);
}

/// Gives the object memory of ours. False where that cannot be had; the driver's is to be taken then.
bool Buffer::pin(const Functions& gl, std::size_t bytes, const void* data) {
  void* memory = nullptr;
  try {
    memory = core::allocate_lines(bytes + kOverRead);
  } catch (const std::bad_alloc&) {
    return false;
  }
  memory_ = {memory, ReleasePinned{&gl, bytes + kOverRead}};
  if (data) std::memcpy(memory, data, bytes);
  gl.BindBuffer(kExternalMemory, handle_.name());
  gl.BufferData(kExternalMemory, static_cast<GLsizeiptr>(bytes), memory, GL_DYNAMIC_DRAW);
  gl.BindBuffer(kExternalMemory, 0);
  if (check_error(gl) == GL_NO_ERROR) return true;
  memory_.reset();
  return false;
}

core::Expected<Buffer> Buffer::create(const Functions& gl, std::size_t bytes, const void* data, GLbitfield flags,
                                      std::string_view what) {
  if (bytes == 0 || bytes > static_cast<std::size_t>(std::numeric_limits<GLsizeiptr>::max())) {
    return core::fail(fmt::format("GL buffer '{}': cannot hold {} bytes", what, bytes));
  }
  discard_errors(gl);
  const GLuint name = create_name<&Functions::CreateBuffers>(gl);
  if (auto made = check_names(gl, {name}, fmt::format("buffer '{}'", what)); !made) return tl::unexpected(made.error());
  Buffer buffer;
  buffer.handle_ = Handle<&Functions::DeleteBuffers>(gl, name);
  const bool pinned = gl.pinned_memory && bytes >= kLeastPinned && bytes <= kMostPinned &&
                      (flags & ~GLbitfield(GL_DYNAMIC_STORAGE_BIT)) == 0 && buffer.pin(gl, bytes, data);
  const bool written = data != nullptr && (flags & GL_DYNAMIC_STORAGE_BIT) == 0;
  const auto allocated = static_cast<GLsizeiptr>(written ? bytes : ordinary_size(bytes));
  if (!pinned) gl.NamedBufferStorage(name, allocated, written ? data : nullptr, flags);
  if (const GLenum error = check_error(gl); error != GL_NO_ERROR) {
    return core::fail(fmt::format("GL buffer '{}': {} bytes wanted: {}", what, bytes, error_name(error)));
  }
  buffer.bytes_ = bytes;
  if (!pinned && !written && data) buffer.write(0, bytes, data);
  label(gl, GL_BUFFER, name, what);
  return buffer;
}

core::Expected<Buffer> Buffer::enlarged(const Functions& gl, std::size_t bytes, GLbitfield flags,
                                        std::string_view what) const {
  assert(bytes >= bytes_);
  auto larger = create(gl, bytes, nullptr, flags, what);
  if (larger && bytes_ > 0) gl.CopyNamedBufferSubData(id(), larger->id(), 0, 0, static_cast<GLsizeiptr>(bytes_));
  return larger;
}

void Buffer::write(std::size_t offset, std::size_t bytes, const void* data) const {
  assert(offset <= bytes_ && bytes <= bytes_ - offset);
  if (bytes == 0) return;
  handle_.gl().NamedBufferSubData(id(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
}

void Buffer::fill(std::size_t offset, std::size_t bytes, std::uint8_t value) const {
  assert(offset <= bytes_ && bytes <= bytes_ - offset);
  if (bytes == 0) return;
  // Mesa applies an application's unpack parameters when it reads the value.
  for (const GLenum parameter : {GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_ROWS}) handle_.gl().PixelStorei(parameter, 0);
  // For a format of one byte Mesa calls memset once.
  handle_.gl().ClearNamedBufferSubData(id(), GL_R8UI, static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes),
                                       GL_RED_INTEGER, GL_UNSIGNED_BYTE, &value);
}

void Buffer::read(std::size_t offset, std::size_t bytes, void* data) const {
  assert(offset <= bytes_ && bytes <= bytes_ - offset);
  if (bytes == 0) return;
  handle_.gl().GetNamedBufferSubData(id(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), data);
}

void* Buffer::map(std::size_t offset, std::size_t bytes, GLbitfield access) const {
  assert(offset <= bytes_ && bytes <= bytes_ - offset && bytes > 0);
  return handle_.gl().MapNamedBufferRange(id(), static_cast<GLintptr>(offset), static_cast<GLsizeiptr>(bytes), access);
}

core::Expected<TextureBuffer> TextureBuffer::create(const Functions& gl, const Buffer& buffer, GLenum format,
                                                    std::string_view what) {
  const std::size_t per_texel = texel_bytes(format);
  if (per_texel == 0) {
    return core::fail(fmt::format("GL texture buffer '{}': format {:#06x} is not one for buffers", what, format));
  }
  GLint64 limit = 0;
  gl.GetInteger64v(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
  const std::size_t texels = buffer.size() / per_texel;
  if (texels > static_cast<std::size_t>(limit)) {
    return core::fail(fmt::format("GL texture buffer '{}': {} texels ({} bytes) wanted, the context's limit is {}",
                                  what, texels, buffer.size(), limit));
  }
  discard_errors(gl);
  const GLuint name = create_name<&Functions::CreateTextures>(gl, GL_TEXTURE_BUFFER);
  if (auto made = check_names(gl, {name}, fmt::format("texture buffer '{}'", what)); !made)
    return tl::unexpected(made.error());
  TextureBuffer view;
  view.handle_ = Handle<&Functions::DeleteTextures>(gl, name);
  gl.TextureBuffer(name, format, buffer.id());
  if (const GLenum error = check_error(gl); error != GL_NO_ERROR) {
    return core::fail(fmt::format("GL texture buffer '{}': over {} bytes: {}", what, buffer.size(), error_name(error)));
  }
  view.texels_ = static_cast<std::int64_t>(texels);
  label(gl, GL_TEXTURE, name, what);
  return view;
}

core::Expected<TexelArray> TexelArray::create(const Functions& gl, std::size_t bytes, const void* data, GLenum format,
                                              std::string_view what, GLbitfield flags) {
  TexelArray made;
  auto done = core::store(Buffer::create(gl, bytes, data, flags, what), made.buffer);
  if (done) done = core::store(TextureBuffer::create(gl, made.buffer, format, what), made.texels);
  if (!done) return tl::unexpected(done.error());
  return made;
}

}  // namespace sightline::gl
