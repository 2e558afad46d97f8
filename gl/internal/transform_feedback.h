// Transform feedback objects: what the vertex and geometry stages write into buffers, in order, without barriers.
#pragma once

#include "sightline/gl/functions.h"
#include "sightline/gl/internal/handle.h"

namespace sightline::gl {

/// Owns a transform feedback object. Move-only.
class TransformFeedback {
 public:
  TransformFeedback() = default;
  explicit TransformFeedback(const Functions& gl)
      : handle_(gl, create_name<&Functions::CreateTransformFeedbacks>(gl)) {}

  GLuint id() const { return handle_.name(); }

  /// Feedback buffer 0: `size` bytes from `offset`, both multiples of 4.
  void set_buffer(GLuint buffer, std::size_t offset, std::size_t size) const {
    handle_.gl().TransformFeedbackBufferRange(id(), 0, buffer, GLintptr(offset), GLsizeiptr(size));
  }
  /// Binds it and starts writing points; end() stops, and leaves none bound.
  void begin_points() const {
    handle_.gl().BindTransformFeedback(GL_TRANSFORM_FEEDBACK, id());
    handle_.gl().BeginTransformFeedback(GL_POINTS);
  }
  void end() const {
    handle_.gl().EndTransformFeedback();
    handle_.gl().BindTransformFeedback(GL_TRANSFORM_FEEDBACK, 0);
  }

 private:
  Handle<&Functions::DeleteTransformFeedbacks> handle_;
};

}  // namespace sightline::gl
