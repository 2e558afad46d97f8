// Query objects: what a draw has counted or how long it took.
#pragma once

#include <optional>

#include "sightline/gl/functions.h"
#include "sightline/gl/internal/handle.h"

namespace sightline::gl {

/// Owns a query object of one target (GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, GL_PRIMITIVES_GENERATED, …). Move-only.
class Query {
 public:
  Query() = default;
  Query(const Functions& gl, GLenum target)
      : handle_(gl, create_name<&Functions::CreateQueries>(gl, target)), target_(target) {}

  /// `stream`: of a geometry stage, for targets that have one result per stream; the same in end(). Both do nothing
  /// when empty().
  void begin(GLuint stream = 0) const {
    if (!empty()) handle_.gl().BeginQueryIndexed(target_, stream, handle_.name());
  }
  void end(GLuint stream = 0) const {
    if (!empty()) handle_.gl().EndQueryIndexed(target_, stream);
  }
  /// Result of the last begin() and end(). Waits for the GPU.
  GLuint result() const { return read(GL_QUERY_RESULT, 0); }
  /// The result, or nothing while the GPU has not finished. Never waits.
  std::optional<GLuint> result_if_known() const {
    constexpr GLuint kUnknown = ~0u;
    const GLuint value = read(GL_QUERY_RESULT_NO_WAIT, kUnknown);
    return value == kUnknown ? std::nullopt : std::optional(value);
  }
  /// True when default-made, and where the driver has made none.
  bool empty() const { return handle_.name() == 0; }

 private:
  /// Returns `value` unchanged while there is no result.
  GLuint read(GLenum what, GLuint value) const {
    handle_.gl().BindBuffer(GL_QUERY_BUFFER, 0);  // an application's buffer would take the result
    handle_.gl().GetQueryObjectuiv(handle_.name(), what, &value);
    return value;
  }

  Handle<&Functions::DeleteQueries> handle_;
  GLenum target_ = GL_NONE;
};

}  // namespace sightline::gl
