// Framebuffer objects.
#pragma once

#include <span>
#include <string_view>

#include "sightline/core/error.h"
#include "sightline/gl/functions.h"
#include "sightline/gl/internal/handle.h"
#include "sightline/gl/internal/texture.h"

namespace sightline::gl {

/// What is attached where: GL_COLOR_ATTACHMENTi, GL_DEPTH_ATTACHMENT, GL_DEPTH_STENCIL_ATTACHMENT.
struct Attachment {
  GLenum point = GL_NONE;
  const Texture2D* texture = nullptr;
  int level = 0;
};

/// A complete framebuffer. Borrows its textures: they must live as long. Move-only.
class Framebuffer {
 public:
  Framebuffer() = default;

  /// Attaches and switches on fragment output i for each GL_COLOR_ATTACHMENTi given; reading is from the lowest of
  /// them. Fails with GL's reason when the combination is not complete.
  static core::Expected<Framebuffer> create(const Functions& gl, std::span<const Attachment> attachments,
                                            std::string_view what);

  /// Nothing to write to, but complete: what draws that only feed back, store or count need bound in a context without
  /// a surface.
  static core::Expected<Framebuffer> create_attachmentless(const Functions& gl, int width, int height,
                                                           std::string_view what);

  GLuint id() const { return handle_.name(); }

  /// Binds for drawing and reading. The viewport is the caller's.
  void bind() const;

 private:
  Handle<&Functions::DeleteFramebuffers> handle_;
};

}  // namespace sightline::gl
