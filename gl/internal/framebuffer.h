// Framebuffer objects.
#pragma once

#include <span>
#include <string_view>

#include "sightline/core/error.h"
#include "sightline/gl/functions.h"
#include "sightline/gl/internal/handle.h"
#include "sightline/gl/internal/texture.h"

namespace sightline::gl {

/// A texture and its point: GL_COLOR_ATTACHMENTi, GL_DEPTH_ATTACHMENT, GL_DEPTH_STENCIL_ATTACHMENT.
struct Attachment {
  GLenum point = GL_NONE;
  const Texture2D* texture = nullptr;
  int level = 0;
};

/// A complete framebuffer. Borrows its textures, which must outlive it. Move-only.
class Framebuffer {
 public:
  Framebuffer() = default;

  /// Attaches the textures and enables fragment output i for each GL_COLOR_ATTACHMENTi. Reads come from the lowest of
  /// them. Fails with GL's reason when the combination is not complete.
  static core::Expected<Framebuffer> create(const Functions& gl, std::span<const Attachment> attachments,
                                            std::string_view what);

  /// Complete, but with nothing to write to. In a context without a surface, draws that only feed back, store or count
  /// need it bound.
  static core::Expected<Framebuffer> create_attachmentless(const Functions& gl, int width, int height,
                                                           std::string_view what);

  GLuint id() const { return handle_.name(); }

  /// Binds for drawing and reading. The caller sets the viewport.
  void bind() const;

 private:
  Handle<&Functions::DeleteFramebuffers> handle_;
};

/// Fails with GL's reason when draws to that framebuffer would fail. Name 0 is the window's. No GL error may be
/// pending.
core::Expected<void> check_complete(const Functions& gl, GLuint name, std::string_view what);

}  // namespace sightline::gl
