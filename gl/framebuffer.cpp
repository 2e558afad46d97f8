#include "sightline/gl/internal/framebuffer.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <string>

#include <fmt/format.h>

#include "sightline/core/internal/store.h"

namespace sightline::gl {
namespace {

constexpr std::size_t kMaxColors = 8;  // GL 4.5 guarantees this many

std::string status_name(GLenum status) {
  switch (status) {
    case GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT:
      return "incomplete attachment";
    case GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT:
      return "missing attachment";
    case GL_FRAMEBUFFER_INCOMPLETE_DRAW_BUFFER:
      return "incomplete draw buffer";
    case GL_FRAMEBUFFER_INCOMPLETE_READ_BUFFER:
      return "incomplete read buffer";
    case GL_FRAMEBUFFER_UNSUPPORTED:
      return "unsupported combination of formats";
    case GL_FRAMEBUFFER_INCOMPLETE_MULTISAMPLE:
      return "attachments differ in samples";
    case GL_FRAMEBUFFER_INCOMPLETE_LAYER_TARGETS:
      return "attachments differ in layers";
    case GL_FRAMEBUFFER_UNDEFINED:
      return "the context has no window";
    default:
      return fmt::format("status {:#06x}", status);
  }
}

core::Expected<Handle<&Functions::DeleteFramebuffers>> make(const Functions& gl, std::string_view what) {
  discard_errors(gl);
  const GLuint name = create_name<&Functions::CreateFramebuffers>(gl);
  if (auto made = check_names(gl, {name}, fmt::format("framebuffer '{}'", what)); !made)
    return tl::unexpected(made.error());
  if (!what.empty()) gl.ObjectLabel(GL_FRAMEBUFFER, name, static_cast<GLsizei>(what.size()), what.data());
  return Handle<&Functions::DeleteFramebuffers>(gl, name);
}

}  // namespace

core::Expected<void> check_complete(const Functions& gl, GLuint name, std::string_view what) {
  const GLenum status = gl.CheckNamedFramebufferStatus(name, GL_DRAW_FRAMEBUFFER);
  if (const GLenum error = check_error(gl); error != GL_NO_ERROR) {
    return core::fail(fmt::format("GL framebuffer '{}': {}", what, error_name(error)));
  }
  if (status == GL_FRAMEBUFFER_COMPLETE) return {};
  return core::fail(fmt::format("GL framebuffer '{}' is not complete: {}", what, status_name(status)));
}

core::Expected<Framebuffer> Framebuffer::create(const Functions& gl, std::span<const Attachment> attachments,
                                                std::string_view what) {
  Framebuffer framebuffer;
  if (auto done = core::store(make(gl, what), framebuffer.handle_); !done) return tl::unexpected(done.error());
  std::array<GLenum, kMaxColors> outputs{};
  outputs.fill(GL_NONE);
  GLsizei output_count = 0;
  GLenum read_from = GL_NONE;
  for (const Attachment& attachment : attachments) {
    assert(attachment.texture);
    gl.NamedFramebufferTexture(framebuffer.id(), attachment.point, attachment.texture->id(), attachment.level);
    const GLenum color = attachment.point - GL_COLOR_ATTACHMENT0;
    if (color >= kMaxColors) continue;
    outputs[color] = attachment.point;
    output_count = std::max(output_count, static_cast<GLsizei>(color) + 1);
    read_from = read_from == GL_NONE ? attachment.point : std::min(read_from, attachment.point);
  }
  gl.NamedFramebufferDrawBuffers(framebuffer.id(), std::max(output_count, 1), outputs.data());
  gl.NamedFramebufferReadBuffer(framebuffer.id(), read_from);
  if (auto complete = check_complete(gl, framebuffer.id(), what); !complete) return tl::unexpected(complete.error());
  return framebuffer;
}

core::Expected<Framebuffer> Framebuffer::create_attachmentless(const Functions& gl, int width, int height,
                                                               std::string_view what) {
  Framebuffer framebuffer;
  if (auto done = core::store(make(gl, what), framebuffer.handle_); !done) return tl::unexpected(done.error());
  gl.NamedFramebufferParameteri(framebuffer.id(), GL_FRAMEBUFFER_DEFAULT_WIDTH, width);
  gl.NamedFramebufferParameteri(framebuffer.id(), GL_FRAMEBUFFER_DEFAULT_HEIGHT, height);
  gl.NamedFramebufferDrawBuffer(framebuffer.id(), GL_NONE);
  gl.NamedFramebufferReadBuffer(framebuffer.id(), GL_NONE);
  if (auto complete = check_complete(gl, framebuffer.id(), what); !complete) return tl::unexpected(complete.error());
  return framebuffer;
}

void Framebuffer::bind() const {
  handle_.gl().BindFramebuffer(GL_FRAMEBUFFER, id());
}

}  // namespace sightline::gl
